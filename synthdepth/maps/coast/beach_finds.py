"""What the sea and the fishermen leave on a beach: driftwood, pots, drying nets, floats, wrack."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lofts import ROPE, coil, lathe, net, resampled
from synthdepth.maps.gardens.parts import draw_colour, draw_timber
from synthdepth.maps.geometry import Geometry, Model, copies, geometry, join, tube, yaw_matrix

_OBSTACLE, _FURNITURE = "obstacle", "street_furniture"
_FLOATS = (
    (0.55, 0.2, 0.03),
    (0.5, 0.07, 0.04),
    (0.6, 0.46, 0.06),
    (0.6, 0.6, 0.57),
    (0.04, 0.12, 0.3),
)
_TWINE = ((0.03, 0.14, 0.11), (0.04, 0.09, 0.24), (0.4, 0.17, 0.04), (0.12, 0.11, 0.1))


def driftwood(rng: np.random.Generator) -> Model:
    """A bleached trunk with stubs of branches or roots, half sunk in the sand."""
    length, r = rng.uniform(1.8, 5.5), rng.uniform(0.08, 0.24)
    t = np.linspace(-0.5, 0.5, 9)
    bend = rng.normal(0, 0.12, 2)
    path = np.column_stack(
        [
            length * t,
            bend[0] * length * t**2 + rng.normal(0, 0.02, 9),
            0.55 * r + np.abs(bend[1]) * length * (t + 0.5) ** 2 * 0.4,
        ]
    )
    radius = r * np.interp(t, [-0.5, 0.5], [1.15, 0.55]) * rng.normal(1, 0.05, 9)
    tint = np.array([0.42, 0.39, 0.34]) * rng.uniform(0.75, 1.2)
    parts = [tube(path, radius, 8)]
    for _ in range(int(rng.integers(1, 5))):
        i = int(rng.integers(2, 8))
        way = np.array([rng.uniform(0.2, 1), rng.uniform(-1, 1), rng.uniform(0.05, 0.9)])
        far = path[i] + way / np.linalg.norm(way) * rng.uniform(0.25, 1.1) * min(length / 3, 1)
        mid = (path[i] + far) / 2 + rng.normal(0, 0.04, 3)
        parts.append(tube([path[i], mid, far], radius[i] * np.array([0.5, 0.32, 0.12]), 6))
    if rng.random() < 0.45:  # the root plate
        for a in np.linspace(0, 2 * np.pi, 8)[:-1] + rng.normal(0, 0.2, 7):
            out = path[0] + np.array(
                [-rng.uniform(0.1, 0.4), np.cos(a) * 2.6 * r, np.sin(a) * 2.6 * r * 0.8]
            )
            out[2] = max(out[2], -0.05)
            parts.append(
                tube(
                    [path[0] + [0.1, 0, 0], (path[0] + out) / 2 + [-0.08, 0, 0.03], out],
                    r * np.array([0.4, 0.24, 0.08]),
                    5,
                )
            )
    return {("bark", _OBSTACLE): join(parts).tinted(tint)}


def _pot(rng: np.random.Generator) -> dict[str, Geometry]:
    """A lobster pot 0.75 m long: slatted base, bows, netting, eye; origin at its foot's middle."""
    x, y, high = 0.38, 0.26, 0.36
    timber = draw_timber(rng) * 0.8
    base = beams(
        [[-x, s * y, 0.03] for s in (-1, -0.33, 0.33, 1)],
        [[x, s * y, 0.03] for s in (-1, -0.33, 0.33, 1)],
        0.05,
        0.025,
        timber,
    )
    turn = np.linspace(0, np.pi, 8)
    arch = np.column_stack([0 * turn, y * np.cos(turn), 0.03 + high * np.sin(turn) ** 0.7])
    bows = [tube(arch + [a, 0, 0], 0.012, 4, timber * 1.2) for a in (-x, 0.0, x)]
    tint = draw_colour(rng, _TWINE)
    grid = np.stack([arch + [a, 0, 0] for a in np.linspace(-x, x, 9)])
    mesh = [net(grid, 0.009, tint)]
    for a in (-x, x):
        flat = np.stack([arch[1:-1] * [1, s, 1] + [a, 0, 0] for s in (1.0, 0.5)])
        flat[..., 2] = 0.03 + (flat[..., 2] - 0.03) * np.array([1.0, 0.6])[:, None]
        mesh.append(net(flat, 0.009, tint))
    rails = round_bars(
        [[-x, 0, 0.03 + high], [-x, 0.2, 0.24], [-x, -0.2, 0.24]],
        [[x, 0, 0.03 + high], [x, 0.2, 0.24], [x, -0.2, 0.24]],
        0.011,
        timber * 1.2,
        4,
    )
    return {"wood": join([base, *bows, rails]), "fabric": join(mesh)}


