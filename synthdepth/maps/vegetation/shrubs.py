"""Low plants: bushes, hedges, flowers and grass tufts, tens of thousands to a call."""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import Geometry, copies, geometry, join, yaw_matrix
from synthdepth.maps.vegetation.foliage import clumps, dark_cores, directions, unit

LEAF = ("leaf", "vegetation")
TUFT = ("leaf", "ground")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shrub:
    """How a kind of bush looks; lengths are over its width.

    Attributes:
        height: to the top.
        profile: radius at heights 0, 1/4, 1/2, 3/4 and 1, over the largest.
        clumps: of leaves.
        clump: their length and width.
        loose: scatter of the clumps off the outline.
        leaf_tint: linear reflectance.
        flower_tints: linear reflectances, one of which a bush has; none without flowers.
    """

    height: float
    profile: tuple[float, float, float, float, float]
    clumps: int
    clump: tuple[float, float]
    loose: float
    leaf_tint: tuple[float, float, float]
    flower_tints: tuple[tuple[float, float, float], ...] = ()


SHRUBS = {
    "round": Shrub(
        height=0.85, profile=(0.7, 1.0, 1.0, 0.8, 0.25), clumps=170, clump=(0.21, 0.17),
        loose=0.1, leaf_tint=(0.055, 0.085, 0.028),
    ),
    "loose": Shrub(
        height=1.15, profile=(0.45, 0.75, 1.0, 0.9, 0.4), clumps=160, clump=(0.25, 0.16),
        loose=0.3, leaf_tint=(0.08, 0.11, 0.035),
    ),
    "conical": Shrub(
        height=1.9, profile=(0.9, 1.0, 0.75, 0.42, 0.06), clumps=190, clump=(0.23, 0.17),
        loose=0.08, leaf_tint=(0.036, 0.06, 0.03),
    ),
    "flowering": Shrub(
        height=0.9, profile=(0.6, 0.95, 1.0, 0.8, 0.3), clumps=180, clump=(0.19, 0.16),
        loose=0.18, leaf_tint=(0.06, 0.095, 0.035),
        flower_tints=(
            (0.5, 0.22, 0.3), (0.62, 0.58, 0.54), (0.3, 0.22, 0.46), (0.5, 0.12, 0.14),
            (0.55, 0.42, 0.08),
        ),
    ),
}  # fmt: skip

# (distance [m] from the flights' region, share of the clumps kept)
DETAILS = ((-1.0, 1.0), (8.0, 0.35), (60.0, 0.1))


def _detail(near_m, count: int) -> np.ndarray:
    """Index into `DETAILS` of `count` plants at these distances [m]."""
    near = np.broadcast_to(np.asarray(near_m, np.float64), count)
    return np.searchsorted([d[0] for d in DETAILS], near, side="right") - 1


def _bush(rng: np.random.Generator, kind: Shrub) -> tuple[Geometry, dict[str, np.ndarray]]:
    """A bush one metre wide: its dark core, and its clumps as arguments of `clumps`."""
    k = kind.clumps
    grid = np.linspace(0, 1, 33)
    outline = np.interp(grid, np.linspace(0, 1, 5), kind.profile)
    share = np.cumsum(outline + 0.15)
    h = rng.permutation(np.interp((np.arange(k) + rng.random(k)) / k, share / share[-1], grid))
    turn = 2.399963 * np.arange(k) + rng.normal(0, 0.4, k)
    wave = rng.uniform(0, 6.3, 2)
    uneven = (
        1 + 0.13 * np.sin(2 * turn + wave[0] + 3 * h) + 0.1 * np.sin(5 * turn + wave[1] - 6 * h)
    )
    deep = 1 - kind.loose * rng.exponential(0.7, k).clip(0, 2) + kind.loose * 0.6
    reach = 0.42 * np.interp(h, grid, outline) * uneven * deep
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(k)])
    centre = reach[:, None] * out
    centre[:, 2] = kind.height * (0.04 + 0.93 * h * (1 + 0.5 * (uneven - 1) * (1 - h)))
    slope = np.gradient(outline, grid)[np.clip((h * 32).astype(int), 0, 32)]
    lift = np.clip(-0.45 * slope, -0.2, 1.0) / kind.height + 0.8 * h**3
    normal = unit(out + lift[:, None] * [0, 0, 1] + 0.55 * directions(rng, k))
    along = unit(0.5 * out + [0, 0, 0.45] + directions(rng, k))
    shade = np.clip((0.6 + 0.4 * h) * rng.normal(1.0, 0.14, k) * np.clip(deep, 0.7, 1.1), 0.4, 1.5)
    hue = rng.normal(1.0, [0.08, 0.04, 0.1], (k, 3))
    tint = np.array(kind.leaf_tint) * shade[:, None] * np.clip(hue, 0.7, 1.3)
    size = rng.uniform(0.75, 1.25, k)
    if kind.flower_tints:
        bloom = (rng.random(k) < 0.34) & (h > 0.2)
        petals = np.array(kind.flower_tints[rng.integers(len(kind.flower_tints))])
        tint = np.where(bloom[:, None], petals * rng.uniform(0.75, 1.1, (k, 1)), tint)
        size = np.where(bloom, 0.6 * size, size)
    thick = np.mean(kind.profile)
    core = dark_cores(
        np.array([[0, 0, 0.37 * kind.height]]),
        np.array([[0.38 * thick, 0.38 * thick, 0.4 * kind.height]]),
        np.array([kind.leaf_tint]) * 0.45,
        rng,
    )
    return core, {
        "centre": centre,
        "along": along,
        "normal": normal,
        "length_m": kind.clump[0] * size,
        "width_m": kind.clump[1] * size * rng.uniform(0.8, 1.2, k),
        "tint": tint,
        "skew": rng.uniform(-0.16, 0.16, k),
    }


