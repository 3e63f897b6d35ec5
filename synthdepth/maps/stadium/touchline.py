"""What stands around a pitch: rail, advertising boards, dugouts, tunnel, scoreboard, gantry."""

import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import (
    Model,
    box,
    geometry,
    join,
    merge,
    quads,
    tube,
)
from synthdepth.maps.materials.sports import AD_HEIGHT_M, AD_LENGTH_M, AD_ROWS
from synthdepth.maps.stadium.stands import railing

_STEEL = (0.3, 0.31, 0.32)
_WHITE = (0.66, 0.66, 0.63)
_DARK = (0.03, 0.032, 0.034)


def perimeter_rail(path: np.ndarray, tint) -> Model:
    """A spectators' rail along a polyline (k, 2) [m]."""
    foot = np.column_stack([path, np.zeros(len(path))])
    return {("paint", "barrier"): railing(foot, 1.08, tint, spacing=2.4, bars=1)}


def boards(rng: np.random.Generator, path: np.ndarray, inward: float, share: float) -> Model:
    """Advertising boards along a polyline (k, 2) [m]; `inward` 1 faces its left, -1 its right.

    A `share` of the places has one.
    """
    path = np.asarray(path, np.float64)
    faces, backs, stays_a, stays_b, rows, starts = [], [], [], [], [], []
    for a, b in itertools.pairwise(path):
        length = float(np.hypot(*(b - a)))
        if length < 3:
            continue
        ahead = np.append((b - a) / length, 0)
        normal = inward * np.array([-ahead[1], ahead[0], 0])
        s = 0.3
        while s < length - 2.2:
            wide = float(min(rng.choice([3.0, 4.5, 6.0]), length - s - 0.1))
            if rng.random() < share:
                lean = rng.normal(0, 0.012)
                low = np.append(a, 0.06) + s * ahead
                up = np.array([0, 0, AD_HEIGHT_M]) - lean * normal
                ends = [low, low + (wide - 0.04) * ahead]
                if inward < 0:
                    ends = ends[::-1]
                p, q = ends[1], ends[0]  # seen from the pitch, left to right
                faces.append([p, q, q + up, p + up])
                t = 0.05 * normal
                backs += [
                    [q - t, p - t, p - t + up, q - t + up],
                    [p + up, q + up, q - t + up, p - t + up],
                    [p - t, p, p + up, p - t + up],
                    [q, q - t, q - t + up, q + up],
                ]
                for e in (0.2, 0.8):
                    foot = p + e * (q - p) - t
                    stays_a += [foot + 0.8 * up, foot - [0, 0, 0.1]]
                    stays_b += [
                        foot - 0.55 * normal - [0, 0, 0.1],
                        foot - 0.55 * normal - [0, 0, 0.1],
                    ]
                rows.append(rng.integers(AD_ROWS))
                starts.append(rng.uniform(0, AD_LENGTH_M))
            s += wide + rng.choice([0.0, 0.0, 0.6])
    if not faces:
        return {}
    origin = np.column_stack([starts, AD_HEIGHT_M * np.array(rows)])
    steel = join([quads(np.array(backs)), beams(stays_a, stays_b, 0.04, 0.04)])
    return {
        ("adverts", "barrier"): quads(np.array(faces), uv_origin=origin),
        ("paint", "barrier"): steel.tinted((0.4, 0.4, 0.39)),
    }


def dugout(rng: np.random.Generator, length_m: float, tint) -> Model:
    """A team bench under a bent perspex roof, open towards -y; its middle is at the origin."""
    half = length_m / 2
    # Side profile (y, z) from the foot of the back to the lip over the bench.
    arch = np.array(
        [[0.95, 0.0], [0.98, 1.2], [0.85, 1.75], [0.5, 2.05], [0.0, 2.15], [-0.55, 2.1]]
    )
    n = max(round(length_m / 1.3), 2)
    ribs = np.linspace(-half, half, n + 1)
    bars, panes = [], []
    for x in ribs:
        rib = np.column_stack([np.full(len(arch), x), arch])
        bars.append(tube(rib, 0.025, 5))
    for a, b in itertools.pairwise(ribs):
        for (y0, z0), (y1, z1) in itertools.pairwise(arch):
            panes.append(
                [[b - 0.03, y0, z0], [a + 0.03, y0, z0], [a + 0.03, y1, z1], [b - 0.03, y1, z1]]
            )
    for y, z in arch[1:]:
        bars.append(round_bars([[-half, y, z]], [[half, y, z]], 0.018, sides=4))
    sides = []
    for x in (-half, half):
        edge = np.concatenate([[[0.1, 0.05]], arch[:-1] + [-0.01, 0.01]])
        fan = np.stack([np.zeros(4), np.arange(1, 5), np.arange(2, 6)], 1)
        sides.append(geometry(np.column_stack([np.full(6, x), edge]), fan, edge))
    seat_x = np.arange(-half + 0.4, half - 0.3, 0.55)
    seat = []
    for x in seat_x:
        seat.append(box((0.46, 0.42, 0.06), (x, 0.55, 0.42)))
        seat.append(box((0.46, 0.06, 0.5), (x, 0.78, 0.46)))
    frame = box((length_m - 0.2, 0.3, 0.38), (0, 0.6, 0.0), _DARK)
    return {
        ("glass", "obstacle"): join([quads(np.array(panes)), *sides]),
        ("paint", "obstacle"): join(
            [join(bars).tinted(_STEEL), join(seat).tinted(np.asarray(tint)), frame]
        ),
        ("concrete", "pavement"): box((length_m + 0.5, 2.2, 0.1), (0, 0.2, -0.06)),
    }


