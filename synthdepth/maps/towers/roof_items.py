"""What stands on roofs: machines, ducts, aerials, skylights, tanks, billboards."""

import numpy as np

from synthdepth.maps.geometry import cross, geometry, tube
from synthdepth.maps.materials.city import POSTER_COLUMNS, POSTER_M, POSTER_ROWS
from synthdepth.maps.towers.panels import block, quads_of, slopes
from synthdepth.maps.towers.roof import Roof

_METAL, _PAINT = ("metal", "roof"), ("paint", "roof")


def air_handlers(roof: Roof, rng: np.random.Generator) -> None:
    """A row of condensers on rails, fans on top."""
    many = int(rng.integers(1, 5))
    big = rng.random() < 0.3
    x, y, h = (2.6, 2.0, 1.9) if big else (1.1, 0.9, rng.uniform(0.9, 1.3))
    at = roof.spot(rng, (many * (x + 0.35), y + 0.2))
    if at is None:
        return
    s = at[0] + (np.arange(many) - (many - 1) / 2) * (x + 0.35)
    grey = rng.uniform(0.3, 0.6) * np.array([1.0, 1.0, 0.97])
    n = np.full(many, at[1])
    roof.box(_PAINT, grey, s, n, (x, y, h), 0.18)
    roof.box(
        _PAINT, (0.12, 0.12, 0.12), s, n, (x - 0.14, y + 0.012, 0.55 * h), 0.18 + 0.25 * h, "fk"
    )
    for edge in (-0.35, 0.35):
        rail = many * (x + 0.35)
        roof.box(
            ("wood", "roof"), (0.2, 0.16, 0.12), at[0], at[1] + edge * y, (rail, 0.12, 0.2), -0.02
        )
    turn = 2 * np.pi * np.arange(8) / 8
    r = 0.38 * min(x, y)
    rim = np.stack([r * np.cos(turn), r * np.sin(turn)], 1)
    z = roof.z + 0.18 + h + 0.02
    for k in range(0, 6, 2):
        p, q, u = rim[0], rim[k + 1], rim[min(k + 2, 7)]
        v = rim[min(k + 3, 7)]
        corner = [c for a, b in (p, q, u, v) for c in (s + a, n - b, z)]
        roof.panels.add(_PAINT, (0.05, 0.05, 0.05), quads_of(corner, [2]), roof.frame)


def duct(roof: Roof, rng: np.random.Generator) -> None:
    """A sheet-metal duct on feet, with a bend down into the roof at one end."""
    long, w = rng.uniform(4, 11), rng.uniform(0.5, 0.9)
    across = rng.random() < 0.5
    at = roof.spot(rng, (w, long) if across else (long, w), 0.3)
    if at is None:
        return
    size = (w, long, 0.55) if across else (long, w, 0.55)
    roof.box(_METAL, (1, 1, 1), *at, size, 0.45, "flrtkb")
    axis = np.array([0.0, 1.0] if across else [1.0, 0.0])
    end = np.asarray(at) + axis * (long / 2 - w / 2)
    roof.box(_METAL, (0.96, 0.96, 0.96), *end, (w - 0.01, w - 0.01, 0.47), -0.02)
    at_feet = np.asarray(at) + axis * np.linspace(-0.45, 0.3, max(2, int(long / 2)))[:, None] * long
    foot = (w + 0.1, 0.08, 0.47) if across else (0.08, w + 0.1, 0.47)
    roof.box(_METAL, (0.5, 0.5, 0.5), *at_feet.T, foot, -0.02)
    # Flanges every 1.5 m.
    k = np.linspace(-0.48, 0.48, max(3, int(long / 1.5)))[:, None] * long
    rim = (w + 0.06, 0.05, 0.61) if across else (0.05, w + 0.06, 0.61)
    roof.box(_METAL, (0.8, 0.8, 0.8), *(np.asarray(at) + axis * k).T, rim, 0.42, "flrtkb")