def _thinned(leaves: dict[str, np.ndarray], share: float) -> dict[str, np.ndarray]:
    """An even share of the clumps, with the area of all."""
    n = len(leaves["centre"])
    kept = max(1, int(np.ceil(share * n)))
    thin = {name: values[(np.arange(kept) * n) // kept] for name, values in leaves.items()}
    grow = np.sqrt(n / kept)
    return thin | {name: thin[name] * grow for name in ("length_m", "width_m")}


def bushes(
    rng: np.random.Generator, positions, size_m, near_m=0.0, templates: int = 3
) -> dict[tuple[str, str], Geometry]:
    """Bushes of mixed kinds.

    Args:
        rng: of the kinds, the templates and the copies.
        positions: (k, 3) on the ground [m].
        size_m: (k,) width [m].
        near_m: scalar or (k,) distance [m] from the region that flights may use.
        templates: different bushes a kind.
    """
    positions = np.asarray(positions, np.float64).reshape(-1, 3)
    k = len(positions)
    size = np.broadcast_to(np.asarray(size_m, np.float64), k)
    level = _detail(near_m, k)
    which = rng.integers(len(SHRUBS) * templates, size=k)
    scale = size[:, None] * np.column_stack([np.ones((k, 2)), rng.uniform(0.75, 1.15, k)])
    rotation = yaw_matrix(rng.uniform(0, 2 * np.pi, k))
    tint = rng.normal(1.0, 0.1, (k, 1)) * rng.normal(1.0, [0.08, 0.03, 0.08], (k, 3))
    tint = np.clip(tint, 0.65, 1.4)
    parts = []
    for number, lane in enumerate(rng.spawn(len(SHRUBS) * templates)):
        core, leaves = _bush(lane, list(SHRUBS.values())[number // templates])
        for tier, (_, share) in enumerate(DETAILS):
            at = np.flatnonzero((which == number) & (level == tier))
            if not len(at):
                continue
            bush = join([core, clumps(**(_thinned(leaves, share) if share < 1 else leaves))])
            parts.append(
                copies(bush, positions[at], rotation=rotation[at], scale=scale[at], tint=tint[at])
            )
    return {LEAF: join(parts)}


def _stations(path: np.ndarray, step_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Evenly spaced points (n, 3) of a polyline and the horizontal unit tangents (n, 2) there."""
    run = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    count = max(2, int(np.ceil(run[-1] / step_m)) + 1)
    s = np.linspace(0, run[-1], count)
    points = np.column_stack([np.interp(s, run, path[:, axis]) for axis in range(3)])
    ahead = np.gradient(points[:, :2], axis=0)
    return points, ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)


def hedge(
    rng: np.random.Generator, path, height_m: float, width_m: float, near_m: float = 0.0
) -> dict[tuple[str, str], Geometry]:
    """A clipped hedge along a polyline: a dark uneven core under leaf clumps.

    Args:
        rng: of the shape and the leaves.
        path: (k, 3) foot of the hedge's middle on the ground [m], k >= 2.
        height_m: of the top above the path.
        width_m: across.
        near_m: distance [m] from the region that flights may use.
    """
    path = np.asarray(path, np.float64)
    share = DETAILS[int(_detail(near_m, 1)[0])][1]
    points, ahead = _stations(path, 0.6 if share == 1 else 1.5)
    n = len(points)
    left = np.column_stack([-ahead[:, 1], ahead[:, 0], np.zeros(n)])
    # Cross section from the left foot over the top to the right foot: (offset, height).
    section = np.array([[0.34, -0.06], [0.4, 0.5], [0.34, 0.88], [-0.34, 0.88], [-0.4, 0.5]])
    section = np.concatenate([section, [[-0.34, -0.06]]])
    m = len(section)
    rough = rng.uniform(0.8, 1.06, (n, m))
    rough[0] *= 0.85
    rough[-1] *= 0.85
    off = width_m * section[None, :, 0] * rough
    high = np.where(section[:, 1] > 0, height_m * section[:, 1] * (0.5 + 0.5 * rough), -0.06)
    core = points[:, None] + off[..., None] * left[:, None] + high[..., None] * [0, 0, 1.0]
    i, j = np.meshgrid(np.arange(n - 1) * m, np.arange(m - 1), indexing="ij")
    a = (i + j).ravel()
    fan = np.arange(1, m - 1)
    end = (n - 1) * m
    faces = np.concatenate(
        [
            np.stack([a, a + m, a + m + 1], 1),
            np.stack([a, a + m + 1, a + 1], 1),
            np.stack([np.zeros_like(fan), fan, fan + 1], 1),
            np.stack([np.full_like(fan, end), end + fan + 1, end + fan], 1),
        ]
    )
    base = np.array(rng.choice([[0.045, 0.075, 0.026], [0.06, 0.09, 0.03], [0.036, 0.062, 0.03]]))
    base *= rng.uniform(0.85, 1.2)
    dark = geometry(
        core.reshape(-1, 3), faces[:, ::-1], tint=base * rng.uniform(0.4, 0.65, (n * m, 1))
    )

    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    girth = 2 * height_m + width_m
    clump = 0.27
    k = max(8, int(share * 19 * (length + width_m) * girth))
    grow = 1 / np.sqrt(share)
    # Position along, and around the section from foot to foot; ends are covered by what juts out.
    s = rng.uniform(-0.15 * width_m, length + 0.15 * width_m, k) / length * (n - 1)
    g = rng.uniform(0.02, 0.98, k) * girth
    whole = np.clip(s.astype(int), 0, n - 2)
    part = (s - whole)[:, None]
    foot = points[whole] * (1 - part) + points[whole + 1] * part
    side = unit(left[whole])
    on_top = (g > height_m) & (g < height_m + width_m)
    sign = np.where(g <= height_m, 1.0, -1.0)
    up = np.where(on_top, height_m, np.where(sign > 0, g, girth - g))
    across = np.where(on_top, 0.5 * width_m - (g - height_m), sign * 0.5 * width_m)
    jut = rng.normal(0.0, 0.03, (k, 1))
    normal = np.where(on_top[:, None], [0, 0, 1.0], sign[:, None] * side)
    centre = foot + across[:, None] * side + up[:, None] * [0, 0, 0.96] + jut * normal
    normal = unit(normal + 0.6 * directions(rng, k) + [0, 0, 0.15])
    along = unit(directions(rng, k) + [0, 0, 0.5])
    # Runs of older and younger shoots, and darkness towards the foot.
    drift = 1 + 0.1 * np.sin(0.9 * s + rng.uniform(0, 6.3)) * np.sin(0.37 * s + 1)
    shade = drift * (0.65 + 0.35 * up / height_m) * np.clip(rng.normal(1, 0.14, k), 0.5, 1.5)
    tint = base * shade[:, None] * np.clip(rng.normal(1, [0.08, 0.04, 0.1], (k, 3)), 0.7, 1.3)
    size = clump * grow * rng.uniform(0.75, 1.25, k)
    leaves = clumps(centre, along, normal, size, 0.8 * size, tint, skew=rng.uniform(-0.16, 0.16, k))
    return {LEAF: join([dark, leaves])}


def _blades(foot, tip, width_m, tint) -> Geometry:
    """Upright triangles from `foot` (k, 3) to `tip` (k, 3), darker at the foot."""
    k = len(foot)
    lean = tip - foot
    side = unit(np.column_stack([-lean[:, 1], lean[:, 0], np.zeros(k)]) + [1e-6, 0, 0])
    half = 0.5 * np.broadcast_to(width_m, k)[:, None] * side
    corners = np.stack([foot - half, foot + half, tip], axis=1)
    shade = np.array([0.7, 0.7, 1.1])[None, :, None] * tint[:, None]
    o = np.zeros(k)
    h = np.linalg.norm(lean, axis=1)
    w = np.broadcast_to(width_m, k)
    uv = np.stack([np.stack([o, w, w / 2], 1), np.stack([o, o, h], 1)], axis=-1)
    return geometry(corners, np.arange(3 * k), uv, shade.reshape(-1, 3))


def grass_tufts(rng: np.random.Generator, positions, height_m) -> dict[tuple[str, str], Geometry]:
    """Tufts of three to five leaning blades, one triangle a blade.

    Args:
        rng: of the blades.
        positions: (k, 3) on the ground [m].
        height_m: scalar or (k,).
    """
    positions = np.asarray(positions, np.float64).reshape(-1, 3)
    k = len(positions)
    height = np.broadcast_to(np.asarray(height_m, np.float64), k)
    owner = np.repeat(np.arange(k), rng.integers(3, 6, k))
    b = len(owner)
    h = height[owner] * rng.uniform(0.55, 1.1, b)
    turn = rng.uniform(0, 2 * np.pi, b)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(b)])
    foot = positions[owner] + (0.14 * h * rng.random(b))[:, None] * out - [0, 0, 0.02]
    tip = foot + (h * rng.uniform(0.15, 0.75, b))[:, None] * out
    tip[:, 2] += h + 0.02
    green = np.array([0.075, 0.105, 0.04]) * rng.normal(1.0, 0.12, (k, 1)).clip(0.6, 1.4)
    straw = np.array([0.2, 0.16, 0.08])
    dry = np.clip(rng.normal(0.12, 0.15, (k, 1)), 0, 0.8)
    tint = ((1 - dry) * green + dry * straw)[owner] * rng.uniform(0.75, 1.2, (b, 1))
    return {TUFT: _blades(foot, tip, 0.02 + 0.1 * h, tint)}


FLOWER_TINTS = (
    (0.6, 0.56, 0.5), (0.55, 0.42, 0.06), (0.5, 0.1, 0.09), (0.45, 0.18, 0.3), (0.22, 0.14, 0.42),
)  # fmt: skip


def flowers(rng: np.random.Generator, positions, height_m) -> dict[tuple[str, str], Geometry]:
    """Garden flowers: four leaf blades and three blossoms a plant, one colour to each.

    Args:
        rng: of the plants.
        positions: (k, 3) on the ground [m].
        height_m: scalar or (k,).
    """
    positions = np.asarray(positions, np.float64).reshape(-1, 3)
    k = len(positions)
    height = np.broadcast_to(np.asarray(height_m, np.float64), k)
    colour = np.array(FLOWER_TINTS)[rng.integers(len(FLOWER_TINTS), size=k)]

    leaf = np.repeat(np.arange(k), 4)
    b = len(leaf)
    turn = rng.uniform(0, 2 * np.pi, b)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(b)])
    h = height[leaf] * rng.uniform(0.5, 0.9, b)
    foot = positions[leaf] - [0, 0, 0.02]
    tip = foot + (0.5 * h)[:, None] * out + h[:, None] * [0, 0, 1.0]
    green = np.array([0.06, 0.095, 0.035]) * rng.uniform(0.7, 1.2, (b, 1))

    bloom = np.repeat(np.arange(k), 3)
    c = len(bloom)
    spread = height[bloom, None] * [0.3, 0.3, 0.12] * rng.normal(size=(c, 3)).clip(-1.5, 1.5)
    centre = positions[bloom] + spread + height[bloom, None] * [0, 0, 0.9]
    size = 0.22 * height[bloom] * rng.uniform(0.7, 1.3, c)
    petals = clumps(
        centre,
        directions(rng, c) * [1, 1, 0.3],
        unit(0.6 * directions(rng, c) + [0, 0, 1]),
        size,
        size,
        colour[bloom] * rng.uniform(0.8, 1.1, (c, 1)),
    )
    return {LEAF: join([_blades(foot, tip, 0.25 * h, green), petals])}
