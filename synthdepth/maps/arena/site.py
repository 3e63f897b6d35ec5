"""What stands along the lanes and round the arena: lamps, cables, barriers, cars, people, fence."""

import numpy as np

from synthdepth.maps.arena.plan import EDGE_M, LANE_M, Plot
from synthdepth.maps.arena.thin import bunting
from synthdepth.maps.arena.zone import Zone, at_ground
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.furniture.poles import catenary, utility_line, wires
from synthdepth.maps.furniture.roadworks import (
    barrier_crowd,
    barrier_jersey,
    skip,
    traffic_cone,
)
from synthdepth.maps.furniture.signs import street_lamps
from synthdepth.maps.furniture.structures import (
    billboard,
    lattice_mast,
    power_line,
    tower_crane,
    water_tower,
)
from synthdepth.maps.geometry import Model, copies, place, yaw_matrix
from synthdepth.maps.people import people
from synthdepth.maps.placement import distance_to
from synthdepth.maps.stadium.masts import stadium_mast
from synthdepth.maps.vegetation.shrubs import bushes, hedge
from synthdepth.maps.vegetation.trees import plant
from synthdepth.maps.vehicles.vehicle import park

_CABLE = (0.03, 0.03, 0.032)


def lane_lamps(rng: np.random.Generator, plots: list[Plot], zone: Zone) -> list[Model]:
    """Lamps at the zones' edges, cables and pennants from one to the next."""
    models: list[Model] = []
    kinds = ("straight", "cobra", "lantern")
    feet: dict[str, list] = {kind: [] for kind in kinds}
    for plot in plots:
        if not plot.near:
            continue
        kind = kinds[int(rng.choice(3, p=(0.5, 0.35, 0.15)))]
        x = plot.centre_m[0] + plot.size_m[0] / 2 + 0.7
        y0, y1 = plot.centre_m[1] + plot.size_m[1] * np.array([-0.5, 0.5])
        at = np.arange(y0 + 2, y1, rng.uniform(18, 30))
        post = np.column_stack([np.full(len(at), x), at, np.zeros(len(at))])
        feet[kind].append(post)
        if len(at) > 1 and rng.random() < 0.3 + 0.7 * zone.thin:
            hook = post + [0, 0, {"straight": 6.7, "cobra": 7.2, "lantern": 3.0}[kind]]
            lines = catenary(hook[:-1], hook[1:], rng.uniform(0.012, 0.05))
            models.append({("paint", "wire"): wires(lines, 0.011, _CABLE)})
            if rng.random() < 0.5:
                models.append({("fabric", "wire"): bunting(rng, lines, zone.palette)})
        # Across the lane too, to what stands there.
        if len(at) and rng.random() < zone.thin:
            far = post + [LANE_M - 1.6, 0, 0]
            top = rng.uniform(5.0, 7.0)
            poles = wires(
                np.stack([far - [0, 0, 0.05], far + [0, 0, top]], 1), 0.06, (0.2, 0.2, 0.2), 6
            )
            over = catenary(post + [0, 0, top - 0.3], far + [0, 0, top - 0.1], 0.03, 8)
            models.append({("paint", "pole"): poles, ("paint", "wire"): wires(over, 0.01, _CABLE)})
    for kind, posts in feet.items():
        if posts:
            at = np.concatenate(posts)
            models.append(street_lamps(rng, at, np.zeros(len(at)), kind))
    return models


