"""Street furniture: lamps, trees in pits, signals, signs, seats and people along the kerbs."""

import numpy as np

from synthdepth.maps.downtown.fittings import Fittings
from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.downtown.kerbside import CROSSING_M, Kerbside
from synthdepth.maps.downtown.markings import PAINT_LIFT_M
from synthdepth.maps.downtown.surface import KERB_HEIGHT_M
from synthdepth.maps.furniture.parts import DARK_STEEL, STEEL, choice
from synthdepth.maps.furniture.signals import signal_head, street_name_sign, traffic_light
from synthdepth.maps.geometry import Model, box, copies, merge, place, quads, tube, yaw_matrix

COVER_LIFT_M = PAINT_LIFT_M  # covers lie on top of patches and paint
_STREET_TREES = ("maple", "young", "birch", "oak", "poplar", "palm", "fruit", "bare")
# Where side streets are quiet they show signs instead.
_ROAD_SIGNS = {"parking": 0.5, "speed_limit": 0.25, "warning": 0.25}


def furnish_kerbs(
    rng: np.random.Generator,
    grid: Grid,
    kerbs: list[Kerbside],
    out: Fittings,
    *,
    people_per_100m: float,
    lamp: str,
    cafes: float,
    half_m: float,
) -> None:
    """Everything along the kerbs.

    Args:
        rng: the lane of the furnishing.
        grid: the streets.
        kerbs: their layout.
        out: what it is added to.
        people_per_100m: pedestrians on a pavement.
        lamp: kind of the street lamps.
        cafes: tables outside per 100 m of a pavement that has room.
        half_m: half the side of the square that flights keep to.
    """
    species = [_STREET_TREES[i] for i in rng.permutation(len(_STREET_TREES))[:3]]
    of_line = rng.choice(species, len(grid.lines), p=[0.6, 0.25, 0.15])
    for kerb in kerbs:
        inward, along = kerb.yaw_inward(grid), kerb.yaw_flow(grid)
        set_back = 0.5 if kerb.pavement_m > 3.4 else 0.42
        out.add("lamps", lamp, kerb.at(grid, kerb.lamps_m, set_back), inward + np.pi)
        trees = kerb.at(grid, kerb.trees_m, 1.0)
        out.add("trees", str(of_line[grid.line[kerb.edge]]), trees)
        tree_pits(out, trees, along)
        for name, s, inset in kerb.small:
            at = kerb.at(grid, np.array([s]), inset)
            # Shelters open to the road, racks and barriers stand along it.
            turn = {"bus_shelter": np.pi, "barrier_crowd": 0.0}.get(name, 0.0)
            out.add("furniture", name, at, inward + turn)
        low, high = kerb.span_m
        middle = kerb.at(grid, np.array([(low + high) / 2]), 0.0)
        if np.abs(middle).max() > half_m + 50:
            continue
        _signs(rng, grid, kerb, out)
        _walkers(rng, grid, kerb, out, people_per_100m)
        if kerb.pavement_m > 3.8:
            count = rng.poisson(cafes * (high - low) / 100)
            if count:
                start = rng.uniform(low, max(low + 0.1, high - 2.2 * count))
                s = start + 2.2 * np.arange(count)
                s = s[s < high]
                at = kerb.at(grid, s, kerb.pavement_m - 1.1)
                out.add("furniture", "cafe_table", at, rng.uniform(0, 6.28, len(s)))
    _covers(rng, grid, out, half_m)


def _signs(rng, grid: Grid, kerb: Kerbside, out: Fittings) -> None:
    """A sign or two, facing the traffic at this kerb."""
    names = list(_ROAD_SIGNS)
    facing = kerb.yaw_flow(grid) + np.pi
    low, high = kerb.span_m
    for _ in range(rng.poisson((high - low) / 60)):
        name = str(rng.choice(names, p=list(_ROAD_SIGNS.values())))
        s = rng.uniform(low, high)
        gap = np.abs(np.concatenate([kerb.trees_m, kerb.lamps_m, [1e9]]) - s).min()
        if gap > 1.0:
            out.add("signs", name, kerb.at(grid, np.array([s]), 0.45), facing)


