"""Clubhouses, kiosks, containers and sheds of a sports ground.

Frame: the front looks along +x; the origin is on the ground below the middle of the plan.
"""

import dataclasses

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.geometry import Geometry, Model, box, geometry, join, merge, quads

_FRAME = (0.06, 0.062, 0.065)
_WALLS = (
    ("brick", (0.24, 0.13, 0.09)), ("brick", (0.3, 0.22, 0.15)), ("plaster", (0.6, 0.58, 0.52)),
    ("plaster", (0.5, 0.42, 0.3)), ("siding", (0.36, 0.38, 0.38)), ("wood", (0.3, 0.2, 0.11)),
)  # fmt: skip
_ROOFS = (
    ("roof_tile", (0.22, 0.1, 0.065)), ("sheeting", (0.3, 0.32, 0.33)), 
    ("shingle", (0.1, 0.1, 0.1)),
    ("sheeting", (0.2, 0.08, 0.06)),
)  # fmt: skip


def _wall_quads(x: float, y: float, low: float, high: float) -> np.ndarray:
    ring = np.array([[x, -y], [x, y], [-x, y], [-x, -y]])
    nxt = np.roll(ring, -1, axis=0)
    foot = [
        np.column_stack([p, np.full(4, z)])
        for p, z in ((ring, low), (nxt, low), (nxt, high), (ring, high))
    ]
    return np.stack(foot, axis=1)


def _openings(
    rng: np.random.Generator, x: float, y: float, storeys: int, glazed: bool
) -> tuple[list[Geometry], list[Geometry], list, list[Geometry]]:
    """Frames, sills, panes (corners) and doors on all four walls."""
    frames, sills, panes, doors = [], [], [], []
    for wall, half in ((0, y), (1, x), (2, y), (3, x)):
        turn = wall * np.pi / 2
        c, s = np.cos(turn), np.sin(turn)
        out = x if wall % 2 == 0 else y
        n = max(int(2 * half // rng.uniform(2.6, 3.8)), 1)
        at = (np.arange(n) - (n - 1) / 2) * (2 * half / n)
        door = int(rng.integers(n)) if wall in (0, 2) else -1
        for floor in range(storeys):
            for k, along in enumerate(at):
                front = wall == 0 and glazed
                w = 0.42 * 2 * half / n if front else rng.uniform(0.5, 0.75)
                low, high = (0.15 if front and floor == 0 else 0.95), 2.25
                low, high = low + 2.9 * floor, high + 2.9 * floor
                if floor == 0 and k == door:
                    doors.append(_turned(box((0.1, 1.1, 2.1), (out, along, 0.0)), c, s))
                    continue
                if rng.random() < 0.08 and not front:
                    continue
                bars = [
                    ([out, along - w, low], [out, along + w, low]),
                    ([out, along - w, high], [out, along + w, high]),
                ]
                bars += [
                    ([out, along + e * w, low], [out, along + e * w, high]) for e in (-1, 0, 1)
                ]
                a, b = (np.array(p) for p in zip(*bars, strict=True))
                frames.append(_turned(beams(a, b, 0.08, 0.07), c, s))
                sills.append(
                    _turned(box((0.16, 2 * w + 0.15, 0.06), (out + 0.02, along, low - 0.1)), c, s)
                )
                for e in (-1, 1):
                    y0, y1 = sorted((along, along + e * w))
                    p = np.array(
                        [
                            [out + 0.012, y0, low],
                            [out + 0.012, y1, low],
                            [out + 0.012, y1, high],
                            [out + 0.012, y0, high],
                        ]
                    )
                    panes.append(p @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
    return frames, sills, panes, doors


def _turned(part: Geometry, c: float, s: float) -> Geometry:
    spun = part.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]], np.float32)
    return dataclasses.replace(part, vertices=spun.astype(np.float32))


def _gable(
    x: float, y: float, eaves: float, rise: float, over: float
) -> tuple[np.ndarray, Geometry]:
    """Slopes of a gable roof (ridge along y) with their undersides, and the two gables."""
    ex, ey = x + over, y + over
    low = eaves - rise * over / x
    h = 0.16
    corners = []
    for s in (1, -1):
        top = np.array(
            [
                [s * ex, -s * ey, low],
                [s * ex, s * ey, low],
                [0, s * ey, eaves + rise],
                [0, -s * ey, eaves + rise],
            ]
        )
        corners += [top + [0, 0, h], top[::-1]]
        corners.append(np.array([top[0], top[1], top[1] + [0, 0, h], top[0] + [0, 0, h]]))
        for a, b in ((1, 2), (3, 0)):
            corners.append(np.array([top[a], top[b], top[b] + [0, 0, h], top[a] + [0, 0, h]]))
    gables = []
    for s in (1, -1):
        gables.append(
            [
                [s * x, s * y, eaves],
                [-s * x, s * y, eaves],
                [0, s * y, eaves + rise],
                [0, s * y, eaves + rise],
            ]
        )
    tri = np.array(gables)
    flat = tri[:, :3].reshape(-1, 3)
    return np.array(corners), geometry(flat, [[0, 1, 2], [3, 4, 5]], flat[:, [0, 2]])


