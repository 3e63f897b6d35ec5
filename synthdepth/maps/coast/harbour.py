"""What stands about on quays and lies on the water before them."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.beach_finds import floats, lobster_pots
from synthdepth.maps.coast.lofts import ROPE, coil, lathe
from synthdepth.maps.gardens.parts import DARK, draw_colour, draw_timber
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    box,
    copies,
    join,
    merge,
    quads,
    tube,
    yaw_matrix,
)

_LABEL = "street_furniture"
_CRATES = (
    (0.04, 0.12, 0.3),
    (0.4, 0.06, 0.04),
    (0.5, 0.36, 0.06),
    (0.42, 0.42, 0.4),
    (0.04, 0.2, 0.12),
)


def fish_crates(rng: np.random.Generator) -> Model:
    """Stacked plastic fish boxes with rims and handholds."""
    rim = np.array([[-0.4, -0.25], [0.4, -0.25], [0.4, 0.25], [-0.4, 0.25]])
    low, high = np.column_stack([rim * 0.92, np.zeros(4)]), np.column_stack([rim, np.full(4, 0.24)])
    nxt = [1, 2, 3, 0]
    shell = quads(np.concatenate([np.stack([low, low[nxt], high[nxt], high], 1), low[None, ::-1]]))
    inside = quads((low * 0.98 + [0, 0, 0.02])[None])
    edge = beams(high, high[nxt], 0.03, 0.03)
    holes = [box((0.012, 0.12, 0.035), (s * 0.395, 0, 0.17), (0.1, 0.1, 0.1)) for s in (-1, 1)]
    one = join([shell, inside, edge, *holes])
    at, tints = [], []
    for i in range(int(rng.integers(1, 4))):
        tint = draw_colour(rng, _CRATES)
        for k in range(int(rng.integers(1, 7))):
            at.append([rng.normal(0, 0.02), 0.62 * i + rng.normal(0, 0.01), 0.25 * k])
            tints.append(tint if rng.random() < 0.7 else draw_colour(rng, _CRATES))
    return {
        ("paint", _LABEL): copies(
            one, at, rotation=yaw_matrix(rng.normal(0, 0.06, len(at))), tint=np.array(tints)
        )
    }


def pallets(rng: np.random.Generator) -> Model:
    """Euro pallets of 1.2 x 0.8 m, stacked; at times a sheeted load on top."""
    timber = draw_timber(rng)
    y = np.linspace(-0.33, 0.33, 5)
    parts = [beams([[-0.6, v, 0.133] for v in y], [[0.6, v, 0.133] for v in y], 0.12, 0.022)]
    parts.append(
        beams(
            [[x, -0.4, 0.112] for x in (-0.53, 0, 0.53)],
            [[x, 0.4, 0.112] for x in (-0.53, 0, 0.53)],
            0.1,
            0.022,
        )
    )
    parts += [
        box((0.1, 0.1, 0.078), (x, v, 0.022)) for x in (-0.53, 0, 0.53) for v in (-0.33, 0, 0.33)
    ]
    parts.append(
        beams(
            [[-0.6, v, 0.011] for v in (-0.33, 0, 0.33)],
            [[0.6, v, 0.011] for v in (-0.33, 0, 0.33)],
            0.1,
            0.022,
        )
    )
    k = int(rng.integers(1, 8))
    at = np.column_stack([rng.normal(0, 0.02, k), rng.normal(0, 0.02, k), 0.144 * np.arange(k)])
    tint = timber * np.clip(rng.normal(1.1, 0.15, (k, 1)), 0.6, 1.5)
    model: Model = {
        ("wood", _LABEL): copies(
            join(parts), at, rotation=yaw_matrix(rng.normal(0, 0.04, k)), tint=tint
        )
    }
    if k < 3 and rng.random() < 0.6:
        load = box(
            (1.1, 0.76, rng.uniform(0.5, 1.1)),
            (0, 0, 0.144 * k),
            draw_colour(rng, [(0.04, 0.1, 0.24), (0.35, 0.35, 0.33), (0.05, 0.15, 0.08)]),
        )
        z = 0.144 * k + np.array([0.2, 0.45])
        bands = [
            beams(
                [[-0.56, -0.39, h], [0.56, -0.39, h], [0.56, 0.39, h], [-0.56, 0.39, h]],
                [[0.56, -0.39, h], [0.56, 0.39, h], [-0.56, 0.39, h], [-0.56, -0.39, h]],
                0.01,
                0.03,
                ROPE,
            )
            for h in z
        ]
        model[("fabric", _LABEL)] = join([load, *bands])
    return model


def rope_coils(rng: np.random.Generator) -> Model:
    """One to three coiled ropes and a loose end."""
    parts = []
    for i in range(int(rng.integers(1, 4))):
        tint = draw_colour(
            rng, [ROPE, (0.05, 0.2, 0.26), (0.4, 0.2, 0.05), (0.5, 0.5, 0.47), (0.06, 0.06, 0.06)]
        )
        r, d = rng.uniform(0.2, 0.4), rng.uniform(0.02, 0.045)
        at = np.array([rng.normal(0, 0.15), 0.8 * i, 0.0])
        parts.append(coil(r, d, int(rng.integers(3, 7)), tint).moved(at))
        t = np.linspace(0, 1, 7)
        loose = at + np.column_stack([r * (1 + 2.2 * t), 0.3 * np.sin(4 * t), np.full(7, d / 2)])
        parts.append(tube(loose, d / 2, 4, tint))
    return {("fabric", _LABEL): join(parts)}


def bollards(rng: np.random.Generator) -> Model:
    """A cast mooring bollard with a rope's turns round it."""
    body = lathe(
        [0.26, 0.26, 0.17, 0.14, 0.15, 0.22, 0.23, 0.16, 0.05],
        [-0.05, 0.03, 0.07, 0.2, 0.34, 0.42, 0.48, 0.53, 0.55],
        12,
        draw_colour(rng, [DARK, (0.4, 0.3, 0.05), (0.14, 0.05, 0.03)]),
    )
    t = np.linspace(0, 6 * np.pi, 28)
    turns = tube(
        np.column_stack([0.175 * np.cos(t), 0.175 * np.sin(t), 0.13 + 0.012 * t]), 0.017, 4, ROPE
    )
    return {("paint", _LABEL): body, ("fabric", _LABEL): turns}