def lane_things(rng: np.random.Generator, plots: list[Plot], bounds: np.ndarray) -> list[Model]:
    """Barriers, cones, skips, cars and people along the lanes."""
    near = [plot for plot in plots if plot.near]
    edges = np.array(
        [
            (*(plot.centre_m + sign * plot.size_m / 2 * axis), *axis, sign, *plot.size_m)
            for plot in near for axis in np.eye(2) for sign in (-1, 1)
        ]
    )  # fmt: skip
    models: list[Model] = []
    for template, count in ((barrier_jersey, 130), (barrier_crowd, 110), (traffic_cone, 220),
                            (skip, 26)):  # fmt: skip
        for _ in range(2):
            model = template(rng)
            at, yaw = _along(rng, edges, count // 2, 0.9)
            turn = yaw_matrix(yaw)
            models.append({k: copies(p, at_ground(at), rotation=turn) for k, p in model.items()})
    at, yaw = _along(rng, edges, 80, 1.55)
    at_3d = at_ground(at)
    models.append(park(rng, at_3d, yaw + np.pi / 2, distance_to(bounds, at)))
    at, yaw = _along(rng, edges, 70, -1.2)
    models.append(people(rng, at_ground(at), rng.uniform(0, 2 * np.pi, len(at))))
    return models


def _along(rng, edges: np.ndarray, count: int, off_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Places (count, 2) beside the zones' edges, and headings (count,) away from the zone."""
    pick = edges[rng.integers(len(edges), size=count)]
    axis, sign = pick[:, 2:4], pick[:, 4:5]
    tangent = axis[:, ::-1]
    reach = (tangent * pick[:, 5:7]).sum(axis=1, keepdims=True) / 2 - 1.5
    at = pick[:, :2] + sign * axis * off_m + tangent * rng.uniform(-1, 1, (count, 1)) * reach
    out = sign * axis
    return at, np.arctan2(out[:, 1], out[:, 0])


def landmarks(rng: np.random.Generator, plots: list[Plot], thin: float) -> list[Model]:
    """Cranes, guyed masts, water towers, floodlight masts and hoardings at corners of lanes."""
    near = [plot for plot in plots if plot.near]
    corners = np.array([p.centre_m - p.size_m / 2 - LANE_M / 2 for p in near])
    corners = corners[rng.permutation(len(corners))]
    models: list[Model] = []
    # Few large zones have fewer corners than there would be landmarks.
    spots = [[*corner, 0.0] for corner in corners[::-1]]
    inward = rng.uniform(0, 2 * np.pi)
    models.append(place(tower_crane(rng, height_m=rng.uniform(28, 48), jib_m=rng.uniform(30, 52)),
                        spots.pop(), inward))  # fmt: skip
    for _ in range(min(1 + int(rng.random() < thin), len(spots))):
        models.append(place(lattice_mast(rng, height_m=rng.uniform(20, 45)), spots.pop(), 0.3))
    for _ in range(min(int(rng.integers(3, 6)), len(spots))):
        at = spots.pop()
        mast = stadium_mast(
            rng, rng.uniform(18, 28), ("tube", "lattice")[rng.integers(2)], 2, 3, 0.6
        )
        models.append(place(mast, at, np.arctan2(-at[1], -at[0])))
    for _ in range(min(int(rng.integers(1, 4)), len(spots))):
        models.append(place(billboard(rng), spots.pop(), rng.uniform(0, 2 * np.pi)))
    side = rng.choice([-1, 1], 2)
    models.append(place(water_tower(rng), [side[0] * (EDGE_M + 22), side[1] * 200.0, 0.0], 0.0))
    return models


def planting(
    rng: np.random.Generator,
    plots: list[Plot],
    trees: np.ndarray,
    shrubs: np.ndarray,
    bounds: np.ndarray,
    far: np.ndarray,
) -> list[Model]:
    """Everything green.

    Args:
        rng: of species and sizes.
        plots: the zones; some are edged with rows of trees or hedges.
        trees, shrubs: (k, 2) places in the groves [m].
        bounds: of the flights.
        far: (k, 3) feet of the woods beyond the fence [m].
    """
    mix = (("oak", "birch", "maple"), ("pine", "spruce", "birch"), ("poplar", "fruit", "maple"))
    kinds = mix[rng.integers(len(mix))]
    spots = [trees]
    models: list[Model] = []
    for plot in plots:
        if not plot.near or plot.theme == "grove" or rng.random() > 0.4:
            continue
        # Along the lane, on its kerb.
        at = plot.centre_m - plot.size_m / 2 - [0, 0.9]
        run = np.arange(3, plot.size_m[0] - 3, rng.uniform(7, 13))
        spots.append(at + np.column_stack([run, 0 * run]))
        at = plot.centre_m - plot.size_m / 2 - [0.9, 0]
        path = at_ground(at + [[0, 3], [0, plot.size_m[1] * rng.uniform(0.3, 0.8)]])
        models.append(hedge(rng, path, rng.uniform(0.8, 2.0), 0.8))
    feet = np.concatenate([at_ground(np.concatenate(spots)), far])
    species = np.array(kinds)[rng.integers(len(kinds), size=len(feet))]
    models.append(plant(rng, feet, species, distance_to(bounds, feet), 4))
    bush = shrubs[distance_to(bounds, shrubs) < 50]
    models.append(
        bushes(rng, at_ground(bush), rng.uniform(0.6, 1.6, len(bush)), distance_to(bounds, bush))
    )
    return models


def perimeter(rng: np.random.Generator, bounds: np.ndarray) -> list[Model]:
    """The fence round the ground, the road outside with its cars and poles, pylons beyond."""
    e = EDGE_M + 4
    ring = np.array([[-e, -e, 0], [e, -e, 0], [e, e, 0], [-e, e, 0], [-e, -e, 0.0]])
    road_y = -(EDGE_M + 18.0)
    at = np.column_stack([np.linspace(-470, 470, 26), np.full(26, road_y + 6), np.zeros(26)])
    cars = np.column_stack([rng.uniform(-460, 460, 40), np.zeros(40), np.zeros(40)])
    lane = rng.choice([-1, 1], 40)
    cars[:, 1] = road_y + 1.7 * lane
    line = np.column_stack([np.linspace(-700, 700, 5), np.full(5, EDGE_M + 130.0), np.zeros(5)])
    return [
        fence(rng, ring, "chain_link", 2.4, detail=0),
        utility_line(rng, at),
        park(rng, cars, np.where(lane > 0, np.pi, 0.0), distance_to(bounds, cars)),
        power_line(rng, line),
    ]