def vents(roof: Roof, rng: np.random.Generator) -> None:
    """Pipes and mushroom cowls in a group."""
    at = roof.spot(rng, (2.0, 2.0), 0.0)
    if at is None:
        return
    k = int(rng.integers(2, 5))
    xy = np.asarray(at) + rng.uniform(-0.85, 0.85, (k, 2))
    high = rng.uniform(0.4, 1.2, k)
    for (s, n), z in zip(xy, high, strict=True):
        roof.rods(_METAL, (0.8, 0.8, 0.8), (s, n, -0.05), (s, n, z), rng.uniform(0.05, 0.11), 7)
        if rng.random() < 0.6:
            roof.rods(_METAL, (0.7, 0.7, 0.7), (s, n, z), (s, n, z + 0.16), 0.2, 8)


def skylight(roof: Roof, rng: np.random.Generator) -> None:
    """A glazed ridge on a kerb."""
    x, y = rng.uniform(2.0, 5.0), rng.uniform(1.4, 2.4)
    at = roof.spot(rng, (x, y))
    if at is None:
        return
    s, n = at
    roof.box(_PAINT, (0.5, 0.5, 0.48), s, n, (x, y, 0.4), -0.05)
    a, b, z = np.array([s - x / 2 + 0.05]), s + x / 2 - 0.05, roof.z + 0.352
    h = y / 2 - 0.05
    front = slopes(a, b, n + h, z, n, z + 0.55 * y / 2)
    back = quads_of((b, n - h, z, a, n - h, z, a, n, z + 0.55 * y / 2, b, n, z + 0.55 * y / 2), [0])
    for made in (front, back):
        roof.panels.add(("glass", "roof"), (1.2, 1.25, 1.25), made, roof.frame)
    for x_end in (a, np.array([b])):
        end = quads_of(
            (x_end, n - h, z, x_end, n + h, z, x_end, n, z + 0.275 * y, x_end, n, z + 0.275 * y),
            [1],
        )
        roof.panels.add(_PAINT, (0.5, 0.5, 0.48), end, roof.frame)
    t = np.linspace(s - x / 2 + 0.05, s + x / 2 - 0.05, max(3, int(x / 0.8)))
    ridge = np.stack([t, np.full_like(t, n), np.full_like(t, 0.37 + 0.275 * y)], 1)
    for side in (-h, h):
        foot = ridge * [1, 1, 0] + [0, side, 0.36]
        roof.rods(_PAINT, (0.5, 0.5, 0.48), foot, ridge, 0.025, 4)


def whips(roof: Roof, rng: np.random.Generator) -> None:
    """Two or three whip aerials on a short mast."""
    at = roof.spot(rng, (0.8, 0.8), 0.0, 0.5)
    if at is None:
        return
    s, n = at
    high = rng.uniform(2.0, 4.5)
    pole, grey = ("metal", "pole"), (0.8, 0.8, 0.8)
    roof.rods(pole, grey, (s, n, -0.02), (s, n, high), 0.03, 5)
    for z in (0.7 * high, 0.95 * high):
        reach = rng.uniform(0.3, 0.7)
        roof.rods(pole, grey, (s - reach, n, z), (s + reach, n, z), 0.014, 4)
        elements = s + np.linspace(-reach, reach, 7)
        start = np.stack([elements, np.full(7, n - 0.35), np.full(7, z)], 1)
        roof.rods(pole, grey, start, start + [0, 0.7, 0], 0.009, 3)
    for dx in (-0.25, 0.25):
        tip = rng.uniform(1.5, 3.0)
        foot = (s + dx, n, 0.95 * high)
        roof.rods(pole, (0.6, 0.6, 0.6), foot, (s + dx, n, 0.95 * high + tip), 0.011, 3)


def dish(roof: Roof, rng: np.random.Generator) -> None:
    """A satellite dish on a post."""
    at = roof.spot(rng, (1.6, 1.6), 0.0, 0.7)
    if at is None:
        return
    radius = rng.uniform(0.4, 0.8)
    roof.rods(_METAL, (0.8, 0.8, 0.8), (*at, -0.02), (*at, 0.9), 0.04, 6)
    turn = 2 * np.pi * np.arange(12) / 12
    face = np.array([0.55, 0.5, 0.65]) / np.linalg.norm([0.55, 0.5, 0.65])
    u = cross([0, 0, 1.0], face)
    u /= np.linalg.norm(u)
    v = cross(face, u)
    centre = roof.world(*at, 0.95) + 0.1 * face
    rim = centre + radius * (np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v)
    back = centre - 0.3 * radius * face
    points = np.concatenate([rim, back[None]])
    fan = np.stack([np.arange(12), (np.arange(12) + 1) % 12, np.full(12, 12)], 1)
    roof.panels.add_geometry(_PAINT, geometry(points, fan, points[:, :2], (0.5, 0.5, 0.49)))
    feed = centre + 0.7 * radius * face
    roof.panels.rods(_METAL, (1, 1, 1), rim[[0, 4, 8]], np.stack([feed] * 3), 0.012, 3)


