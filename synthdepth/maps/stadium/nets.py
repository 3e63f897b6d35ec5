"""Netting, goals, ball stops and corner flags.

A net is its cords: thin ribbons in the net's own surface, which hangs in a shallow belly between
its edges, at the true spacing and width (IFAB, Law 1; EN 748).
"""

import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import Geometry, Model, copies, cross, geometry, join, quads, tube

NET = ("fabric", "barrier")
FRAME = ("paint", "obstacle")
POST_M = 0.12
GOAL_M = (7.32, 2.44)
_WHITE = (0.72, 0.72, 0.7)
_STEEL = (0.3, 0.31, 0.31)


def netting(
    corners,
    mesh_m: float,
    cord_m: float,
    belly_m=(0.0, 0.0, 0.0),
    tint=(0.6, 0.6, 0.58),
    segments: int = 6,
) -> Geometry:
    """A square-meshed net spanned between four corners.

    Args:
        corners: (4, 3) lower left, lower right, upper right, upper left [m].
        mesh_m: spacing of the cords.
        cord_m: their width.
        belly_m: (3,) how far the middle hangs out.
        tint: (3,).
        segments: pieces of a cord.
    """
    ll, lr, ur, ul = np.asarray(corners, np.float64)
    wide = max(np.linalg.norm(lr - ll), np.linalg.norm(ur - ul))
    high = max(np.linalg.norm(ul - ll), np.linalg.norm(ur - lr))
    belly = np.asarray(belly_m, np.float64)

    def at(s, t):
        s, t = s[..., None], t[..., None]
        flat = (1 - t) * ((1 - s) * ll + s * lr) + t * ((1 - s) * ul + s * ur)
        return flat + np.sin(np.pi * s) ** 0.7 * np.sin(np.pi * t) ** 0.7 * belly

    along = np.linspace(0, 1, segments + 1)
    parts = []
    for upright, length in ((True, wide), (False, high)):
        count = max(round(length / mesh_m), 1)
        each = np.arange(count + 1) / count
        a, b = np.meshgrid(each, along, indexing="ij")
        points = at(a, b) if upright else at(b, a)
        across = (lr - ll) + (ur - ul) if upright else (ul - ll) + (ur - lr)
        half = cord_m / 2 * across / np.linalg.norm(across)
        sides = np.stack([points - half, points + half], 2)
        corner = np.stack(
            [sides[:, :-1, 0], sides[:, :-1, 1], sides[:, 1:, 1], sides[:, 1:, 0]], axis=2
        ).reshape(-1, 4, 3)
        n = len(corner)
        uv = np.tile([[0, 0], [0.01, 0], [0.01, 0.3], [0, 0.3]], (n, 1))
        first = 4 * np.arange(n)[:, None]
        faces = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]], axis=1)
        parts.append(geometry(corner, faces, uv, tint))
    return join(parts)


