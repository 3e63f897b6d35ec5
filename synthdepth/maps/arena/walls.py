"""Walls to fly through and over: gates, windows, arches, ramps, steps and decks."""

import numpy as np

from synthdepth.maps.arena.rails import railing
from synthdepth.maps.arena.solids import cuboids, wedge
from synthdepth.maps.arena.zone import OBSTACLE, Zone, square_yaws
from synthdepth.maps.bars import beams
from synthdepth.maps.geometry import Geometry, Model, geometry, join, merge, place, quads

_WALLS = ("painted_block", "brick", "plywood", "plaster", "concrete")


def pierced_wall(
    length_m: float, height_m: float, thickness_m: float, holes: list[tuple], tint
) -> Geometry:
    """A wall along x with rectangular holes (x0, x1, z0, z1), which do not overlap in x.

    Built of solid pieces beside, below and above each hole.
    """
    pieces, x = [], -length_m / 2
    for x0, x1, z0, z1 in sorted(holes):
        pieces += [(x, x0, 0, height_m), (x0, x1, 0, z0), (x0, x1, z1, height_m)]
        x = x1
    pieces.append((x, length_m / 2, 0, height_m))
    solid = [p for p in pieces if p[1] - p[0] > 0.02 and p[3] - p[2] > 0.02]
    parts = []
    for x0, x1, z0, z1 in solid:
        base = [[(x0 + x1) / 2, 0, z0]]
        sunk = 0.05 if z0 == 0 else 0.0
        part = cuboids(base, (x1 - x0, thickness_m, z1 - z0), 0.0, tint, sunk)
        # One texture over the whole wall, not one a piece.
        v = part.vertices
        uv = np.column_stack([v[:, 0] + v[:, 1], v[:, 2]])
        parts.append(geometry(v, part.faces, uv, part.tint))
    return join(parts)


def arch(span_m: float, rise_m: float, depth_m: float, band_m: float, tint) -> Geometry:
    """A round-headed arch across x: legs up to `rise_m`, then a half circle; depth along y."""
    r = span_m / 2
    t = np.linspace(0, np.pi, 19)
    inner = np.column_stack([r * np.cos(t), rise_m + r * np.sin(t)])
    outer = np.column_stack([(r + band_m) * np.cos(t), rise_m + (r + band_m) * np.sin(t)])
    inner = np.concatenate([[[r, -0.05]], inner, [[-r, -0.05]]])
    outer = np.concatenate([[[r + band_m, -0.05]], outer, [[-r - band_m, -0.05]]])
    y = depth_m / 2

    def at(profile, depth):
        return np.column_stack([profile[:, 0], np.full(len(profile), depth), profile[:, 1]])

    def strip(a, b):
        return np.stack([a[:-1], a[1:], b[1:], b[:-1]], axis=1)

    corners = np.concatenate(
        [
            strip(at(outer, y), at(outer, -y)),
            strip(at(inner, -y), at(inner, y)),
            strip(at(outer, -y), at(inner, -y)),
            strip(at(inner, y), at(outer, y)),
        ]
    )
    run = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(outer, axis=0), axis=1))])
    start = np.tile(np.column_stack([run[:-1], 0 * run[:-1]]), (4, 1))
    return quads(corners, tint, start)


def _openings(rng: np.random.Generator, length: float, height: float) -> list[tuple]:
    """A gate and windows in a wall, apart from one another."""
    holes, x = [], -length / 2 + rng.uniform(0.8, 2.5)
    while x < length / 2 - 1.5:
        wide = rng.uniform(0.9, 3.6)
        if x + wide > length / 2 - 0.6:
            break
        sill = 0.0 if rng.random() < 0.35 else rng.uniform(0.6, max(0.65, 0.5 * height))
        head = min(sill + rng.uniform(1.2, 3.4), height - 0.35)
        if head - sill > 0.7:
            holes.append((x, x + wide, sill, head))
        x += wide + rng.uniform(0.7, 4.0)
    return holes


