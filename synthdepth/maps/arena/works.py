"""Tanks, balls, cones and pipes; scaffolded blocks; groves with blocks among the trees."""

import numpy as np

from synthdepth.maps.arena.rails import railing
from synthdepth.maps.arena.solids import cone, cuboids, cylinder, lying, pipe, sphere
from synthdepth.maps.arena.yard import block_rows
from synthdepth.maps.arena.zone import OBSTACLE, Zone, square_yaws
from synthdepth.maps.bars import round_bars
from synthdepth.maps.furniture.structures import scaffold
from synthdepth.maps.geometry import Model, join, merge, place

_STEEL = np.array([0.3, 0.31, 0.32])


def round_things(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Balls, cones, drums and silos, some on legs, some with a ladder and a railing."""
    models: list[Model] = []
    for spot in zone.spots(rng, 7.5 + 0.6 * zone.object_m, shake=0.6, share=0.85):
        tint, kind = zone.palette.tint(rng), rng.random()
        r = zone.object_m * rng.uniform(0.12, 0.45)
        if kind < 0.3:
            model = {("enamel", OBSTACLE): sphere(r, tint)}
            if r > 1.2 and rng.random() < 0.5:
                model = _on_legs(model, r, rng.uniform(1.0, 4.0), tint)
        elif kind < 0.5:
            high = r * rng.uniform(1.2, 4.0)
            tip = 0.0 if rng.random() < 0.5 else 0.4 * r
            model = {("enamel", OBSTACLE): cone(r, high, tint, tip_m=tip)}
        elif kind < 0.85:
            high = min(r * rng.uniform(0.8, 5.0), zone.height_m)
            model = {("enamel", OBSTACLE): cylinder(r, high, tint)}
            if zone.near and high > 2.5:
                model = merge([model, _ladder(r, high, tint, rng)])
        else:
            long = rng.uniform(3.0, 9.0)
            tank = lying(cylinder(0.7 * r, long, tint), long, 0.7 * r)
            model = {("enamel", OBSTACLE): tank}
        models.append(place(model, [*spot, 0.0], float(rng.uniform(0, 2 * np.pi))))
    return [merge(models)]


def _on_legs(model: Model, r: float, high: float, tint) -> dict:
    turn = np.pi / 3 * np.arange(6)
    foot = np.column_stack([0.85 * r * np.cos(turn), 0.85 * r * np.sin(turn), 0 * turn - 0.05])
    legs = round_bars(foot, foot + [0, 0, high + 0.6 * r], 0.08, 0.7 * np.asarray(tint), 6)
    ties = round_bars(
        foot + [0, 0, 0.3], np.roll(foot, -1, axis=0) + [0, 0, high], 0.018, _STEEL, 4
    )
    raised = {key: part.moved([0, 0, high]) for key, part in model.items()}
    return merge([raised, {("paint", OBSTACLE): join([legs, ties])}])


def _ladder(r: float, high: float, tint, rng: np.random.Generator) -> Model:
    z = np.arange(0.4, high + 0.9, 0.3)
    at = np.column_stack([0 * z + r + 0.18, 0 * z, z])
    side = np.array([0, 0.22, 0])
    rungs = round_bars(at - side, at + side, 0.012, _STEEL, 4)
    rails = round_bars(
        [[r + 0.18, y, -0.05] for y in (-0.22, 0.22)],
        [[r + 0.18, y, high + 1.0] for y in (-0.22, 0.22)], 0.02, _STEEL, 5,
    )  # fmt: skip
    parts: dict = {("paint", OBSTACLE): join([rungs, rails])}
    if rng.random() < 0.6:
        turn = np.linspace(0.15, 2 * np.pi - 0.15, 25)
        edge = max(r - 0.12, 0.1)
        path = np.column_stack([edge * np.cos(turn), edge * np.sin(turn), 0 * turn + high - 0.01])
        parts["paint", "barrier"] = railing(path, tint, 1.05)
    return parts


def pipe_yard(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Pipes in rows and piles, drain rings upright, drums, and a rack of long pipes overhead."""
    models: list[Model] = []
    for spot in zone.spots(rng, 11.0, shake=0.45, share=0.85):
        tint, yaw = zone.palette.tint(rng), float(square_yaws(rng, 1, 0.3)[0])
        long, r = rng.uniform(2.5, 7.0), rng.uniform(0.25, 1.1)
        coat = "enamel"
        if rng.random() < 0.4:
            coat, tint = "concrete", np.ones(3) * rng.uniform(0.8, 1.1)
        levels = int(rng.integers(1, 4)) if r < 0.7 else 1
        count = int(rng.integers(levels, levels + 4))
        unit = pipe(long, r, 0.12 * r + 0.01, tint, 20)
        pile = [
            unit.moved(
                [rng.normal(0, 0.1), (i - (count - level - 1) / 2) * 2.02 * r, level * 1.75 * r]
            )
            for level in range(levels)
            for i in range(count - level)
        ]
        model = {(coat, OBSTACLE): join(pile)}
        models.append(place(model, [*spot, 0.0], yaw))
    if zone.size_m.min() > 40:
        models.append(_pipe_rack(rng, zone))
    drums = zone.spots(rng, 14.0, shake=0.9, share=0.7)
    for spot in drums:
        some = [
            cylinder(0.29, 0.88, zone.palette.tint(rng), 14, 0.015).moved(
                [*(spot + offset * 0.62), 0.0]
            )
            for offset in rng.permutation(
                np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), -1).reshape(-1, 2)
            )[: rng.integers(2, 7)]
        ]
        models.append({("enamel", OBSTACLE): join(some)})
    return [merge(models)]