def goal(
    rng: np.random.Generator,
    width_m: float = GOAL_M[0],
    height_m: float = GOAL_M[1],
    *,
    portable: bool = False,
    cord_tint=(0.62, 0.62, 0.6),
) -> Model:
    """A goal, open towards +x, its line at x = 0; the inner width and height are as given."""
    r = POST_M / 2 if width_m > 4 else 0.04
    y, z = width_m / 2 + r, height_m + r
    top, deep = (0.12, 0.13)[portable] * width_m, rng.uniform(0.22, 0.28) * width_m
    x = -r  # the posts' fronts stand on the goal line
    start = [[x, -y, -0.1], [x, y, -0.1], [x, -y - r, z]]
    end = [[x, -y, z], [x, y, z], [x, y + r, z]]
    frame = [round_bars(start, end, r, _WHITE, sides=12)]
    net_top, low = z - 0.02, 0.02
    if portable:
        bars_a = [[x, s * y, low + 0.03] for s in (-1, 1)] + [[x - deep, -y, low + 0.03]]
        bars_b = [[x - deep, s * y, low + 0.03] for s in (-1, 1)] + [[x - deep, y, low + 0.03]]
        for s in (-1, 1):
            bars_a += [[x, s * y, z], [x - top, s * y, z]]
            bars_b += [[x - top, s * y, z], [x - deep, s * y, low + 0.03]]
        frame.append(round_bars(bars_a, bars_b, 0.65 * r, _WHITE, sides=8))
        weights = beams([[x - deep - 0.1, -0.9, 0.1]], [[x - deep - 0.1, 0.9, 0.1]], 0.2, 0.2)
        frame.append(weights.tinted((0.06, 0.06, 0.06)))
    elif rng.random() < 0.5:
        # Elbows of thin tube carry the net.
        for s in (-1, 1):
            path = [[x, s * y, z], [x - top, s * y, z - 0.02], [x - top - 0.1, s * y, z - 0.35]]
            path += [[x - deep, s * y, 0.0], [x - deep, s * y, -0.1]]
            frame.append(tube(path, 0.02, 6, _STEEL))
    else:
        # Poles behind the goal hold the net's upper corners on ropes.
        top = deep
        back = x - deep - rng.uniform(0.9, 1.6)
        poles = [[back, s * (y + 0.5), -0.1] for s in (-1, 1)]
        tips = [[back, s * (y + 0.5), z + 0.15] for s in (-1, 1)]
        frame.append(round_bars(poles, tips, 0.035, _STEEL, sides=8))
        hooks = [[x - top, s * y, net_top] for s in (-1, 1)]
        frame.append(round_bars(tips, hooks, 0.006, _WHITE, sides=3))
    mesh = 0.12 if width_m > 3 else 0.1
    o = np.array([x, 0, 0])
    roof = [
        o + [0, -y, net_top],
        o + [0, y, net_top],
        o + [-top, y, net_top],
        o + [-top, -y, net_top],
    ]
    rear = [o + [-deep, -y, low], o + [-deep, y, low], roof[2], roof[3]]
    nets = [
        netting(roof, mesh, 0.005, (0, 0, -0.1), cord_tint),
        netting(rear, mesh, 0.005, (-0.16, 0, 0), cord_tint),
    ]
    for s in (-1, 1):
        side = [o + [0, s * y, low], o + [-deep, s * y, low], o + [-top, s * y, net_top]]
        side.append(o + [0, s * y, net_top])
        nets.append(netting(side, mesh, 0.005, (0, 0.08 * s, 0), cord_tint))
    hem = [[-deep, -y, 0.03], [-deep, y, 0.03]]
    nets.append(round_bars([o + hem[0]], [o + hem[1]], 0.012, cord_tint, sides=4))
    return {FRAME: join(frame), NET: join(nets)}


def ball_stop(
    rng: np.random.Generator, path: np.ndarray, height_m: float, mesh_m: float = 0.12
) -> Model:
    """A net on poles along a polyline (k, 2) [m] at z = 0."""
    path = np.asarray(path, np.float64)
    stations = [path[:1]]
    for a, b in itertools.pairwise(path):
        n = max(round(np.hypot(*(b - a)) / 6.0), 1)
        stations.append(a + (np.arange(1, n + 1) / n)[:, None] * (b - a))
    at = np.concatenate(stations)
    foot = np.column_stack([at, np.full(len(at), -0.1)])
    lean = np.column_stack([rng.normal(0, 0.04, (len(at), 2)), np.full(len(at), height_m + 0.1)])
    head = foot + lean + [0, 0, 0.1]
    green = rng.random() < 0.5
    pole_tint = (0.03, 0.07, 0.045) if green else _STEEL
    cord = ((0.03, 0.05, 0.035), (0.03, 0.03, 0.03), (0.5, 0.5, 0.48))[rng.integers(3)]
    poles = round_bars(foot, head, 0.05, pole_tint, sides=8)
    nets, ropes = [], []
    sag = 0.025
    for i in range(len(at) - 1):
        low_a, low_b = foot[i] + [0, 0, 0.14], foot[i + 1] + [0, 0, 0.14]
        high_a, high_b = head[i] - [0, 0, 0.1], head[i + 1] - [0, 0, 0.1]
        normal = cross(low_b - low_a, [0, 0, 1.0])
        blow = rng.normal(0, 0.1) * normal / np.linalg.norm(normal)
        nets.append(netting([low_a, low_b, high_b, high_a], mesh_m, 0.004, blow, cord, 3))
        span = np.linalg.norm(high_b - high_a)
        middle = (high_a + high_b) / 2 - [0, 0, sag * span]
        ropes += [(high_a, middle), (middle, high_b), (low_a, low_b)]
    a, b = (np.array(side) for side in zip(*ropes, strict=True))
    return {
        ("paint", "pole"): poles,
        NET: join([*nets, round_bars(a, b, 0.006, cord, sides=3)]),
    }


