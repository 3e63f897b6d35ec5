"""Thin things: pillars with cables and bunting, race gates, hoops, nets, sails, festoons."""

import numpy as np
from scipy.spatial import cKDTree

from synthdepth.maps.arena.solids import cuboids, cylinder
from synthdepth.maps.arena.zone import OBSTACLE, Zone, at_ground, square_yaws
from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.lattice import between, lattice
from synthdepth.maps.furniture.parts import hoop
from synthdepth.maps.furniture.poles import catenary, wires
from synthdepth.maps.geometry import Geometry, Model, geometry, join, merge, place, quads

_STEEL = np.array([0.3, 0.31, 0.32])
_CABLE = (0.03, 0.03, 0.032)


def bunting(rng: np.random.Generator, lines: np.ndarray, palette) -> Geometry:
    """Pennants of 25 cm hung along polylines (k, n, 3) [m], about two a metre."""
    parts = []
    for line in lines:
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.arange(0.3, length[-1] - 0.4, 0.48)
        a, b = (
            np.column_stack([np.interp(at + d, length, line[:, i]) for i in range(3)])
            for d in (0.0, 0.24)
        )
        swing = rng.normal(0, 0.07, (len(at), 2))
        tip = (a + b) / 2 - np.column_stack([swing, np.full(len(at), 0.3)])
        corners = np.stack([a, tip, b], 1)
        tint = np.repeat(palette.tints(rng, len(at)), 3, axis=0)
        uv = np.tile([[0, 0.3], [0.12, 0], [0.24, 0.3]], (len(at), 1))
        parts.append(geometry(corners, np.arange(3 * len(at)), uv, tint))
    return join(parts)


def strung(rng: np.random.Generator, tops: np.ndarray, zone: Zone, reach_m: float) -> list[Model]:
    """Cables between some neighbouring tops (k, 3), a share of them with pennants or bulbs."""
    pairs = cKDTree(tops[:, :2]).query_pairs(reach_m, output_type="ndarray")
    pairs = pairs[rng.random(len(pairs)) < 0.25 + 0.5 * zone.thin]
    if not len(pairs):
        return []
    drop = rng.uniform(0.1, 0.6, (len(pairs), 2, 1)) * [0, 0, 1.0]
    lines = catenary(
        tops[pairs[:, 0]] - drop[:, 0], tops[pairs[:, 1]] - drop[:, 1],
        rng.uniform(0.008, 0.05, len(pairs)), 10,
    )  # fmt: skip
    kind = rng.random(len(pairs))
    models: list[Model] = [{("paint", "wire"): wires(lines, 0.008, _CABLE)}]
    flagged, lit = lines[kind < 0.4], lines[kind > 0.85]
    if len(flagged):
        models.append({("fabric", "wire"): bunting(rng, flagged, zone.palette)})
    for line in lit:
        bulbs = line[1:-1] - [0, 0, 0.12]
        sockets = round_bars(bulbs + [0, 0, 0.11], bulbs + [0, 0, 0.03], 0.02, _CABLE, 4)
        models.append({("paint", "wire"): sockets, ("lamp", "wire"): _bulbs(bulbs)})
    return models


def _bulbs(at: np.ndarray) -> Geometry:
    """Small lamp faces under (k, 3) that shine down."""
    e = 0.05
    face = np.array([[-e, e, 0], [e, e, 0], [e, -e, 0], [-e, -e, 0]])
    return quads(at[:, None] + face, (0.62, 0.5, 0.34))