def lobster_pots(rng: np.random.Generator) -> Model:
    """A stack of pots with their rope."""
    columns, layers = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    at = []
    for c in range(columns):
        for k in range(int(rng.integers(1, layers + 1))):
            at.append(
                [
                    rng.normal(0, 0.04),
                    (c - (columns - 1) / 2) * 0.6 + rng.normal(0, 0.02),
                    0.4 * k - 0.01,
                ]
            )
    turn = yaw_matrix(rng.normal(0, 0.08, len(at)))
    kinds = [_pot(rng) for _ in range(2)]
    pick = np.arange(len(at)) % 2
    at = np.array(at)
    model: dict[tuple[str, str], list[Geometry]] = {}
    for i, kind in enumerate(kinds):
        if (pick == i).any():
            for material, part in kind.items():
                model.setdefault((material, _FURNITURE), []).append(
                    copies(part, at[pick == i], rotation=turn[pick == i])
                )
    model[("fabric", _FURNITURE)].append(
        coil(0.22, 0.022, 5, draw_colour(rng, [ROPE, (0.05, 0.2, 0.26), (0.4, 0.2, 0.05)])).moved(
            [0.65, 0.1, -0.005]
        )
    )
    return {key: join(parts) for key, parts in model.items()}


def net_poles(rng: np.random.Generator) -> Model:
    """A fishing net hung up to dry over a rope between poles."""
    k = int(rng.integers(3, 6))
    span, high = rng.uniform(1.8, 2.6), rng.uniform(2.1, 2.9)
    y = (np.arange(k) - (k - 1) / 2) * span
    foot = np.column_stack([rng.normal(0, 0.1, k), y, np.full(k, -0.4)])
    head = np.column_stack(
        [
            foot[:, 0] + rng.normal(0, 0.05, k),
            y + rng.normal(0, 0.06, k),
            high + rng.uniform(0, 0.25, k),
        ]
    )
    timber = draw_timber(rng) * 0.85
    poles = round_bars(foot, head, 0.045, timber, 7)
    columns = int((y[-1] - y[0]) / 0.13)
    u = np.linspace(0, k - 1, columns + 1)
    top = np.stack([np.interp(u, np.arange(k), head[:, i]) for i in range(3)], -1)
    top[:, 2] -= 0.12 + 0.4 * (u % 1) * (1 - u % 1)
    fall = (0.62 + 0.2 * np.sin(2.1 * u + rng.uniform(0, 6))) * high
    rows = []
    for t in np.linspace(0, 1, 14):
        p = top - np.column_stack([0 * u, 0 * u, fall * t])
        p[:, 0] += 0.1 * t * np.sin(4 * u + 3 * t)
        p[:, 2] = np.maximum(p[:, 2], 0.03 + 0.02 * np.sin(9 * u))
        rows.append(p)
    mesh = net(np.stack(rows)[::-1], 0.007, draw_colour(rng, _TWINE))
    rope = tube(top + [0, 0, 0.01], 0.011, 4, ROPE, capped=False)
    at = resampled(rows[-3], 6)
    corks = copies(
        lathe([0.02, 0.05, 0.05, 0.02], [-0.05, -0.02, 0.02, 0.05], 7),
        at,
        tint=np.repeat(draw_colour(rng, _FLOATS)[None], 6, 0),
    )
    return {
        ("wood", "pole"): poles,
        ("fabric", _FURNITURE): join([mesh, rope]),
        ("paint", _FURNITURE): corks,
    }