def _walkers(rng, grid: Grid, kerb: Kerbside, out: Fittings, per_100m: float) -> None:
    """Pedestrians between trees and houses, alone or in pairs, and who waits for the bus."""
    low, high = kerb.span_m
    count = rng.poisson(per_100m * (high - low) / 100)
    s = rng.uniform(low - 4, high + 4, count)
    inset = rng.uniform(min(1.7, kerb.pavement_m - 0.9), kerb.pavement_m - 0.5, count)
    taken = np.array([place for _, place, _ in kerb.small] + [1e9])
    free = (np.abs(s[:, None] - taken).min(axis=1) > 1.4) | (inset > 2.6)
    yaw = kerb.yaw_flow(grid) + np.pi * rng.integers(0, 2, count) + rng.normal(0, 0.25, count)
    out.add("people", "", kerb.at(grid, s, inset)[free], yaw[free])
    # Some walk beside another.
    other = inset + np.where(inset > kerb.pavement_m / 2, -0.62, 0.62)
    pair = free & (rng.random(count) < 0.3) & (other > 1.7) & (other < kerb.pavement_m - 0.4)
    out.add("people", "", kerb.at(grid, s, other)[pair], yaw[pair])
    if kerb.stop_m is not None:
        waiting = int(rng.integers(0, 6))
        s = kerb.stop_m + rng.uniform(-3.2, 3.2, waiting)
        at = kerb.at(grid, s, rng.uniform(0.55, 0.95, waiting))
        out.add(
            "people", "standing", at, kerb.yaw_inward(grid) + np.pi + rng.normal(0, 0.5, waiting)
        )


def _covers(rng, grid: Grid, out: Fittings, half_m: float) -> None:
    """Manhole covers on the carriageways."""
    for edge in range(len(grid.start)):
        profile, length = grid.profile(edge), grid.length_m[edge]
        if np.abs(grid.start[edge] + grid.end[edge]).max() / 2 > half_m + 10:
            continue
        count = rng.poisson(length / 38)
        s = rng.uniform(0, length, count)
        left = rng.uniform(-0.42, 0.42, count) * profile.carriageway_m
        out.add("furniture", "manhole", grid.at(edge, s, left), z_m=COVER_LIFT_M)


def tree_pits(out: Fittings, xy: np.ndarray, angle_rad: float, size_m: float = 1.25) -> None:
    """Square pits of earth in the pavement with iron rims, one around each tree (k, 2)."""
    if not len(xy):
        return
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, s], [-s, c]])
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    parts = {}
    for key, side, lift in (
        (("metal", "pavement"), size_m + 0.12, 0.006),
        (("soil", "ground"), size_m, 0.012),
    ):
        corner = (xy[:, None] + (square * side) @ turn).reshape(-1, 4, 2)
        z = np.full((*corner.shape[:2], 1), KERB_HEIGHT_M + lift)
        parts[key] = quads(
            np.concatenate([corner, z], 2), (0.5,) * 3 if lift < 0.01 else (1.0,) * 3
        )
    out.models.append(parts)


def _mast(rng: np.random.Generator, arm_m: float) -> Model:
    """A signal mast whose arm reaches to the right of those who look at it from +x, along -y."""
    steel = choice(rng, (STEEL, DARK_STEEL, (0.05, 0.055, 0.055)))
    coat = choice(rng, ((0.022, 0.023, 0.024), (0.42, 0.26, 0.02)))
    lit = int(rng.choice([0, 2, 1], p=[0.5, 0.42, 0.08]))
    high = 5.9
    pole = tube([[0, 0, -0.1], [0, 0, high]], [0.13, 0.09], 8, steel)
    arm = tube([[0, 0, high - 0.3], [0, -0.4 * arm_m, high], [0, -arm_m, high + 0.12]],
               [0.075, 0.06, 0.04], 7, steel)  # fmt: skip
    plate = bool(rng.random() < 0.7)
    heads = [place(signal_head(lit, coat, plate), (0.34, 0, 2.9), 0.0)]
    stubs = [box((0.3, 0.05, 0.05), (0.15, 0, 2.88), steel)]
    for y in (arm_m - 0.3, arm_m - 3.4):
        if y > 1.2:
            heads.append(place(signal_head(lit, coat, plate), (0.28, -y, high - 0.06), 0.0))
            stubs.append(box((0.26, 0.06, 0.06), (0.12, -y, high - 0.02), steel))
    return merge([{("paint", "pole"): tubes} for tubes in (pole, arm, *stubs)] + heads)