_SEGMENTS = {
    "0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc", "5": "afgcd", "6": "afgedc",
    "7": "abc", "8": "abcdefg", "9": "abcdfg",
}  # fmt: skip
_BARS = {
    "a": (0, 1, 1, 0.16), "g": (0, 0, 1, 0.16), "d": (0, -1, 1, 0.16), "f": (-0.5, 0.5, 0.16, 1),
    "b": (0.5, 0.5, 0.16, 1), "e": (-0.5, -0.5, 0.16, 1), "c": (0.5, -0.5, 0.16, 1),
}  # fmt: skip


def _digits(text: str, y: float, z: float, size: float, x: float) -> list:
    """Corners of seven-segment digits on a board that faces +x; y runs to the viewer's right."""
    quads_out = []
    pitch = 0.75 * size
    for k, digit in enumerate(text):
        if digit == " ":
            continue
        c = y + (k - (len(text) - 1) / 2) * pitch
        for bar in _SEGMENTS[digit]:
            dy, dz, w, h = _BARS[bar]
            m, top = c + dy * 0.5 * size, z + dz * 0.5 * size
            hw, hh = w * 0.22 * size, h * 0.22 * size
            m = c + dy * 0.44 * size
            quads_out.append(
                [
                    [x, m - hw, top - hh],
                    [x, m + hw, top - hh],
                    [x, m + hw, top + hh],
                    [x, m - hw, top + hh],
                ]
            )
    return quads_out


def scoreboard(rng: np.random.Generator, width_m: float, foot_m: float) -> Model:
    """A board on two posts, facing +x: digits, a strip of advertising above."""
    high = 0.5 * width_m
    y = width_m / 2
    posts = beams(
        [[-0.15, s * 0.35 * width_m, -0.1] for s in (-1, 1)],
        [[-0.15, s * 0.35 * width_m, foot_m + high] for s in (-1, 1)],
        0.2, 0.2,
    )  # fmt: skip
    braces = round_bars(
        [[-0.15, s * 0.35 * width_m, foot_m * 0.9] for s in (-1, 1)],
        [[-1.8, s * 0.35 * width_m, -0.1] for s in (-1, 1)],
        0.05,
    )
    case = box((0.3, width_m, high), (0.1, 0, foot_m), (0.02, 0.021, 0.022))
    x = 0.257
    home, away = (str(int(rng.integers(5))) for _ in range(2))
    clock = f"{int(rng.integers(1, 90)):02d}"
    z, size = foot_m + 0.38 * high, 0.42 * high
    red = _digits(home, -0.3 * width_m, z, size, x) + _digits(away, 0.3 * width_m, z, size, x)
    amber = _digits(clock, 0, z, 0.6 * size, x)
    strip = quads(
        [[[x, -y, foot_m + high + 0.02], [x, y, foot_m + high + 0.02],
          [x, y, foot_m + high + 0.02 + AD_HEIGHT_M], [x, -y, foot_m + high + 0.02 + AD_HEIGHT_M]]],
        uv_origin=(rng.uniform(0, AD_LENGTH_M), AD_HEIGHT_M * int(rng.integers(AD_ROWS))),
    )  # fmt: skip
    back = box((0.1, width_m, AD_HEIGHT_M), (0.2, 0, foot_m + high + 0.02), (0.3, 0.3, 0.3))
    return {
        ("paint", "obstacle"): join([join([posts, braces]).tinted(_STEEL), case, back]),
        ("signal", "obstacle"): join(
            [quads(np.array(red), (0.6, 0.05, 0.03)), quads(np.array(amber), (0.6, 0.35, 0.04))]
        ),
        ("adverts", "obstacle"): strip.moved((0.004, 0, 0)),
    }