def wall_maze(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Walls with gates and windows, along both directions, some with copings or rails."""
    models = []
    for spot in zone.spots(rng, 12.0, shake=0.45, share=0.85):
        length, height = rng.uniform(6, 14), rng.uniform(2.2, min(8.0, 0.5 * zone.height_m + 2))
        thick, tint = rng.choice([0.12, 0.2, 0.3, 0.5]), zone.palette.tint(rng)
        material = _WALLS[rng.integers(len(_WALLS))]
        if material == "concrete":
            tint = np.ones(3) * rng.uniform(0.8, 1.1)
        wall = pierced_wall(length, height, thick, _openings(rng, length, height), tint)
        model: dict = {(material, OBSTACLE): wall}
        if rng.random() < 0.35:
            model["concrete", OBSTACLE] = join(
                [model.get(("concrete", OBSTACLE), join([])),
                 cuboids([[0, 0, height]], (length + 0.1, thick + 0.12, 0.1), 0.0, sunk_m=0.0)]
            )  # fmt: skip
        elif zone.near and rng.random() < zone.thin:
            path = [[-length / 2 + 0.1, 0, height - 0.01], [length / 2 - 0.1, 0, height - 0.01]]
            model["paint", "barrier"] = railing(path, zone.palette.tint(rng), 1.0)
        if rng.random() < 0.5:  # a return, which makes a corner of it
            side = rng.uniform(3, 6)
            other = place(
                {(material, OBSTACLE): pierced_wall(
                    side, height, thick, _openings(rng, side, height), tint)},
                [length / 2 - thick / 2, side / 2 + thick / 2 + 0.01, 0], np.pi / 2,
            )  # fmt: skip
            model = merge([model, other])
        models.append(place(model, [*spot, 0.0], float(square_yaws(rng, 1, 0.15)[0])))
    return [merge(models)]


def arch_alley(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Arches and portals of every size, in files that one can fly along."""
    models = []
    for spot in zone.spots(rng, 11.0, shake=0.5, share=0.8):
        span = rng.uniform(2.0, 9.0)
        band, depth = rng.uniform(0.3, 0.9), rng.uniform(0.4, 2.2)
        tint, rise = zone.palette.tint(rng), rng.uniform(1.0, 5.0)
        if rng.random() < 0.7:
            part = arch(span, rise, depth, band, tint)
        else:
            high = rise + 0.4 * span
            hole = [(-span / 2, span / 2, 0.0, high)]
            part = pierced_wall(span + 2 * band, high + band, depth, hole, tint)
        material = ("painted_block", "brick", "plaster")[rng.integers(3)]
        yaw = float(square_yaws(rng, 1, 0.25)[0])
        models.append(place({(material, OBSTACLE): part}, [*spot, 0.0], yaw))
    return [merge(models)]


def ramps_and_steps(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Decks reached by ramps and by flights of steps, with railings; single wedges between."""
    models = []
    for spot in zone.spots(rng, 17.0, shake=0.35, share=0.9):
        high, wide = rng.uniform(0.8, 5.0), rng.uniform(2.5, 6.0)
        deck = rng.uniform(3.0, 6.5)
        tint = zone.palette.tint(rng)
        run = high * rng.uniform(1.6, 2.6)
        count = max(int(high / 0.18), 2)
        number = np.arange(1, count)
        away = deck + 0.3 * (count - 1 - number) + 0.15
        size = np.column_stack([0 * away + 0.3, 0 * away + wide, high / count * number])
        steps = cuboids(np.column_stack([away, 0 * away, 0 * away]), size, 0.0, tint)
        body = cuboids([[deck / 2, 0, 0]], (deck, wide, high), 0.0, tint)
        ramp = wedge(run, wide, high, zone.palette.tint(rng)).moved([-run, 0, 0])
        coat = "plywood" if rng.random() < 0.4 else "painted_block"
        model = merge(
            [{("painted_block", OBSTACLE): join([body, steps])}, {(coat, OBSTACLE): ramp}]
        )
        if zone.near:
            edge = wide / 2 - 0.08
            end = deck + 0.3 * (count - 1)
            path = np.array([[-run + 0.3, 0, 0.05], [0, 0, high], [deck, 0, high], [end, 0, 0.1]])
            coat = zone.palette.tint(rng)
            rails = [railing(path + [0, s * edge, 0], coat, 1.05) for s in (-1, 1)]
            model["paint", "barrier"] = join(rails)
            model["hazard", OBSTACLE] = cuboids(
                [[deck - 0.1, 0, high]], (0.2, wide - 0.3, 0.006), sunk_m=0
            )
        models.append(place(model, [*spot, 0.0], float(square_yaws(rng, 1, 0.15)[0])))
    return [merge(models)]


def portal_frames(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """The bare steel of a hall: portal frames, purlins, wind braces, here and there sheeting."""
    x, y = zone.size_m / 2 - 4.0
    high = rng.uniform(5.0, max(6.0, 0.5 * zone.height_m))
    span = min(2 * y, rng.uniform(16, 30))
    frames = max(int(2 * x / rng.uniform(5.5, 8.0)), 2)
    at = np.linspace(-x, x, frames)
    tint = zone.palette.tint(rng) * 0.8
    ridge = high + 0.12 * span
    start, stop = [], []
    for f in at:
        knots = [[f, -span / 2, -0.05], [f, -span / 2, high], [f, 0, ridge], [f, span / 2, high],
                 [f, span / 2, -0.05]]  # fmt: skip
        start += knots[:-1]
        stop += knots[1:]
    main = beams(start, stop, 0.26, 0.32, tint)
    rows = np.linspace(-1, 1, 9)
    line_z = high + 0.24 + (ridge - high) * (1 - np.abs(rows))
    a = np.column_stack([np.full(9, -x), rows * span / 2, line_z])
    b = a * [-1, 1, 1]
    thin = [beams(a, b, 0.1, 0.16, tint * 0.9)]
    if zone.near:
        s, e = [], []
        for i in (0, frames - 2):
            for side in (-span / 2, span / 2):
                s += [[at[i], side, 0.1], [at[i + 1], side, 0.1]]
                e += [[at[i + 1], side, high - 0.1], [at[i], side, high - 0.1]]
        thin.append(beams(s, e, 0.05, 0.05, tint * 0.8))
    models: list[Model] = [{("paint", OBSTACLE): join([main, *thin])}]
    sheets = []
    for i in range(frames - 1):
        for side in (-1, 1):
            if rng.random() < 0.3:
                low = rng.choice([0.0, 1.2, 2.6])
                w = at[i + 1] - at[i]
                panel = cuboids(
                    [[(at[i] + at[i + 1]) / 2, side * (span / 2 + 0.19), low]],
                    (w, 0.06, high - low), 0.0, zone.palette.tint(rng), 0.05 if low == 0 else 0.0,
                )  # fmt: skip
                sheets.append(panel)
    models.append({("sheeting", OBSTACLE): join(sheets)})
    return models
