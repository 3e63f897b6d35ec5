"""Large structures in and over streets: scaffolds, billboards, water towers.

Cranes, bridges, masts and pylons have files of their own and are found here too.
"""

import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.cranes import tower_crane
from synthdepth.maps.furniture.footbridge import footbridge, railing
from synthdepth.maps.furniture.lattice import lattice
from synthdepth.maps.furniture.masts import (
    Pylon,
    build_pylon,
    conductors,
    draw_pylon,
    lattice_mast,
    power_line,
    pylon,
)
from synthdepth.maps.furniture.parts import (
    DARK_STEEL,
    STEEL,
    TIMBER,
    Surfaces,
    boxes,
    choice,
    item,
    lathe,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering, poster
from synthdepth.maps.geometry import Geometry, box, join, merge, quads, tube

__all__ = [
    "Pylon", "billboard", "build_pylon", "conductors", "draw_pylon", "footbridge", "lattice_mast",
    "power_line", "pylon", "scaffold", "tower_crane", "water_tower",
]  # fmt: skip


def water_tower(rng: np.random.Generator) -> Surfaces:
    """A water tower of 24-44 m: a steel tank on braced legs, or a globe on a stem."""
    coat = choice(
        rng, ((0.5, 0.52, 0.52), (0.36, 0.46, 0.5), (0.55, 0.53, 0.48), (0.22, 0.3, 0.28))
    )
    name = ("OAKTON", "LAKESIDE", "MILFORD", "HARBOR", "EASTON")[rng.integers(5)]
    if rng.random() < 0.35:
        high, r = rng.uniform(24, 34), rng.uniform(4.5, 6.0)
        t = np.linspace(-0.42 * np.pi, 0.49 * np.pi, 20)
        globe = [(r * np.cos(a), high + r + 0.85 * r * np.sin(a)) for a in t]
        shape = [(2.6, -0.1), (1.5, 3.0), (1.15, 6.0), (1.1, high - 2.5), (1.6, high - 0.6), *globe]
        hull = lathe(shape, 40, coat)
        words = decals(lettering(name, 1.3), (0.03, 0.06, 0.2), 8, r, 40).moved([0, 0, high + r])
        hatch = [lathe([(0.4, high + 1.85 * r), (0.4, high + 1.85 * r + 0.4)], 8, coat)]
        return item("building", plaster=[hull], paint=[words, *hatch])
    high, r, tank = rng.uniform(18, 27), rng.uniform(3.2, 5.0), rng.uniform(5.0, 7.5)
    count = int(rng.choice([4, 6]))
    hull = lathe(
        [
            (0.4, high - 0.45 * r),
            (0.55 * r, high - 0.3 * r),
            (0.9 * r, high - 0.1 * r),
            (r, high + 0.3),
            (r, high + tank),
            (r + 0.25, high + tank),
            (0.1, high + tank + 0.55 * r),
            (0.1, high + tank + 0.55 * r + 0.5),
            (0.02, high + tank + 0.55 * r + 0.8),
        ],
        36,
        coat,
    )
    turn = 2 * np.pi * (np.arange(count) + 0.5) / count
    out = np.column_stack([np.cos(turn), np.sin(turn)])
    levels = np.linspace(0, 1, 4)
    reach = r * 1.35 + (r * 0.96 - r * 1.35) * levels
    z = -0.1 + (high + 0.6) * levels
    rings = np.concatenate(
        [reach[:, None, None] * out, np.broadcast_to(z[:, None, None], (4, count, 1))], axis=2
    )
    legs = lattice(rings, 0.16, 0.035, crossed=True).tinted(coat)
    riser = tube([[0, 0, -0.1], [0, 0, high - 0.3 * r]], 0.42, 10, coat)
    walk = lathe(
        [(r, high + 0.25), (r + 0.95, high + 0.25), (r + 0.95, high + 0.31), (r, high + 0.32)],
        24,
        DARK_STEEL,
    )
    edge = 2 * np.pi * np.arange(25) / 24
    path = np.column_stack(
        [(r + 0.9) * np.cos(edge), (r + 0.9) * np.sin(edge), 0 * edge + high + 0.3]
    )
    rail = railing(path, coat, 1.05, 0.4)
    words = decals(lettering(name, min(1.4, 0.2 * tank)), (0.03, 0.06, 0.2), 1, r, 36)
    words = join([turned(words, a, (0, 0, high + 0.62 * tank)) for a in (0, np.pi)])
    rungs_z = np.arange(0.5, high + tank, 0.5)
    step = np.interp(rungs_z, [0, high], [1.35 * r, 0.96 * r]).clip(r + 0.12)
    at = np.column_stack([step * out[0, 0], step * out[0, 1], rungs_z])
    across = 0.2 * np.array([-out[0, 1], out[0, 0], 0])
    ladder = join(
        [
            round_bars(at - across, at + across, 0.014, STEEL, 3),
            tube(at[[0, -1]] - across, 0.018, 4, STEEL),
            tube(at[[0, -1]] + across, 0.018, 4, STEEL),
        ]
    )
    pads = boxes((1.2, 1.2, 0.5), np.column_stack([out * r * 1.35, np.full(count, -0.2)]))
    return merge(
        [
            item(
                "building",
                plaster=[hull],
                paint=[legs, riser, walk, words, ladder],
                concrete=[pads],
            ),
            {("paint", "barrier"): rail},
        ]
    )


def scaffold(rng: np.random.Generator, *, width_m: float, height_m: float) -> Surfaces:
    """A tube scaffold before a wall in the plane x = 0, `width_m` along y, centred.

    Lifts of 2 m with boards, guard rails and toe boards, ladders, braces; some bays are netted.

    Args:
        rng: of the netting, boards and sheets.
        width_m, height_m: of the wall it covers [m].
    """
    bays, lifts = max(1, round(width_m / 2.3)), max(1, round(height_m / 2.0))
    y = np.linspace(-width_m / 2, width_m / 2, bays + 1)
    z = 0.25 + 2.0 * np.arange(1, lifts + 1)
    near, far = 0.28, 1.28
    top = z[-1] + 1.2
    poles = round_bars(
        [[x, v, -0.02] for v in y for x in (near, far)],
        [[x, v, top if x == far else z[-1] + 0.2] for v in y for x in (near, far)],
        0.0242,
        sides=6,
    )
    start, stop = [], []
    for level in z:
        for x, heights in ((near, (0.0,)), (far, (0.0, 0.55, 1.05))):
            for h in heights:
                start.append([x, y[0] - 0.12, level + h])
                stop.append([x, y[-1] + 0.12, level + h])
        start += [[near - 0.12, v, level - 0.05] for v in y]
        stop += [[far + 0.12, v, level - 0.05] for v in y]
        start += [[near, e, level + 1.0] for e in (y[0], y[-1])]
        stop += [[far, e, level + 1.0] for e in (y[0], y[-1])]
    for k in range(lifts):
        b = (k * 2) % bays
        start.append([far + 0.05, y[b], z[k] - 2.0])
        stop.append([far + 0.05, y[b + 1], z[k]])
    tubes = round_bars(start, stop, 0.0242, sides=5)
    x = near + 0.14 + 0.235 * np.arange(4)
    boards, toes = [], []
    for level in z:
        sag = rng.normal(0, 0.008, (bays, 4))
        a = np.stack(np.broadcast_arrays(x[None], y[:-1, None] - 0.05, level + 0.05 + sag), -1)
        b = np.stack(np.broadcast_arrays(x[None], y[1:, None] + 0.05, level + 0.05 + sag), -1)
        keep = rng.random((bays, 4)) < 0.93
        shade = np.array(TIMBER[1]) * rng.uniform(0.7, 1.2, (int(keep.sum()), 1))
        boards.append(beams(a[keep], b[keep], 0.225, 0.038, shade))
        toes.append(
            beams(
                [[far - 0.03, y[0], level + 0.16]],
                [[far - 0.03, y[-1], level + 0.16]],
                0.03,
                0.18,
                TIMBER[1],
            )
        )
    ladders = []
    for k in range(lifts):
        at = y[(k % 2) if bays > 1 else 0] + 0.5
        base, head = np.array([far - 0.3, at, z[k] - 1.95]), np.array([near + 0.35, at, z[k] + 0.9])
        t = np.linspace(0.03, 0.97, 10)[:, None]
        step = base + t * (head - base)
        ladders += [
            round_bars(step - [0, 0.19, 0], step + [0, 0.19, 0], 0.013, STEEL, 4),
            round_bars(
                [base - [0, 0.2, 0], base + [0, 0.2, 0]],
                [head - [0, 0.2, 0], head + [0, 0.2, 0]],
                0.02,
                STEEL,
                4,
            ),
        ]
    plates = boxes(
        (0.15, 0.15, 0.02), [[px, v, -0.005] for v in y for px in (near, far)], DARK_STEEL
    )
    soles = boxes((0.3, 0.5, 0.05), [[far, v, -0.045] for v in y])
    net = _netting(rng, y, z, far + 0.09)
    parts = {
        ("metal", "obstacle"): join([poles, tubes]),
        ("wood", "obstacle"): join([*boards, *toes, soles.tinted(TIMBER[1])]),
        ("paint", "obstacle"): join([*ladders, plates]),
    }
    if len(net.faces):
        parts["fabric", "obstacle"] = net
    return parts


def _netting(rng: np.random.Generator, y: np.ndarray, z: np.ndarray, x: float) -> Geometry:
    """Debris netting over some of the bays, bellied by the wind: (bays, lifts) sheets."""
    colour = np.array(choice(rng, ((0.04, 0.16, 0.09), (0.07, 0.11, 0.18), (0.45, 0.44, 0.41))))
    share = rng.choice([0.0, 0.35, 0.8])
    u = np.linspace(0, 1, 5)
    sheets, tints = [], []
    for a, b in itertools.pairwise(y):
        for level in z:
            if rng.random() > share:
                continue
            belly = rng.uniform(0.03, 0.14)
            grid_y, grid_z = np.meshgrid(a + u * (b - a), level - 1.97 + u * 1.94, indexing="ij")
            bulge = belly * np.outer(np.sin(np.pi * u), np.sin(np.pi * u) + 0.15)
            p = np.stack([x + bulge, grid_y, grid_z], -1)
            sheets.append(
                np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], 2).reshape(-1, 4, 3)
            )
            tints.append(np.full((16, 1), rng.uniform(0.8, 1.15)) * colour)
    if not sheets:
        return join([])
    corners = np.concatenate(sheets)
    # One piece of cloth: its texture runs on from square to square.
    return quads(corners, np.concatenate(tints), corners[:, 0, 1:])