def tunnel(length_m: float, tint) -> Model:
    """A telescopic players' tunnel along y, its mouth at the origin, hoops under canvas."""
    turn = np.linspace(0, np.pi, 7)
    arch = np.column_stack([1.25 * np.cos(turn), 0.9 + 1.4 * np.sin(turn) ** 0.8])
    arch = np.concatenate([[[1.25, 0.0]], arch, [[-1.25, 0.0]]])
    y = np.linspace(0, length_m, max(round(length_m / 0.9), 2) + 1)
    sag = 1 - 0.03 * (np.arange(2 * len(y) - 1) % 2)
    stations = np.linspace(0, length_m, 2 * len(y) - 1)
    ring = np.stack(
        [
            np.column_stack([k * arch[:, 0], np.full(len(arch), s), k * arch[:, 1]])
            for k, s in zip(sag, stations, strict=True)
        ]
    )
    cloth = np.stack([ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]], 2).reshape(
        -1, 4, 3
    )
    bow = np.insert(arch, 1, 0.0, axis=1) * 1.02
    hoops = [tube(bow + [0, s, 0], 0.02, 5) for s in y]
    return {
        ("fabric", "obstacle"): quads(cloth, tint),
        ("paint", "obstacle"): join(hoops).tinted(_STEEL),
    }


def gantry(rng: np.random.Generator) -> Model:
    """A camera tower of scaffolding, its platform looking towards -y."""
    bays, lift = int(rng.integers(2, 4)), 2.0
    wide, deep, high = 2.0 * int(rng.integers(1, 3)), 1.6, lift * bays
    x = np.arange(0, wide + 0.1, 2.0) - wide / 2
    foot = np.array([[a, s * deep / 2, -0.05] for a in x for s in (-1, 1)])
    up = np.array([0, 0, high + 1.2])
    start, end = [*foot], [*(foot + up)]
    for k in range(1, bays + 1):
        z = k * lift
        for h in (z, *((z + 0.55, z + 1.1) if k == bays else ())):
            for s in (-1, 1):
                start.append([x[0] - 0.15, s * deep / 2, h])
                end.append([x[-1] + 0.15, s * deep / 2, h])
            for a in x:
                start.append([a, -deep / 2, h])
                end.append([a, deep / 2, h])
        for a, b in itertools.pairwise(x):
            for s in (-1, 1):
                start.append([a, s * deep / 2, z - lift])
                end.append([b, s * deep / 2, z])
        for a in (x[0], x[-1]):
            start.append([a, -deep / 2 * (-1) ** k, z - lift])
            end.append([a, deep / 2 * (-1) ** k, z])
    planks = [
        box((wide + 0.2, 0.24, 0.05), (0, y, high + 0.03)) for y in np.arange(-0.65, 0.7, 0.26)
    ]
    ladder_x = x[-1] + 0.2
    rungs = np.arange(0.3, high + 0.9, 0.3)
    a = np.column_stack([np.full(len(rungs), ladder_x), np.full(len(rungs), -0.2), rungs])
    rails = [[ladder_x, s * 0.2, 0.0] for s in (-1, 1)]
    ladder = join(
        [
            round_bars(a, a * [1, -1, 1], 0.012, sides=3),
            round_bars(rails, np.array(rails) + [0, 0, high + 1.0], 0.02, sides=4),
        ]
    )
    return {
        ("metal", "obstacle"): join(
            [round_bars(np.array(start), np.array(end), 0.024, sides=6), ladder]
        ),
        ("wood", "obstacle"): join(planks).tinted((0.33, 0.25, 0.15)),
    }


def flags(rng: np.random.Generator, positions: np.ndarray, height_m: float, colours) -> Model:
    """Flagpoles (k, 2) [m] with cloth in the colours (n, 3)."""
    models = []
    wind = rng.uniform(0, 2 * np.pi)
    for x, y in positions:
        pole = tube([[x, y, -0.1], [x, y, height_m]], [0.06, 0.03], 7, _WHITE)
        turn = wind + rng.normal(0, 0.25)
        out = np.array([np.cos(turn), np.sin(turn), 0])
        side = np.array([-out[1], out[0], 0])
        u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 3), indexing="ij")
        cloth = np.array([x, y, height_m - 1.35]) + u[..., None] * 1.7 * out
        cloth = cloth + (0.16 * u * np.sin(7 * u + rng.uniform(0, 6)))[..., None] * side
        cloth[..., 2] += 1.2 * v - 0.45 * u
        i = np.arange(21).reshape(7, 3)
        a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
        faces = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
        tint = np.asarray(colours)[rng.integers(len(colours))]
        models.append(
            {
                ("paint", "pole"): pole,
                ("fabric", "street_furniture"): geometry(
                    cloth, faces, np.stack([1.7 * u, v], -1), tint
                ),
            }
        )
    return merge(models)
