"""The arena's plan: zones of many sizes with lanes between them, and which theme each has."""

import dataclasses

import numpy as np

from synthdepth.maps.arena.thin import gantries, net_course, pillar_field, race_gates
from synthdepth.maps.arena.walls import arch_alley, portal_frames, ramps_and_steps, wall_maze
from synthdepth.maps.arena.works import grove, pipe_yard, round_things, scaffolded_blocks
from synthdepth.maps.arena.yard import block_rows, container_yard, crate_piles, high_blocks
from synthdepth.maps.placement import distance_to

EDGE_M = 455.0  # half the side of the fenced ground
LANE_M = 6.5
NEAR_M = 60.0

# Builders (rng, zone) -> list[Model]; those of thin things come first.
THEMES = {
    "pillars": pillar_field,
    "race_gates": race_gates,
    "nets": net_course,
    "gantries": gantries,
    "portal_frames": portal_frames,
    "scaffolds": scaffolded_blocks,
    "block_rows": block_rows,
    "crates": crate_piles,
    "containers": container_yard,
    "high_blocks": high_blocks,
    "walls": wall_maze,
    "arches": arch_alley,
    "ramps": ramps_and_steps,
    "round_things": round_things,
    "pipes": pipe_yard,
    "grove": grove,
}
THIN_THEMES = tuple(THEMES)[:6]
# What is still worth its triangles far from the flights.
_FAR_THEMES = ("block_rows", "containers", "high_blocks", "grove", "block_rows")
FLOORS = ("checker_floor", "tile_floor", "striped_floor", "slab_floor", "asphalt", "paving")
_SOFT_FLOORS = ("grass", "gravel", "soil")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plot:
    """A zone's place on the map.

    Attributes:
        centre_m: (2,).
        size_m: (2,) along x and y.
        theme: a key of `THEMES`.
        floor: material of its ground.
        near: within reach of flights.
    """

    centre_m: np.ndarray
    size_m: np.ndarray
    theme: str
    floor: str
    near: bool


def _cuts(rng: np.random.Generator, zone_m: tuple[float, float]) -> np.ndarray:
    """Starts and ends (n, 2) of zones in a row across the ground, lanes between."""
    sizes = rng.uniform(*zone_m, int(2 * EDGE_M / zone_m[0]) + 2)
    ends = np.cumsum(sizes + LANE_M)
    count = max(int(np.searchsorted(ends, 2 * EDGE_M)), 1)
    # Stretched so that the last lane runs along the fence.
    sizes = sizes[:count] + LANE_M
    ends = LANE_M - EDGE_M + np.cumsum(sizes * (2 * EDGE_M - LANE_M) / sizes.sum())
    starts = np.concatenate([[LANE_M - EDGE_M], ends[:-1]])
    return np.column_stack([starts, ends - LANE_M])


def draw_plots(
    rng: np.random.Generator, zone_m: tuple[float, float], thin_share: float, bounds: np.ndarray
) -> list[Plot]:
    """Zones in columns of different widths, every column cut at places of its own."""
    boxes = [(x0, y0, x1, y1) for x0, x1 in _cuts(rng, zone_m) for y0, y1 in _cuts(rng, zone_m)]
    box = np.array(boxes).reshape(-1, 2, 2)
    centre, size = box.mean(axis=1), box[:, 1] - box[:, 0]
    corners = np.clip(bounds.mean(axis=0), box[:, 0], box[:, 1])
    near = distance_to(bounds, corners) <= NEAR_M
    thin = list(rng.permutation(THIN_THEMES))
    solid = list(rng.permutation([name for name in THEMES if name not in THIN_THEMES]))
    plots = []
    for index in range(len(box)):
        if near[index]:
            # From a shuffled deck, so that every theme has its turn.
            deck = thin if rng.random() < thin_share else solid
            theme = deck.pop(0)
            deck.append(theme)
        else:
            theme = _FAR_THEMES[rng.integers(len(_FAR_THEMES))]
        soft = theme == "grove" or rng.random() < 0.1
        floors = _SOFT_FLOORS if soft else FLOORS
        plots.append(
            Plot(
                centre_m=centre[index],
                size_m=size[index],
                theme=str(theme),
                floor=floors[rng.integers(len(floors))],
                near=bool(near[index]),
            )
        )
    return plots