def billboard(rng: np.random.Generator) -> Surfaces:
    """A hoarding of 5-8 by 3-4 m facing +x, on one to three posts, with a catwalk and lamps."""
    wide, tall, low = rng.uniform(5.5, 8.5), rng.uniform(2.8, 4.0), rng.uniform(2.6, 6.0)
    steel = choice(rng, (STEEL, DARK_STEEL, (0.07, 0.1, 0.08)))
    mono = low > 4.2
    posts = (
        [tube([[-0.3, 0, -0.1], [-0.3, 0, low + 0.8 * tall]], 0.3, 12, steel)]
        if mono
        else [
            beams([[-0.2, y, -0.1]], [[-0.2, y, low + tall]], 0.18, 0.18, steel)
            for y in np.array([-0.36, 0.0, 0.36]) * wide
        ]
    )
    case = box((0.12, wide, tall), (0, 0, low), (0.3, 0.3, 0.29))
    edge = wide / 2 + 0.05
    frame = [box((0.2, 0.14, tall + 0.24), (0, s * edge, low - 0.12), steel) for s in (-1, 1)]
    frame += [box((0.2, 2 * edge, 0.14), (0, 0, z), steel) for z in (low - 0.13, low + tall - 0.01)]
    picture = poster(rng, wide, tall).moved([0.062, 0, low])
    rows = np.arange(low + 0.3, low + tall, 0.7)
    back = beams(
        np.column_stack([0 * rows - 0.1, 0 * rows - wide / 2, rows]),
        np.column_stack([0 * rows - 0.1, 0 * rows + wide / 2, rows]),
        0.08,
        0.1,
        steel,
    )
    walk = box((0.75, wide, 0.04), (0.5, 0, low - 0.34), steel)
    # Under the catwalk hang brackets of a leg, a shelf and a knee.
    y = np.linspace(-0.45, 0.45, 4) * wide
    corner = {
        name: np.column_stack([0 * y + x, y, 0 * y + low + z])
        for name, x, z in (
            ("top", 0, 0),
            ("foot", 0, -0.8),
            ("heel", 0, -0.37),
            ("toe", 0.86, -0.37),
        )
    }
    brackets = [
        beams(corner[a], corner[b], 0.05, 0.06, steel)
        for a, b in (("foot", "top"), ("heel", "toe"), ("foot", "toe"))
    ]
    rail = railing([[0.86, -wide / 2, low - 0.3], [0.86, wide / 2, low - 0.3]], steel, 0.95, 0.8)
    arms, lamps = [], []
    for y in np.linspace(-0.38, 0.38, 4) * wide:
        arms.append(
            tube([[0.1, y, low - 0.3], [1.1, y, low - 0.45], [1.5, y, low - 0.35]], 0.025, 5, steel)
        )
        arms.append(
            turned(box((0.1, 0.4, 0.26), (0, 0, -0.13), DARK_STEEL), 0, (1.5, y, low - 0.3), 0.9)
        )
        lamps.append(
            turned(
                quads(
                    [
                        [
                            [-0.052, 0.16, -0.1],
                            [-0.052, -0.16, -0.1],
                            [-0.052, -0.16, 0.1],
                            [-0.052, 0.16, 0.1],
                        ]
                    ],
                    (0.6, 0.6, 0.56),
                ),
                0,
                (1.5, y, low - 0.3),
                0.9,
            )
        )
    return item(
        paint=[*posts, case, *frame, picture, back, walk, *brackets, rail, *arms],
        lamp=lamps,
        concrete=[box((1.2, 1.2, 0.35), (-0.3, 0, -0.15))] if mono else [],
    )