def clubhouse(rng: np.random.Generator, length_m: float, depth_m: float, colour) -> Model:
    """Changing rooms and bar: one or two storeys, glazed towards the pitch, a covered terrace."""
    x, y = depth_m / 2, length_m / 2
    storeys = 2 if rng.random() < 0.4 else 1
    eaves = 2.9 * storeys + 0.1
    wall, tint = _WALLS[rng.integers(len(_WALLS))]
    cover, cover_tint = _ROOFS[rng.integers(len(_ROOFS))]
    frames, sills, panes, doors = _openings(rng, x, y, storeys, True)
    flat = rng.random() < 0.3
    parts: dict[tuple[str, str], list[Geometry]] = {
        (wall, "building"): [quads(_wall_quads(x, y, -0.2, eaves), tint)],
        ("paint", "building"): [
            join(frames).tinted(_FRAME if rng.random() < 0.5 else (0.62, 0.62, 0.6)),
            join(doors).tinted(np.asarray(colour) * 0.7 + 0.02),
        ],
        ("concrete", "building"): [
            join(sills),
            box((2 * x + 0.2, 2 * y + 0.2, 0.24), (0, 0, -0.15)),
        ],
        ("glass", "building"): [quads(np.array(panes))],
    }
    if flat:
        parts["gravel", "roof"] = [
            box((2 * x - 0.3, 2 * y - 0.3, 0.1), (0, 0, eaves - 0.05), (0.7, 0.7, 0.7))
        ]
        rim = [box((2 * x + 0.3, 0.22, 0.5), (0, s * y, eaves - 0.15)) for s in (-1, 1)]
        rim += [box((0.22, 2 * y + 0.3, 0.5), (s * x, 0, eaves - 0.15)) for s in (-1, 1)]
        vents = [
            box((1.2, 0.9, 0.8), (rng.uniform(-0.5, 0.5) * x, rng.uniform(-0.7, 0.7) * y, eaves))
            for _ in range(4)
        ]
        parts["paint", "roof"] = [join([*rim, *vents]).tinted((0.45, 0.45, 0.44))]
    else:
        corners, gables = _gable(x, y, eaves, x * rng.uniform(0.35, 0.65), 0.6)
        parts[cover, "roof"] = [quads(corners, cover_tint)]
        parts[wall, "building"].append(gables.tinted(tint))
        parts["brick", "building"] = [
            *parts.get(("brick", "building"), []),
            box((0.7, 0.7, 2.2), (-0.3 * x, 0.6 * y, eaves + 0.3), (0.22, 0.12, 0.085)),
        ]
    # A roof on posts over the terrace before the front.
    deep = rng.uniform(2.8, 4.0)
    post_y = np.linspace(-y + 0.3, y - 0.3, max(round(2 * y / 3.5), 2) + 1)
    front = np.full(len(post_y), x + deep)
    feet = np.column_stack([front, post_y, 0 * front - 0.1])
    canopy = 2.62
    posts = beams(feet, feet + [0, 0, canopy], 0.12, 0.12)
    rafters = beams(
        np.column_stack([front * 0 + x, post_y, front * 0 + canopy + 0.15]),
        feet + [0, 0, canopy],
        0.08,
        0.16,
    )
    z0, z1 = canopy - 0.02, canopy + 0.24
    sheet = np.array([[[x + deep + 0.3, -y, z0], [x + deep + 0.3, y, z0], [x, y, z1], [x, -y, z1]]])
    parts.setdefault(("wood", "building"), []).append(
        join([posts, rafters]).tinted((0.28, 0.19, 0.11))
    )
    parts.setdefault(("sheeting", "roof"), []).append(
        quads(np.concatenate([sheet, sheet[:, ::-1] - [0, 0, 0.04]]), (0.42, 0.43, 0.43))
    )
    parts.setdefault(("paving", "pavement"), []).append(
        box((deep + 0.8, 2 * y + 1.0, 0.2), (x + deep / 2 + 0.4, 0, -0.08))
    )
    lamps = [
        np.array(
            [
                [x + 0.4, p - 0.15, 2.45],
                [x + 0.4, p + 0.15, 2.45],
                [x + 0.15, p + 0.15, 2.45],
                [x + 0.15, p - 0.15, 2.45],
            ]
        )[::-1]
        for p in post_y[1:-1:2]
    ]
    if lamps:
        parts["lamp", "building"] = [quads(np.array(lamps), (0.6, 0.5, 0.34))]
    sign = [
        [x + 0.06, -2.0, eaves - 0.75],
        [x + 0.06, 2.0, eaves - 0.75],
        [x + 0.06, 2.0, eaves - 0.15],
        [x + 0.06, -2.0, eaves - 0.15],
    ]
    if storeys == 2:
        parts["adverts", "building"] = [
            quads(np.array([sign]), uv_origin=(rng.uniform(0, 8), 0.9 * rng.integers(8) + 0.15))
        ]
    return {key: join(part) for key, part in parts.items()}