def panels_antenna(roof: Roof, rng: np.random.Generator) -> None:
    """Mobile-network panels on a tripod."""
    at = roof.spot(rng, (1.8, 1.8), 0.0, 0.6)
    if at is None:
        return
    s, n = at
    pole, grey = ("metal", "pole"), (0.85, 0.85, 0.85)
    high = rng.uniform(2.6, 4.5)
    roof.rods(pole, grey, (s, n, -0.02), (s, n, high), 0.06, 6)
    turn = rng.uniform(0, 6) + 2 * np.pi * np.arange(3) / 3
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(3)], 1)
    foot = np.array([s, n, 0.0]) + 0.8 * out
    roof.rods(pole, grey, foot, np.array([s, n, 0.6 * high]) + 0 * out, 0.025, 4)
    at = np.array([s, n, high - 1.0]) + 0.28 * out
    roof.rods(pole, grey, np.array([s, n, high - 0.3]) + 0 * out, at + [0, 0, 0.7], 0.02, 4)
    roof.rods(("paint", "pole"), (0.58, 0.58, 0.57), at - [0, 0, 0.7], at + [0, 0, 0.9], 0.13, 4)


def pipes(roof: Roof, rng: np.random.Generator) -> None:
    """A bundle of pipes on sleepers across the roof."""
    long = rng.uniform(5, 14)
    across = rng.random() < 0.5
    at = roof.spot(rng, (0.7, long) if across else (long, 0.7), 0.0)
    if at is None:
        return
    axis = np.array([0.0, 1.0] if across else [1.0, 0.0])
    side = axis[::-1]
    for k, radius in zip((-0.22, -0.02, 0.2), (0.05, 0.07, 0.035), strict=True):
        a, b = (np.append(np.asarray(at) + side * k + axis * t * long, 0.24) for t in (-0.5, 0.5))
        tint = (0.8, 0.8, 0.8) if k < 0.1 else (0.35, 0.2, 0.12)
        roof.rods(_METAL if k < 0.1 else _PAINT, tint, a, b, radius, 6)
    feet = np.asarray(at) + axis * np.linspace(-0.48, 0.48, max(2, int(long / 2)))[:, None] * long
    size = (0.65, 0.12, 0.19) if across else (0.12, 0.65, 0.19)
    roof.box(("wood", "roof"), (0.22, 0.18, 0.13), *feet.T, size, -0.02)


def solar(roof: Roof, rng: np.random.Generator) -> None:
    """Rows of panels of 1.0 x 1.65 m, tilted."""
    rows, columns = int(rng.integers(2, 5)), int(rng.integers(4, 9))
    at = roof.spot(rng, (columns * 1.02, rows * 1.9))
    if at is None:
        return
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(columns)))
    s = at[0] + (j - columns / 2) * 1.02
    n = at[1] + (i - (rows - 1) / 2) * 1.9 + 0.7
    z = roof.z + 0.15
    panel = slopes(s, s + 1.0, n, z, n - 1.6, z + 0.5)
    roof.panels.add(("glass", "roof"), (0.9, 0.95, 1.15), panel, roof.frame)
    frame = slopes(s - 0.02, s + 1.02, n + 0.02, z - 0.03, n - 1.62, z + 0.47)
    roof.panels.add(_METAL, (0.9, 0.9, 0.9), frame, roof.frame)
    for y, h in ((0.0, 0.15), (-1.5, 0.6)):
        leg = block(s + 0.4, s + 0.46, roof.z - 0.02, roof.z + h, n + y - 0.06, n + y, "flrk")
        roof.panels.add(_METAL, (0.7, 0.7, 0.7), leg, roof.frame)