def court_net(width_m: float, height_m: float, tint=(0.03, 0.035, 0.03)) -> Model:
    """A tennis or volleyball net across y at x = 0, with its posts, tape and centre strap."""
    y = width_m / 2
    posts = round_bars(
        [[0, s * y, -0.05] for s in (-1, 1)],
        [[0, s * y, height_m + 0.05] for s in (-1, 1)],
        0.04,
        (0.03, 0.06, 0.04),
    )
    low = height_m - 1.0 if height_m > 1.5 else 0.03
    net = netting(
        [[0, -y, low], [0, y, low], [0, y, height_m], [0, -y, height_m]],
        0.06,
        0.0035,
        (0, 0, 0),
        tint,
        4,
    )
    dip = 0.1 if height_m < 1.5 else 0.02
    tape = quads(
        [
            [[0, s * y, height_m - 0.06], [0, 0, height_m - dip - 0.06], [0, 0, height_m - dip],
             [0, s * y, height_m]]
            for s in (-1, 1)
        ],
        _WHITE,
    )  # fmt: skip
    return {("paint", "pole"): posts, NET: join([net, tape.moved((0.004, 0, 0))])}


def corner_flag(rng: np.random.Generator, tint) -> Model:
    """A flag on a whip of 1.5 m."""
    pole = tube([[0, 0, -0.05], [0, 0, 0.8], [0.01, 0, 1.55]], 0.014, 6, (0.6, 0.55, 0.1))
    turn = rng.uniform(0, 2 * np.pi)
    out = np.array([np.cos(turn), np.sin(turn), 0])
    side = np.array([-out[1], out[0], 0])
    u, v = np.meshgrid(np.linspace(0, 1, 4), [0.0, 1.0], indexing="ij")
    cloth = u[..., None] * 0.42 * out + (0.04 * np.sin(5 * u))[..., None] * side
    cloth = cloth + np.stack([0 * u, 0 * u, 1.18 - 0.05 * u + v * (0.36 - 0.14 * u)], -1)
    i = np.array([[0, 2, 3], [0, 3, 1]])
    faces = (i[None] + 2 * np.arange(3)[:, None, None]).reshape(-1, 3)
    return {
        ("paint", "pole"): pole,
        ("fabric", "street_furniture"): geometry(cloth, faces, np.stack([u, v], -1), tint),
    }


def balls(positions: np.ndarray, radius_m: float = 0.11) -> Model:
    """Balls (k, 2) [m] lying on the ground."""
    at = np.asarray(positions, np.float64).reshape(-1, 2)
    turn = np.linspace(0.15, np.pi - 0.15, 6)
    path = np.column_stack([0 * turn, 0 * turn, radius_m * (1 - np.cos(turn))])
    unit = tube(path, radius_m * np.sin(turn), 9, (0.62, 0.62, 0.6))
    return {FRAME: copies(unit, np.column_stack([at, np.zeros(len(at))]))}