class _Signals:
    """A few signals and signs of each make, and where copies of them stand."""

    def __init__(self, rng: np.random.Generator):
        self.rng = rng
        makes: dict[str, list[Model]] = {
            "post": [traffic_light(rng, arm_m=0.0) for _ in range(4)],
            "far": [traffic_light(rng, arm_m=4.0) for _ in range(2)],
            "names": [street_name_sign(rng) for _ in range(4)],
        }
        for reach in (3, 5, 7, 9):
            makes[f"mast {reach}"] = [_mast(rng, reach) for _ in range(2)]
        self.makes = makes
        self.places: dict[tuple[str, int], list] = {}

    def add(self, make: str, xy: np.ndarray, yaw_rad: float) -> None:
        """One of a make at xy (2,)."""
        which = int(self.rng.integers(len(self.makes[make])))
        self.places.setdefault((make, which), []).append((*xy, yaw_rad))

    def models(self) -> list[Model]:
        """All of them."""
        out = []
        for make, which in sorted(self.places):
            rows = np.array(self.places[make, which])
            feet = np.column_stack([rows[:, :2], np.full(len(rows), KERB_HEIGHT_M)])
            turn = yaw_matrix(rows[:, 2])
            model = self.makes[make][which]
            out.append({key: copies(part, feet, rotation=turn) for key, part in model.items()})
        return out


def furnish_junctions(
    rng: np.random.Generator, grid: Grid, out: Fittings, *, people: float, half_m: float
) -> None:
    """Signals, names and stop signs where streets meet, bollards, people on the crossings.

    Args:
        rng: the lane of the junctions.
        grid: the streets.
        out: what it is added to.
        people: on a crossing of a carriageway of 14 m.
        half_m: half the side of the square that flights keep to.
    """
    avenue = np.array([profile.kind == "avenue" for profile in grid.profiles])[grid.line]
    signalled = np.zeros(len(grid.degree), bool)
    signalled[grid.node[avenue].ravel()] = True
    signalled |= rng.random(len(signalled)) < 0.3
    signals = _Signals(rng)
    for edge in range(len(grid.start)):
        free = grid.length_m[edge] - grid.setback_m[edge].sum()
        if grid.profile(edge).kind == "alley" or free < 2 * CROSSING_M + 6:
            continue
        for end in (0, 1):
            node, setback = grid.node[edge, end], grid.setback_m[edge, end]
            corner = grid.start[edge] if end == 0 else grid.end[edge]
            if setback > 0 and grid.degree[node] >= 3 and np.abs(corner).max() < half_m + 60:
                _arm(rng, grid, edge, end, bool(signalled[node]), signals, out, people)
    out.models += signals.models()


def _arm(
    rng, grid: Grid, edge: int, end: int, signalled: bool, signals: _Signals, out: Fittings, people
) -> None:
    """What stands where an edge meets a junction."""
    profile = grid.profile(edge)
    half, ahead = profile.carriageway_m / 2, 2 * end - 1
    setback = grid.setback_m[edge, end]
    s = setback if end == 0 else grid.length_m[edge] - setback
    u = ahead * grid.along[edge]
    towards = float(np.arctan2(u[1], u[0]))
    right = -ahead
    lanes = [offset for offset, direction in profile.lanes if direction == ahead]

    def beside(back_m: float, side: int, inward_m: float) -> np.ndarray:
        return grid.at(edge, np.array(s - ahead * back_m), np.array(side * (half + inward_m)))

    corner, far = beside(4.6, right, 0.55), beside(4.6, -right, 0.55)
    if lanes and signalled:
        reach = abs(right * half - np.mean(lanes)) + 1.2
        arm = min((3, 5, 7, 9), key=lambda m: abs(m - reach))
        make = f"mast {arm}" if profile.kind == "avenue" else "post"
        signals.add(make, corner, towards + np.pi)
        if not profile.two_way and rng.random() < 0.6:
            signals.add(str(rng.choice(["post", "far"])), far, towards + np.pi)
    elif lanes:
        out.add("signs", str(rng.choice(["stop", "give_way"])), corner, towards + np.pi)
    if rng.random() < 0.4:
        signals.add("names", beside(1.2, -right, 0.9), towards)
    if rng.random() < 0.35:
        side = int(rng.choice([-1, 1]))
        at = s - ahead * np.arange(0.3, 4.0, 1.5)
        posts = grid.at(edge, at, np.full(len(at), side * (half + 0.4)))
        out.add("furniture", "bollard", posts)
    if rng.random() < 0.8:
        count = rng.poisson(people * profile.carriageway_m / 14)
        across = rng.uniform(-half + 0.5, half - 0.5, count)
        at = grid.at(edge, s - ahead * rng.uniform(0.7, 2.9, count), across)
        yaw = towards + np.pi / 2 * rng.choice([-1, 1], count) + rng.normal(0, 0.15, count)
        out.add("people", "walking", at, yaw, z_m=0.0)