def stack(roof: Roof, rng: np.random.Generator) -> None:
    """A brick chimney with pots."""
    x, h = rng.uniform(0.9, 2.2), rng.uniform(1.2, 2.4)
    at = roof.spot(rng, (x, 0.7))
    if at is None:
        return
    roof.box(("brick", "roof"), (0.2, 0.12, 0.09), *at, (x, 0.65, h), -0.05)
    roof.box(("concrete", "roof"), (1, 1, 1), *at, (x + 0.14, 0.79, 0.12), h - 0.05, "flrtkb")
    pots = at[0] + np.arange(-x / 2 + 0.3, x / 2 - 0.2, 0.42)
    start = np.stack([pots, np.full_like(pots, at[1]), np.full_like(pots, h + 0.06)], 1)
    roof.rods(_PAINT, (0.3, 0.15, 0.09), start, start + [0, 0, 0.45], 0.11, 7)


def hatch(roof: Roof, rng: np.random.Generator) -> None:
    """Crates, a hatch and offcuts that somebody left."""
    at = roof.spot(rng, (1.6, 1.6), 0.0)
    if at is None:
        return
    roof.box(_METAL, (0.8, 0.8, 0.8), *at, (1.0, 1.0, 0.45), -0.05)
    roof.box(_PAINT, (0.3, 0.3, 0.3), *at, (1.1, 1.1, 0.08), 0.4, "flrtkb")


def water_tank(roof: Roof, rng: np.random.Generator) -> None:
    """A wooden tank with iron hoops and a conical roof, on braced legs."""
    radius, high, legs = rng.uniform(1.3, 1.9), rng.uniform(2.8, 3.8), rng.uniform(2.2, 4.5)
    at = roof.spot(rng, (2 * radius + 0.6, 2 * radius + 0.6))
    if at is None:
        return
    s, n = at
    wood = rng.uniform(0.1, 0.2) * np.array([1.0, 0.82, 0.64])
    iron, grey = ("paint", "obstacle"), (0.07, 0.065, 0.06)
    axis = roof.world(s, n, 0.0)
    levels = np.array([[0, 0, legs + 0.3], [0, 0, legs + 0.3 + high]])
    tank = tube(axis + levels, [radius, 0.94 * radius], 18, wood)
    uv = tank.uv.copy()
    uv[:, 0] *= 1.0
    roof.panels.add_geometry(
        ("wood", "obstacle"), geometry(tank.vertices, tank.faces, uv, tank.tint)
    )
    top = legs + 0.3 + high
    cone = tube(axis + np.array([[0, 0, top], [0, 0, top + 1.0]]), [1.04 * radius, 0.05], 18)
    roof.panels.add_geometry(("shingle", "obstacle"), cone.tinted((0.1, 0.1, 0.1)))
    for t in np.linspace(0.08, 0.9, 6):
        z = legs + 0.3 + t * high
        r = radius * (1 - 0.06 * t) + 0.012
        hoop = tube(
            axis + np.array([[0, 0, z - 0.03], [0, 0, z + 0.03]]), r, 18, grey, capped=False
        )
        roof.panels.add_geometry(iron, hoop)
    d = 0.68 * radius
    corner = np.array([[-d, -d], [d, -d], [d, d], [-d, d]]) + [s, n]
    low, up = (np.column_stack([corner, np.full(4, z)]) for z in (-0.02, legs))
    roof.rods(iron, grey, low, up, 0.07, 4)
    following = np.roll(np.arange(4), -1)
    roof.rods(iron, grey, low + [0, 0, 0.15], up[following] - [0, 0, 0.2], 0.018, 4)
    roof.rods(iron, grey, low[following] + [0, 0, 0.15], up - [0, 0, 0.2], 0.018, 4)
    roof.rods(iron, grey, up, up[following], 0.06, 4)
    joist = n + np.linspace(-0.85, 0.85, 6) * radius
    half = 0.98 * np.sqrt(np.maximum(radius**2 - (joist - n) ** 2, 0.2))
    for y, h in zip(joist, half, strict=True):
        roof.box(("wood", "obstacle"), wood, s, y, (2 * h, 0.14, 0.3), legs, "flrtkb")