def floats(rng: np.random.Generator) -> Model:
    """A heap of buoys and net floats with their lines."""
    k = int(rng.integers(2, 8))
    t = np.linspace(-np.pi / 2, np.pi / 2, 8)
    ball = lathe(np.maximum(np.cos(t), 0.12), np.sin(t), 10)
    eye = tube(
        [[0, 0.06, 0.95], [0, 0.12, 1.12], [0, 0, 1.24], [0, -0.12, 1.12], [0, -0.06, 0.95]],
        0.04,
        4,
        (0.1, 0.1, 0.1),
    )
    one = join([ball, eye])
    r = rng.uniform(0.13, 0.3, k)
    at = np.column_stack([rng.normal(0, 0.4, k), rng.normal(0, 0.4, k), 0.88 * r])
    lean = rng.uniform(-2, 2, k)
    c, s, o, i = np.cos(lean), np.sin(lean), np.zeros(k), np.ones(k)
    tip = np.stack([np.stack([i, o, o], -1), np.stack([o, c, -s], -1), np.stack([o, s, c], -1)], -2)
    colours = np.asarray(_FLOATS)[rng.integers(len(_FLOATS), size=k)] * rng.uniform(
        0.7, 1.1, (k, 1)
    )
    rope = coil(0.25, 0.02, 4, draw_colour(rng, [ROPE, (0.05, 0.2, 0.26)])).moved([0.5, -0.4, 0])
    return {
        ("car_paint", _FURNITURE): copies(
            one, at, rotation=yaw_matrix(rng.uniform(0, 6, k)) @ tip, scale=r, tint=colours
        ),
        ("fabric", _FURNITURE): rope,
    }


def wrack(rng: np.random.Generator) -> Model:
    """A patch of seaweed along y, the tide's line: curled ribbons and clumps, with twigs in it."""
    k = int(rng.integers(150, 260))
    long = rng.uniform(0.8, 2.2)
    at = np.column_stack(
        [rng.normal(0, 0.22, k), rng.uniform(-long, long, k), rng.uniform(0.0, 0.05, k)]
    )
    at[:, 0] += 0.15 * np.sin(2.2 * at[:, 1] + rng.uniform(0, 6))
    at[:, 2] *= np.exp(-((at[:, 0] / 0.25) ** 2))
    yaw = rng.normal(np.pi / 2, 0.9, k)
    length, width = rng.uniform(0.1, 0.42, k), rng.uniform(0.015, 0.05, k)
    u = np.array([0.0, 0.35, 0.7, 1.0]) - 0.5
    curl = rng.normal(0, 0.5, k)
    way = np.stack([np.cos(yaw), np.sin(yaw)], -1)
    side = np.stack([-np.sin(yaw), np.cos(yaw)], -1)
    along = u[None] * length[:, None]
    drift = curl[:, None] * along**2 * 4
    mid = at[:, None, :2] + along[..., None] * way[:, None] + drift[..., None] * side[:, None]
    z = at[:, 2:] + 0.008 + rng.uniform(0, 0.05, (k, 4)) * np.array([0.3, 1, 1, 0.2])
    half = width[:, None] / 2 * np.array([0.5, 1, 0.9, 0.3])
    left = np.concatenate([mid + half[..., None] * side[:, None], z[..., None] - 0.006], -1)
    right = np.concatenate(
        [mid - half[..., None] * side[:, None], z[..., None] + rng.uniform(0, 0.02, (k, 4, 1))], -1
    )
    v = np.stack([left, right], 2).reshape(k, 8, 3)
    strip = np.array([[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [4, 5, 7], [4, 7, 6]])
    faces = strip[None] + 8 * np.arange(k)[:, None, None]
    weed = np.array(
        [
            [0.035, 0.028, 0.012],
            [0.05, 0.045, 0.02],
            [0.025, 0.022, 0.014],
            [0.07, 0.055, 0.03],
            [0.03, 0.045, 0.015],
        ]
    )
    tint = np.repeat(weed[rng.integers(5, size=k)] * rng.uniform(0.7, 1.3, (k, 1)), 8, axis=0)
    ribbons = geometry(v, faces, v[..., :2].reshape(-1, 2), tint)
    n = int(rng.integers(2, 7))
    a = np.column_stack([rng.normal(0, 0.2, n), rng.uniform(-long, long, n), np.full(n, 0.03)])
    b = a + np.column_stack(
        [rng.normal(0, 0.15, n), rng.uniform(0.15, 0.5, n), rng.uniform(-0.02, 0.05, n)]
    )
    return {
        ("leaf", _OBSTACLE): ribbons,
        ("bark", _OBSTACLE): round_bars(a, b, 0.012, (0.3, 0.27, 0.22), 4),
    }


FINDS = {
    "driftwood": driftwood,
    "lobster_pots": lobster_pots,
    "net_poles": net_poles,
    "floats": floats,
    "wrack": wrack,
}