def quay_crane(rng: np.random.Generator) -> Model:
    """A small slewing crane of 4 to 6 m: column, jib, stay, winch, hook on its wire."""
    tint = draw_colour(
        rng, [(0.5, 0.34, 0.04), (0.04, 0.1, 0.24), (0.36, 0.05, 0.03), (0.3, 0.31, 0.31)]
    )
    high, reach = rng.uniform(3.2, 4.6), rng.uniform(3.0, 4.5)
    rise = rng.uniform(0.8, 2.0)
    column = lathe([0.42, 0.42, 0.2, 0.17], [-0.1, 0.05, 0.06, high], 12, tint)
    root, tip = np.array([0.1, 0, high - 0.5]), np.array([reach, 0, high + rise])
    jib = [
        beams([root + [0, s * 0.16, 0]], [tip + [0, s * 0.05, 0]], 0.07, 0.12, tint)
        for s in (-1, 1)
    ]
    t = np.linspace(0.08, 0.95, 8)[:, None]
    a, b = root + t * (tip - root), root + (t + 0.06) * (tip - root)
    w = (0.16 - 0.11 * t) * np.array([0, 1.0, 0])
    lace = round_bars(np.concatenate([a - w, a - w]), np.concatenate([a + w, b + w]), 0.02, tint, 4)
    stay = round_bars(
        [[0, s * 0.1, high] for s in (-1, 1)],
        [tip + [-0.1, 0, 0.05]] * 2,
        0.012,
        (0.2, 0.2, 0.2),
        4,
    )
    low = rng.uniform(0.9, 2.2)
    wire = round_bars(
        [tip, [-0.32, 0, 1.3]], [[tip[0], 0, low], tip + [0, 0, 0.06]], 0.007, (0.15, 0.15, 0.15), 3
    )
    ball = lathe(
        [0.04, 0.11, 0.11, 0.04],
        [low - 0.12, low - 0.06, low + 0.08, low + 0.16],
        8,
        (0.3, 0.2, 0.03),
    ).moved([tip[0], 0, 0])
    h = np.linspace(-0.5, 4.0, 9)
    hook = tube(
        np.column_stack([tip[0] + 0.09 * np.sin(h), 0 * h, low - 0.24 + 0.09 * np.cos(h)]),
        0.022,
        5,
        DARK,
    )
    winch = [
        tube([[-0.3, -0.25, 1.2], [-0.3, 0.25, 1.2]], 0.15, 10, (0.2, 0.2, 0.2)),
        box((0.35, 0.65, 0.25), (-0.28, 0, 0.9), tint),
        box((0.3, 0.3, 0.4), (-0.3, 0.45, 1.0), DARK),
    ]
    pulley = tube([tip + [0, -0.04, 0], tip + [0, 0.04, 0]], 0.13, 10, DARK)
    return {
        ("paint", "pole"): join([column, *jib, lace, stay, pulley, *winch]),
        ("metal", "wire"): wire,
        ("paint", "obstacle"): join([ball, hook]),
    }


def barrels(rng: np.random.Generator) -> Model:
    """Drums of 200 litres, standing and one lying."""
    ribs = lathe(
        [0.27, 0.285, 0.285, 0.27, 0.285, 0.27, 0.285, 0.27, 0.285, 0.285],
        [0, 0.005, 0.02, 0.03, 0.29, 0.31, 0.58, 0.6, 0.86, 0.88],
        14,
    )
    k = int(rng.integers(1, 5))
    at = np.array([[0, 0, 0], [0.62, 0.1, 0], [0.25, 0.62, 0], [0.9, 0.66, 0]])[:k] + rng.normal(
        0, 0.02, (k, 3)
    ) * [1, 1, 0]
    tints = np.array(
        [
            draw_colour(
                rng, [(0.03, 0.1, 0.28), (0.3, 0.05, 0.03), (0.12, 0.06, 0.035), (0.05, 0.16, 0.1)]
            )
            for _ in range(k)
        ]
    )
    return {("paint", _LABEL): copies(ribs, at - [0, 0, 0.01], tint=tints)}


