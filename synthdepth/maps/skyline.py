"""A distant town: building masses in a ring around a map, so that no view ends in a void."""

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from synthdepth.maps.bars import beams
from synthdepth.maps.geometry import Model, cross, geometry, merge, quads, yaw_matrix
from synthdepth.maps.materials.arena import FAR_BAY_M

_FOUNDATION_M = 9.6  # walls go on below the ground, which may slope

# Linear reflectances of rendered, clad, brick and concrete walls in a town's distance.
_WALLS = np.array(
    [[0.62, 0.58, 0.5], [0.5, 0.49, 0.46], [0.42, 0.38, 0.32], [0.34, 0.25, 0.19],
     [0.3, 0.18, 0.13], [0.7, 0.69, 0.65], [0.36, 0.39, 0.42], [0.24, 0.27, 0.31],
     [0.55, 0.48, 0.36], [0.46, 0.35, 0.28]]
)  # fmt: skip
_TILES = np.array([[0.26, 0.12, 0.08], [0.16, 0.13, 0.12], [0.2, 0.1, 0.07], [0.1, 0.1, 0.11]])


def skyline(
    rng: np.random.Generator,
    inner_m: float,
    outer_m: float,
    *,
    tallest_m: float,
    count: int,
    ground_m: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Model:
    """Buildings between two distances from the origin: towers in clusters, low roofs between.

    Args:
        rng: the lane of the skyline.
        inner_m: nothing stands nearer.
        outer_m: nothing stands farther.
        tallest_m: height of the tallest roof above its ground; masts go above it.
        count: buildings, fewer where they would not fit; some 45 triangles each.
        ground_m: height of the ground [m] at points (n, 2) -> (n,); 0 when none.
    """
    xy, centrality, size, yaw = _sites(rng, inner_m, outer_m, tallest_m, count)
    n = len(xy)
    ground = np.zeros(n) if ground_m is None else np.asarray(ground_m(xy), np.float64)
    low = 2 + rng.gamma(2.0, 1.6, n)
    floors = np.where(
        centrality > 0.1,
        np.maximum(low, tallest_m / FAR_BAY_M * centrality * rng.uniform(0.3, 1.0, n)),
        low,
    )
    height = FAR_BAY_M * np.round(floors)
    height *= np.clip(tallest_m / height, 0, 1)
    height[np.argmax(height)] = tallest_m

    tint = _WALLS[rng.integers(len(_WALLS), size=n)] * rng.uniform(0.75, 1.15, (n, 1))
    gabled = (height < 18) & (rng.random(n) < 0.6)
    tower = height > 0.3 * tallest_m
    banded = rng.random(n) < np.where(tower, 0.5, 0.2)

    # Tiers: the building itself, wings and podiums beside it, setbacks and plant above.
    body = np.arange(n)
    wing = np.flatnonzero(~gabled & (rng.random(n) < 0.5))
    stepped = np.flatnonzero((height > 35) & (rng.random(n) < 0.6))
    plant = np.flatnonzero(~gabled)
    share = np.ones(n)
    share[stepped] = rng.uniform(0.55, 0.85, len(stepped))
    shrink = rng.uniform(0.4, 0.75, (n, 2))
    tiers = [
        (body, size, np.zeros((n, 2)), np.zeros(n), height * share),
        (
            wing,
            size * rng.uniform(0.6, 1.25, (n, 2)),
            size * rng.uniform(-0.45, 0.45, (n, 2)),
            np.zeros(n),
            np.maximum(FAR_BAY_M * 2, height * share * rng.uniform(0.15, 0.7, n)),
        ),
        (stepped, size * shrink, size * rng.uniform(-0.08, 0.08, (n, 2)), height * share, height),
        (
            plant,
            size * shrink * rng.uniform(0.3, 0.7, (n, 2)),
            size * rng.uniform(-0.1, 0.1, (n, 2)),
            height,
            height + rng.uniform(2, 5, n),
        ),
    ]
    models = []
    for level, (who, extent, shift, bottom, top) in enumerate(tiers):
        blocks = _blocks(xy, yaw, ground, shift, extent, bottom, top, who)
        models.append(_masses(blocks, tint[who], banded[who] & (level < 3)))
        if level in (0, 2):
            models.append(_windows(rng, blocks, 9))
    who = np.flatnonzero(gabled)
    eaves = _blocks(xy, yaw, ground, np.zeros((n, 2)), size, height, height, who)
    models.append(_gables(eaves, tint[who], _TILES[rng.integers(len(_TILES), size=len(who))]))
    models.append(_masts(rng, np.column_stack([xy, ground + height])[tower], tallest_m))
    return merge(models)


@dataclasses.dataclass(frozen=True)
class _Blocks:
    """Upright blocks.

    Attributes:
        ring: (k, 4, 2) corners seen from above, counter-clockwise [m].
        base_m: (k,) height of their lower end.
        top_m: (k,) height of their upper end.
        buried_m: (k,) how much of them is foundation.
    """

    ring: np.ndarray
    base_m: np.ndarray
    top_m: np.ndarray
    buried_m: np.ndarray


def _blocks(xy, yaw, ground, shift, size, bottom, top, who) -> _Blocks:
    """Blocks number `who`, each shifted within its building's own frame."""
    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    local = corner * size[who, None] + shift[who, None]
    turn = yaw_matrix(yaw[who])[:, :2, :2]
    ring = np.einsum("kij,kcj->kci", turn, local) + xy[who, None]
    buried = np.where(bottom[who] > 0, 0.0, _FOUNDATION_M)
    base = ground[who] + bottom[who] - buried
    return _Blocks(ring, base, ground[who] + top[who], buried)


def _masses(blocks: _Blocks, tint: np.ndarray, banded: np.ndarray) -> Model:
    """Walls and flat roofs."""
    k = len(blocks.ring)
    walls = _walls(blocks).reshape(k, 4, 4, 3)
    roof = np.concatenate(
        [blocks.ring, np.broadcast_to(blocks.top_m[:, None, None], (k, 4, 1))], axis=2
    )
    # Rows of windows count from the ground, not from the foundation.
    origin = np.column_stack([np.zeros(k), -blocks.buried_m])
    return {
        (name, "building"): quads(
            walls[kind].reshape(-1, 4, 3),
            np.repeat(tint[kind], 4, axis=0),
            np.repeat(origin[kind], 4, axis=0),
        )
        for name, kind in (("facade_far", ~banded), ("facade_far_bands", banded))
    } | {("concrete", "roof"): quads(roof)}


def _walls(blocks: _Blocks) -> np.ndarray:
    """Outside walls (4 k, 4, 3), four a block, as `quads` wants them."""
    here, following = blocks.ring, np.roll(blocks.ring, -1, axis=1)
    flat = np.stack([here, following, following, here], axis=2)  # (k, wall, corner, 2)
    z = np.stack([blocks.base_m, blocks.base_m, blocks.top_m, blocks.top_m], axis=1)
    z = np.broadcast_to(z[:, None, :, None], (*flat.shape[:3], 1))
    return np.concatenate([flat, z], axis=3).reshape(-1, 4, 3)


def _windows(rng: np.random.Generator, blocks: _Blocks, each: int) -> Model:
    """Some panes a block, of glass, over the painted ones: they glint, and shine at night."""
    walls = _walls(blocks)
    wide = np.linalg.norm(walls[:, 1] - walls[:, 0], axis=1)
    outward = cross(walls[:, 1] - walls[:, 0], [0, 0, 1.0])
    seen = np.einsum("ni,ni->n", outward, walls[:, :2].mean(axis=1)) < 0
    number = np.repeat(np.flatnonzero(seen), each // 2)
    wall, wide = walls[number], wide[number]
    along = (wall[:, 1] - wall[:, 0]) / wide[:, None]
    buried = np.repeat(blocks.buried_m, 4)[number]
    base, top = wall[:, 0, 2] + buried, wall[:, 2, 2]
    column = np.floor(rng.random(len(wall)) * (wide / FAR_BAY_M - 0.05))
    rows = (top - base) / FAR_BAY_M
    row = np.floor(rng.random(len(wall)) * np.maximum(rows - 0.05, 1))
    x = (column + 0.22) * FAR_BAY_M
    z = base + (row + 0.3) * FAR_BAY_M
    out = outward[number] / np.linalg.norm(outward[number], axis=1, keepdims=True)
    foot = wall[:, 0] + along * x[:, None] + 0.15 * out
    foot[:, 2] = z
    right, up = along * 0.56 * FAR_BAY_M, np.array([0, 0, 0.45 * FAR_BAY_M])
    corners = np.stack([foot, foot + right, foot + right + up, foot + up], axis=1)
    return {("glass", "building"): quads(corners)}


def _gables(eaves: _Blocks, wall_tint: np.ndarray, tile_tint: np.ndarray) -> Model:
    """Saddle roofs over low houses, the ridge along the longer side."""
    ring = eaves.ring
    first = np.linalg.norm(ring[:, 1] - ring[:, 0], axis=1)
    second = np.linalg.norm(ring[:, 2] - ring[:, 1], axis=1)
    ring = np.where((first >= second)[:, None, None], ring, np.roll(ring, -1, axis=1))
    k = len(ring)
    z = np.broadcast_to(eaves.top_m[:, None, None], (k, 4, 1))
    a, b, c, d = np.concatenate([ring, z], axis=2).transpose(1, 0, 2)
    rise = np.zeros((k, 3))
    rise[:, 2] = 0.34 * np.minimum(first, second)
    left, right = (a + d) / 2 + rise, (b + c) / 2 + rise
    slopes = np.stack([np.stack([a, b, right, left], 1), np.stack([c, d, left, right], 1)], 1)
    ends = np.stack([np.stack([b, c, right], 1), np.stack([d, a, left], 1)], 1).reshape(-1, 3, 3)
    return {
        ("roof_tile", "roof"): quads(slopes.reshape(-1, 4, 3), np.repeat(tile_tint, 2, axis=0)),
        ("plaster", "building"): geometry(
            ends, np.arange(6 * k), tint=np.repeat(wall_tint, 6, axis=0)
        ),
    }


def _masts(rng: np.random.Generator, roofs: np.ndarray, tallest_m: float) -> Model:
    """Antenna masts on about half of the high roofs (k, 3)."""
    feet = roofs[rng.random(len(roofs)) < 0.5]
    tops = feet + np.array([0, 0, 1.0]) * rng.uniform(0.06, 0.3, (len(feet), 1)) * tallest_m
    tint = np.where(rng.random((len(feet), 1)) < 0.3, [0.4, 0.12, 0.09], [0.4, 0.41, 0.42])
    return {("paint", "pole"): beams(feet - [0, 0, 1.0], tops, 0.7, 0.7, tint)}


def _sites(rng, inner_m, outer_m, tallest_m, count):
    """Places (n, 2), how central they are (n,), footprints (n, 2) and yaws (n,); none overlap."""
    hubs = int(rng.integers(3, 6))
    hub_angle = rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(hubs) / hubs
    hub_angle += rng.uniform(-0.4, 0.4, hubs)
    hub_reach = rng.uniform(0.25, 0.7, hubs)
    hub_rank = rng.uniform(0.3, 0.9, hubs)
    hub_rank[0] = 1.0
    hub_width = rng.uniform(0.12, 0.3, hubs)

    tries = 3 * count + 8
    # Most crowd round the hubs; the others are spread evenly over all directions, as terraces and
    # slabs with their long sides to the map.
    hub = rng.integers(0, hubs, tries)
    even = 2 * np.pi * (np.arange(tries) * 0.6180339887 % 1.0)
    crowd = rng.random(tries) < 0.65
    angle = np.where(crowd, hub_angle[hub] + rng.normal(0, hub_width[hub]), even)
    even_reach = rng.random(tries) ** 1.5
    reach = np.clip(np.where(crowd, rng.normal(hub_reach[hub], 0.2), even_reach), 0, 1)
    away = np.abs((angle[:, None] - hub_angle + np.pi) % (2 * np.pi) - np.pi) / hub_width
    centrality = hub_rank * np.exp(-0.5 * (away**2 + ((reach[:, None] - hub_reach) / 0.25) ** 2))
    centrality = centrality.max(axis=1)
    bays = rng.integers(3, 13, (tries, 2))
    # Towers are slim; away from the hubs some slabs are long.
    bays = np.where(centrality[:, None] > 0.35, np.minimum(bays, 9) + 1, bays)
    bays[~crowd, 1] *= 2
    size = FAR_BAY_M * bays
    clear = np.hypot(*size.T)
    r = inner_m + clear + reach * np.maximum(outer_m - inner_m - 2 * clear, 1.0)
    xy = np.stack([r * np.cos(angle), r * np.sin(angle)], 1)
    yaw = np.where(crowd, hub_angle[hub], angle) + rng.normal(0, 0.08, tries)
    yaw += np.pi / 2 * (crowd & (rng.random(tries) < 0.5))
    keep = np.ones(tries, bool)
    pairs = cKDTree(xy).query_pairs(1.3 * clear.max(), output_type="ndarray")
    gap = np.linalg.norm(xy[pairs[:, 0]] - xy[pairs[:, 1]], axis=1)
    near = pairs[gap < 0.62 * (clear[pairs[:, 0]] + clear[pairs[:, 1]])]
    keep[near.max(axis=1)] = False
    chosen = np.flatnonzero(keep)[:count]
    return xy[chosen], centrality[chosen], size[chosen], yaw[chosen]