def kiosk(rng: np.random.Generator, colour) -> Model:
    """A wooden hut that sells drinks through a hatch at +x, under a flap."""
    wide, deep, high = rng.uniform(2.6, 4.2), 2.4, 2.5
    x, y = deep / 2, wide / 2
    hatch = [
        [x + 0.015, -y + 0.4, 1.05],
        [x + 0.015, y - 0.4, 1.05],
        [x + 0.015, y - 0.4, 2.1],
        [x + 0.015, -y + 0.4, 2.1],
    ]
    flap = quads(
        [
            [
                [x + 1.2, -y + 0.4, 2.3],
                [x + 1.2, y - 0.4, 2.3],
                [x + 0.02, y - 0.4, 2.15],
                [x + 0.02, -y + 0.4, 2.15],
            ]
        ]
    )
    return {
        ("wood", "building"): quads(_wall_quads(x, y, -0.1, high), np.asarray(colour) * 0.6 + 0.06),
        ("paint", "building"): join(
            [
                quads([hatch], (0.03, 0.03, 0.03)),
                flap.tinted(colour),
                box((0.4, wide - 0.6, 0.05), (x + 0.2, 0, 1.0), (0.4, 0.3, 0.2)),
            ]
        ),
        ("sheeting", "roof"): box(
            (deep + 0.5, wide + 0.4, 0.1), (0, 0, high - 0.01), (0.35, 0.36, 0.36)
        ),
    }


def container(rng: np.random.Generator) -> Model:
    """A steel container with a store in it."""
    tint = np.array([(0.03, 0.08, 0.16), (0.22, 0.05, 0.03), (0.05, 0.1, 0.06), (0.3, 0.3, 0.29)])[
        rng.integers(4)
    ]
    x, y, high = 1.22, 3.03, 2.6
    frame = [
        beams([[s * x, t * y, 0]], [[s * x, t * y, high]], 0.12, 0.12)
        for s in (-1, 1)
        for t in (-1, 1)
    ]
    frame += [
        beams([[s * x, -y, z]], [[s * x, y, z]], 0.1, 0.1)
        for s in (-1, 1)
        for z in (0.1, high - 0.05)
    ]
    bars = [
        box((0.05, 0.05, 2.3), (dx, y + 0.05, 0.15), (0.3, 0.3, 0.3))
        for dx in (-0.7, -0.2, 0.2, 0.7)
    ]
    return {
        ("sheeting", "obstacle"): join(
            [
                quads(_wall_quads(x - 0.02, y - 0.02, 0.02, high), tint),
                box((2.36, 6.0, 0.05), (0, 0, high - 0.06), tint),
            ]
        ),
        ("paint", "obstacle"): join([join(frame).tinted(tint * 0.9), *bars]),
    }


def groundsman_shed(rng: np.random.Generator) -> Model:
    """A garage for mowers: sheets on a frame, a rolling door at +x."""
    x, y = 4.0, rng.uniform(3.5, 6.0)
    eaves = 3.2
    tint = np.array([(0.1, 0.14, 0.11), (0.32, 0.33, 0.33), (0.2, 0.17, 0.12)])[rng.integers(3)]
    corners, gables = _gable(x, y, eaves, 1.2, 0.3)
    door = quads(
        [
            [
                [x + 0.03, -1.7, 0.0],
                [x + 0.03, 1.7, 0.0],
                [x + 0.03, 1.7, 2.8],
                [x + 0.03, -1.7, 2.8],
            ]
        ],
        (0.42, 0.43, 0.43),
    )
    rails = box((0.12, 3.7, 0.2), (x, 0, 2.82), (0.2, 0.2, 0.2))
    return merge(
        [
            {
                ("sheeting", "building"): join(
                    [quads(_wall_quads(x, y, -0.2, eaves), tint), gables.tinted(tint), door]
                )
            },
            {("sheeting", "roof"): quads(corners, (0.34, 0.35, 0.35))},
            {("paint", "building"): rails},
        ]
    )