HARBOUR_ITEMS = {
    "fish_crates": fish_crates,
    "pallets": pallets,
    "rope_coils": rope_coils,
    "bollard": bollards,
    "barrels": barrels,
    "lobster_pots": lobster_pots,
    "floats": floats,
    "quay_crane": quay_crane,
}
_WEIGHTS = np.array([3, 2, 2, 1.5, 1.2, 3, 1.2, 0.35])


def harbour_clutter(
    rng: np.random.Generator, position, yaw_rad, variants: int = 3
) -> dict[tuple[str, str], Geometry]:
    """Crates, pallets, ropes, pots, bollards, drums, a crane, from a few variants of each.

    Args:
        rng: the lane of the harbour.
        position: (k, 3) on the quay [m].
        yaw_rad: (k,) of their fronts.
        variants: different ones of a kind, at most.
    """
    at = np.asarray(position, np.float64).reshape(-1, 3)
    rotation = yaw_matrix(np.asarray(yaw_rad, np.float64).reshape(len(at)))
    kind = rng.choice(len(HARBOUR_ITEMS), size=len(at), p=_WEIGHTS / _WEIGHTS.sum())
    variant = rng.integers(variants, size=len(at))
    placed = []
    for i, build in enumerate(HARBOUR_ITEMS.values()):
        for j in range(variants):
            chosen = (kind == i) & (variant == j)
            if chosen.any():
                model = build(rng)
                placed.append(
                    {
                        key: copies(p, at[chosen], rotation=rotation[chosen])
                        for key, p in model.items()
                    }
                )
    return merge(placed)


def sea_buoys(rng: np.random.Generator, position) -> dict[tuple[str, str], Geometry]:
    """Buoys afloat at `position` (k, 3), waterline at z: mooring balls, marks and spars."""
    at = np.asarray(position, np.float64).reshape(-1, 3)
    k = len(at)
    t = np.linspace(-np.pi / 2, np.pi / 2, 9)
    ball = lathe(np.maximum(0.32 * np.cos(t), 0.04), 0.12 + 0.32 * np.sin(t), 12)
    ring = tube(
        [[0, 0.05, 0.42], [0, 0.09, 0.52], [0, -0.09, 0.52], [0, -0.05, 0.42]],
        0.014,
        4,
        (0.2, 0.2, 0.2),
    )
    mooring = join([ball, ring])
    spar = lathe(
        [0.1, 0.35, 0.35, 0.09, 0.05, 0.05, 0.16, 0.02],
        [-0.8, -0.3, 0.2, 0.35, 1.4, 1.5, 1.52, 1.95],
        10,
    )
    mark = join(
        [
            lathe([0.3, 0.75, 0.75, 0.5, 0.3, 0.26], [-0.9, -0.4, 0.25, 0.4, 0.5, 0.55], 14),
            round_bars(
                [[0.42 * c, 0.42 * s, 0.4] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))],
                [[0.16 * c, 0.16 * s, 2.3] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))],
                0.03,
                sides=5,
            ),
            lathe([0.3, 0.3], [1.2, 1.25], 10),
            lathe([0.22, 0.22, 0.15], [2.3, 2.36, 2.6], 8),
            lathe([0.3, 0.02], [2.7, 3.2], 8),
            round_bars([[0, 0, 2.5]], [[0, 0, 3.3]], 0.02, sides=5),
        ]
    )
    pick = rng.choice(3, size=k, p=[0.6, 0.25, 0.15])
    colours = np.array(
        [
            (0.55, 0.2, 0.03),
            (0.6, 0.6, 0.57),
            (0.6, 0.46, 0.06),
            (0.45, 0.05, 0.04),
            (0.04, 0.2, 0.08),
        ]
    )
    tint = np.where(
        (pick < 2)[:, None], colours[rng.integers(3, size=k)], colours[rng.integers(2, 5, size=k)]
    ) * rng.uniform(0.7, 1.05, (k, 1))
    lean = rng.normal(0, 0.07, k)
    c, s, o, i = np.cos(lean), np.sin(lean), np.zeros(k), np.ones(k)
    tip = np.stack([np.stack([i, o, o], -1), np.stack([o, c, -s], -1), np.stack([o, s, c], -1)], -2)
    turn = yaw_matrix(rng.uniform(0, 2 * np.pi, k)) @ tip
    parts = [
        copies(one, at[pick == j], rotation=turn[pick == j], tint=tint[pick == j])
        for j, one in enumerate((mooring, spar, mark))
        if (pick == j).any()
    ]
    return {("paint", "obstacle"): join(parts)}