def _pipe_rack(rng: np.random.Generator, zone: Zone) -> Model:
    """Trestles along x that carry pipes at two levels."""
    half, high = zone.size_m[0] / 2 - 3, rng.uniform(4.5, 8.0)
    y0, wide = 0.3 * zone.size_m[1], rng.uniform(2.0, 4.0)
    at = np.linspace(-half, half, max(int(2 * half / 7), 2))
    tint = zone.palette.tint(rng) * 0.8
    legs = cuboids(
        [[x, y0 + s * wide / 2, 0] for x in at for s in (-1, 1)],
        (0.22, 0.22, high + 0.3),
        0.0,
        tint,
    )
    bars = cuboids(
        [[x, y0, z - 0.22] for x in at for z in (high, high - 1.6)],
        (0.2, wide, 0.2),
        0.0,
        tint,
        0.0,
    )
    rows = np.linspace(-0.4, 0.4, 5) * wide
    pipes = []
    for z in (high, high - 1.6):
        for y in rows[rng.random(5) < 0.75]:
            r = rng.uniform(0.05, 0.17)
            pipes.append(round_bars([[-half, y0 + y, z + r - 0.02]], [[half, y0 + y, z + r - 0.02]],
                                    r, zone.palette.tint(rng), 10))  # fmt: skip
    return {("paint", OBSTACLE): join([legs, bars]), ("enamel", OBSTACLE): join(pipes)}


def scaffolded_blocks(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Raw concrete blocks behind scaffolds on one or two sides, lower blocks between."""
    models: list[Model] = []
    for spot in zone.spots(rng, 21.0, shake=0.3, share=0.85):
        side = rng.uniform(5.0, 10.0, 2)
        high = rng.uniform(4.0, max(6.0, min(0.6 * zone.height_m, 16.0)))
        yaw = float(square_yaws(rng, 1, 0.1)[0])
        raw = rng.random() < 0.6
        tint = np.ones(3) if raw else zone.palette.tint(rng)
        block = cuboids([[0, 0, 0]], (*side, high), 0.0, tint)
        parts: list[Model] = [{("concrete" if raw else "painted_block", OBSTACLE): block}]
        if zone.near:
            parts.append(
                place(scaffold(rng, width_m=side[1], height_m=high), [side[0] / 2, 0, 0], 0.0)
            )
            if rng.random() < 0.5:
                other = scaffold(rng, width_m=side[0], height_m=0.7 * high)
                parts.append(place(other, [0, side[1] / 2, 0], np.pi / 2))
        models.append(place(merge(parts), [*spot, 0.0], yaw))
    return [merge(models)]


def grove(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Sparse blocks; the trees come with the map's planting."""
    return block_rows(rng, zone)