def billboard(roof: Roof, rng: np.random.Generator) -> None:
    """An advertisement of 2:1 on a steel frame, facing out over the longest side."""
    wide = min(rng.uniform(6, 10), 1.6 * roof.reach[0])
    high = wide / 2
    at = roof.spot(rng, (wide, 2.4), edge_m=0.8)
    if at is None:
        return
    s, n = at
    key, grey = ("paint", "street_furniture"), (0.12, 0.12, 0.12)
    low = 1.6
    cell = np.array([rng.integers(POSTER_COLUMNS), rng.integers(POSTER_ROWS)])
    corner = roof.world(s + wide / 2 * np.array([-1, 1, 1, -1]), n + 1.0,
                        [low, low, low + high, low + high])  # fmt: skip
    uv = POSTER_M * (np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + cell)
    roof.panels.add_world(("poster", "street_furniture"), corner[None], uv[None], (0.9, 0.9, 0.9))
    roof.box(key, grey, s, n + 0.93, (wide + 0.1, 0.1, high + 0.1), low - 0.05, "lrtkb")
    x = s + np.linspace(-0.46, 0.46, 6) * wide
    k, zero = np.ones(6), np.zeros(6)
    front, back = np.stack([x, (n + 0.85) * k, zero], 1), np.stack([x, (n - 1.1) * k, zero], 1)
    roof.rods(key, grey, front - [0, 0, 0.02], front + [0, 0, low + high], 0.06, 4)
    roof.rods(key, grey, back - [0, 0, 0.02], front + [0, 0, low + 0.85 * high], 0.04, 4)
    roof.rods(key, grey, back, front + [0, 0, low + 0.2 * high], 0.03, 4)
    for t in (0.1, 0.5, 0.9):
        z = low + t * high
        roof.rods(key, grey, front[0] + [0, 0, z], front[-1] + [0, 0, z], 0.03, 4)
    # A catwalk below the board, and lamps on arms that light it from below.
    roof.box(_METAL, (0.7, 0.7, 0.7), s, n + 1.35, (wide, 0.6, 0.05), low - 0.4, "flrtkb")
    lamp = s + np.array([-0.3, 0.0, 0.3]) * wide
    roof.box(key, grey, lamp, n + 1.75, (0.4, 0.16, 0.12), low - 0.3, "flrtkb")
    roof.box(key, grey, lamp, n + 1.5, (0.05, 0.5, 0.05), low - 0.36, "lrtbfk")


def mast(roof: Roof, s, n, low: float, high_m: float, rng) -> None:
    """A stepped mast with cross arms, a lamp at its tip and three stays."""
    pole, tint = ("paint", "pole"), (0.5, 0.5, 0.5)
    heights = low + high_m * np.array([0.0, 0.4, 0.75, 1.0])
    for k, radius in enumerate((0.16, 0.1, 0.045)):
        start, stop = (s, n, heights[k] - 0.1 * (k == 0)), (s, n, heights[k + 1])
        roof.rods(pole, tint, start, stop, radius, 6)
    t = rng.uniform(0.3, 0.95, 5)
    arm = np.stack([np.full(5, s), np.full(5, n), low + high_m * t], 1)
    turn = rng.uniform(0, 2 * np.pi, 5)
    reach = np.stack([np.cos(turn), np.sin(turn), np.zeros(5)], 1) * rng.uniform(0.4, 1.0, (5, 1))
    roof.rods(pole, tint, arm - reach, arm + reach, 0.025, 4)
    for end in (arm - reach, arm + reach):
        roof.rods(pole, (0.6, 0.6, 0.6), end - [0, 0, 0.4], end + [0, 0, 0.5], 0.02, 4)
    turn = rng.uniform(0, 2) + 2 * np.pi * np.arange(3) / 3
    foot = np.stack([np.cos(turn), np.sin(turn)], 1) * np.minimum(0.22 * high_m, 1.6)
    foot = np.column_stack([foot + [s, n], np.full(3, low)])
    top = np.array([s, n, low + 0.72 * high_m]) + np.zeros((3, 3))
    roof.rods(("metal", "wire"), (0.8, 0.8, 0.8), foot, top, 0.009, 3)
    tip = (0.16, 0.16, 0.2)
    roof.box(("signal", "pole"), (0.6, 0.06, 0.05), s, n, tip, low + high_m, "flrtkb")