def pillar_field(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Round and square columns and thin poles at random, with cables between their tops."""
    xy = zone.spots(rng, 6.5, shake=0.8, share=0.8)
    n = len(xy)
    high = rng.uniform(2.5, max(5.0, 0.65 * zone.height_m), n)
    kind = rng.random(n)
    slim = kind < 0.25 + 0.5 * zone.thin
    square = ~slim & (kind > 0.8)
    yaw = rng.uniform(0, np.pi, n)
    tint = zone.palette.tints(rng, n)
    girth = np.column_stack([rng.uniform(0.3, 1.1, (n, 1)).repeat(2, 1), high])
    models: list[Model] = [
        {("painted_block", OBSTACLE): cuboids(
            at_ground(xy[square]), girth[square], yaw[square], tint[square])}
    ]  # fmt: skip
    round_ones = [
        cylinder(rng.uniform(0.2, 0.65), high[i], tint[i], 18).moved([*xy[i], 0.0])
        for i in np.flatnonzero(~slim & ~square)
    ]
    models.append({("enamel", OBSTACLE): join(round_ones)})
    if slim.any():
        lean = rng.normal(0, 0.01, (int(slim.sum()), 2)) * high[slim, None]
        foot = at_ground(xy[slim], -0.05)
        models.append(
            {("paint", "pole"): round_bars(
                foot, foot + np.column_stack([lean, high[slim]]), 0.045, 0.8 * _STEEL, 6)}
        )  # fmt: skip
    if zone.near:
        models += strung(rng, at_ground(xy, high), zone, 10.0)
    return models


def race_gates(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Gates of drone races: tube squares with banners, hoops on stands, flags, slalom poles."""
    models: list[Model] = []
    for spot in zone.spots(rng, 8.0, shake=0.6, share=0.85):
        kind, yaw = rng.random(), float(rng.uniform(0, 2 * np.pi))
        tint, second = zone.palette.tints(rng, 2)
        if kind < 0.45:
            model = _tube_gate(rng, tint)
        elif kind < 0.7:
            r, stand = rng.uniform(0.8, 2.2), rng.uniform(0.3, 4.0)
            ring = hoop(r, rng.uniform(0.025, 0.08), 32, 6).tinted(tint)
            model = {
                ("paint", OBSTACLE): join(
                    [ring.moved([0, 0, stand + r]),
                     round_bars([[0, 0, -0.05]], [[0, 0, stand]], 0.04, second, 6),
                     cuboids([[0, 0, 0]], (0.8, 0.8, 0.06), 0.0, second)]
                )
            }  # fmt: skip
        elif kind < 0.88:
            model = _feather_flag(rng, tint)
        else:
            along = np.arange(5) * 2.2 - 4.4
            low = np.column_stack([along, rng.normal(0, 0.4, 5), 0 * along - 0.05])
            model = {("hazard", "pole"): round_bars(low, low + [0, 0, rng.uniform(1.6, 3.4)], 0.03)}
        models.append(place(model, [*spot, 0.0], yaw))
    return [merge(models)]


def _tube_gate(rng: np.random.Generator, tint) -> dict[tuple[str, str], Geometry]:
    """A square of tubes, sometimes two storeys high, with cloth panels round the opening."""
    a, t = rng.uniform(1.5, 3.4), rng.uniform(0.02, 0.05)
    low, storeys = (0.0 if rng.random() < 0.5 else rng.uniform(0.5, 2.5)), int(rng.integers(1, 3))
    top = low + a * storeys
    start = [[-a / 2, 0, -0.05], [a / 2, 0, -0.05]]
    stop = [[-a / 2, 0, top], [a / 2, 0, top]]
    for s in range(storeys + 1):
        start.append([-a / 2, 0, low + s * a + 0.03])
        stop.append([a / 2, 0, low + s * a + 0.03])
    for x in (-a / 2, a / 2):
        start.append([x, -0.8, 0.02])
        stop.append([x, 0.8, 0.02])
        start.append([x, 0.75, 0.02])
        stop.append([x, 0, min(1.3, top)])
    parts = {("paint", OBSTACLE): round_bars(start, stop, t, _STEEL, 6)}
    w, panels = 0.45, []
    if rng.random() < 0.75:
        for s in range(storeys):
            z0, z1 = low + s * a + 0.08, low + (s + 1) * a
            panels += [
                [
                    [-a / 2, 0.03, z0],
                    [-a / 2 + w, 0.03, z0],
                    [-a / 2 + w, 0.03, z1],
                    [-a / 2, 0.03, z1],
                ],
                [
                    [a / 2 - w, 0.03, z0],
                    [a / 2, 0.03, z0],
                    [a / 2, 0.03, z1],
                    [a / 2 - w, 0.03, z1],
                ],
            ]
        panels.append([[-a / 2, 0.03, top], [a / 2, 0.03, top], [a / 2, 0.03, top + w],
                       [-a / 2, 0.03, top + w]])  # fmt: skip
        parts["fabric", OBSTACLE] = quads(panels, tint)
    return parts


def _feather_flag(rng: np.random.Generator, tint) -> Model:
    high = rng.uniform(2.8, 5.0)
    z = np.linspace(0.9, high, 9)
    t = (z - 0.9) / (high - 0.9)
    mast_x = 0.5 * t**3
    wide = 0.75 * np.sin(np.pi * np.clip(0.16 + 0.8 * t, 0, 1)) ** 0.7
    wave = 0.07 * np.sin(5 * t + rng.uniform(0, 6))
    a = np.column_stack([mast_x, 0 * z, z])
    b = np.column_stack([mast_x + wide, wave, z - 0.1])
    cloth = quads(
        np.stack([a[:-1], b[:-1], b[1:], a[1:]], 1), tint, np.column_stack([0 * z, z])[:-1]
    )
    mast = np.concatenate([[[0, 0, -0.05]], a])
    return {
        ("fabric", OBSTACLE): cloth,
        ("paint", "pole"): wires(mast[None], 0.02, (0.1, 0.1, 0.1), 5),
    }


def net_course(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Nets between poles, cargo nets and shade sails."""
    models: list[Model] = []
    for spot in zone.spots(rng, 13.0, shake=0.4, share=0.85):
        wide, high = rng.uniform(5, 11), rng.uniform(3, 8)
        at = np.linspace(-wide / 2, wide / 2, 3)
        foot = np.column_stack([at, 0 * at, 0 * at - 0.05])
        posts = round_bars(foot, foot + [0, 0, high + 0.1], 0.05, 0.8 * _STEEL, 6)
        model: dict = {("paint", "pole"): posts}
        kind = rng.random()
        if kind < 0.6:
            low = 0.0 if rng.random() < 0.6 else rng.uniform(0.5, 1.5)
            mesh = rng.choice([0.15, 0.25, 0.4])
            rows = np.arange(low + 0.02, high, mesh)
            side = np.arange(-wide / 2, wide / 2, mesh)
            sag = 0.1 * np.sin(np.pi * np.linspace(0, 1, 7))
            x = np.linspace(-wide / 2, wide / 2, 7)
            lines = np.stack(np.broadcast_arrays(x, sag * 0.7, rows[:, None] - sag), -1)
            up = np.linspace(low, high, 4)
            falls = np.stack(np.broadcast_arrays(side[:, None], 0.05, up), -1)
            cord = (0.5, 0.5, 0.47) if rng.random() < 0.5 else (0.05, 0.09, 0.06)
            model["fabric", "barrier"] = join(
                [wires(lines, 0.006, cord), wires(falls, 0.006, cord)]
            )
        else:
            depth = rng.uniform(4, 7)
            back = foot + [0, depth, 0]
            model["paint", "pole"] = join(
                [posts, round_bars(back, back + [0, 0, 0.7 * high], 0.05, 0.8 * _STEEL, 6)]
            )
            s, t = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 7), indexing="ij")
            z = high - 0.3 * high * t - 0.9 * np.sin(np.pi * s) * np.sin(np.pi * t)
            p = np.stack([(s - 0.5) * wide * (1 - 0.2 * np.sin(np.pi * t)), t * depth, z], -1)
            cell = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], 2).reshape(-1, 4, 3)
            model["fabric", OBSTACLE] = quads(cell, zone.palette.tint(rng), cell[:, 0, :2])
        models.append(place(model, [*spot, 0.0], float(square_yaws(rng, 1, 0.3)[0])))
    return [merge(models)]


def gantries(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Lattice gantries in a row, with signs, hung cables and cross bars."""
    models: list[Model] = []
    for spot in zone.spots(rng, 16.0, shake=0.35, share=0.85):
        span, high, half = rng.uniform(6, 13), rng.uniform(3.5, 10.0), rng.uniform(0.15, 0.4)
        tint = zone.palette.tint(rng) * 0.9
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1.0]]) * half
        legs = []
        for x in (-span / 2, span / 2):
            low = np.column_stack([square + [x, 0], np.full(4, -0.05)])
            top = np.column_stack([square + [x, 0], np.full(4, high)])
            legs.append(lattice(between(low, top, max(int(high / 0.9), 2)), 0.03, 0.014, tint))
        left = np.column_stack(
            [np.full(4, -span / 2 - half), square[:, 0], high + half + square[:, 1]]
        )
        right = left * [-1, 1, 1]
        truss = lattice(between(left, right, max(int(span / 0.9), 3)), 0.03, 0.014, tint)
        model: dict = {("paint", OBSTACLE): join([*legs, truss])}
        if rng.random() < 0.5:
            w, h = rng.uniform(1.0, span * 0.5), rng.uniform(0.6, 1.6)
            board = cuboids([[rng.uniform(-0.2, 0.2) * span, -half - 0.08, high - 0.3 * h]],
                            (w, 0.06, h), 0.0, zone.palette.tint(rng), 0.0)  # fmt: skip
            model["hazard" if rng.random() < 0.4 else "painted_block", OBSTACLE] = board
        hung = np.column_stack([rng.uniform(-0.4, 0.4, 4) * span, np.zeros(4), np.full(4, high)])
        model["fabric", "wire"] = beams(
            hung - np.column_stack([np.zeros((4, 2)), rng.uniform(0.5, 0.7 * high, 4)]), hung,
            0.05, 0.012, zone.palette.tints(rng, 4),
        )  # fmt: skip
        models.append(place(model, [*spot, 0.0], float(square_yaws(rng, 1, 0.15)[0])))
    return [merge(models)]
