"""What is built out into the sea: piers, jetties, groynes and breakwaters.

A line runs from the shore outwards; heights are above the sea's mean level, z = 0. Timber and
concrete that the tide wets are dark with weed.
"""

import itertools

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.coast.lofts import sagging
from synthdepth.maps.coast.pier_parts import (
    bents,
    bollards,
    cross_rail,
    ladder,
    lamps,
    pavilion,
    planks,
    rail,
)
from synthdepth.maps.coast.sea_works import breakwater, groyne
from synthdepth.maps.coast.staging import BedHeight, Walk, piles, slab, weathered_timber
from synthdepth.maps.gardens.items import garden_item
from synthdepth.maps.gardens.parts import DARK, WHITE, draw_colour
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    copies,
    join,
    merge,
    place,
    tube,
    yaw_matrix,
)

__all__ = ["breakwater", "groyne", "jetty", "pier"]

_BARRIER, _FURNITURE, _DECK = "barrier", "street_furniture", "pavement"


def pier(rng: np.random.Generator, line, *, deck_m: float, bed_m: BedHeight) -> Model:
    """A pier on piles, of timber or with a concrete deck, with railings, lamps, benches, ladders.

    Args:
        rng: the lane of the pier.
        line: (k, 2) its middle, from the shore to its head [m].
        deck_m: height of the deck [m].
        bed_m: height of the sea's bed [m] at points (n, 2) -> (n,).
    """
    walk = Walk(line)
    half = rng.uniform(1.8, 2.7)
    concrete = rng.random() < 0.3
    wood = weathered_timber(rng)
    length = walk.length
    head_long = min(rng.uniform(9, 14), 0.3 * length)
    head_half = half + rng.uniform(1.8, 3.2)
    s_head = length - head_long
    spacing = rng.uniform(3.6, 5.4)
    at = np.linspace(1.0, s_head - 1.0, max(int(s_head / spacing), 2))
    head_at = np.linspace(s_head + 0.4, length - 0.4, max(int(head_long / spacing), 2) + 1)
    models: list[Model] = []
    wooden: list[Geometry] = []
    cast: list[Geometry] = []
    radius = 0.24 if concrete else rng.uniform(0.15, 0.19)
    pile_tint = np.array([0.9, 0.9, 0.88]) if concrete else wood * 0.85
    for s, h, rows in ((at, half, 2 if half < 2.3 else 3), (head_at, head_half, 4)):
        if concrete:
            under, caps = bents(rng, walk, s, h, deck_m, bed_m, pile_tint, radius, rows)
            cast += [under[0], caps]
        else:
            under, caps = bents(rng, walk, s, h, deck_m, bed_m, pile_tint, radius, rows)
            wooden += [*under, caps]
    spans = ((0.0, s_head, half), (s_head, length, head_half))
    decks = []
    for s0, s1, h in spans:
        steps = np.linspace(s0, s1, max(int((s1 - s0) / 3.0), 1) + 1)
        if concrete:
            decks.append(slab(walk, steps, h, deck_m))
        else:
            for w in np.linspace(-h + 0.2, h - 0.2, 5):
                wooden.append(
                    beams(
                        walk.at(steps[:-1], w, deck_m - 0.17),
                        walk.at(steps[1:], w, deck_m - 0.17),
                        0.12,
                        0.25,
                        wood * 0.7,
                    )
                )
            decks.append(planks(rng, walk, s0, s1, h, deck_m, wood))
            for side in (-1, 1):
                wooden.append(
                    beams(
                        walk.at(steps[:-1], side * (h - 0.02), deck_m + 0.07),
                        walk.at(steps[1:], side * (h - 0.02), deck_m + 0.07),
                        0.14,
                        0.13,
                        wood * 0.9,
                    )
                )
    models.append({("concrete" if concrete else "wood", _DECK): join(decks)})
    style = str(
        rng.choice(["timber", "wire", "iron"], p=[0.2, 0.2, 0.6] if concrete else [0.5, 0.25, 0.25])
    )
    rail_tint = (
        draw_colour(rng, [WHITE, (0.03, 0.08, 0.07), (0.04, 0.07, 0.12), (0.2, 0.21, 0.21)])
        if style == "iron"
        else wood * 1.1
    )
    stair = float(rng.uniform(s_head + 2, length - 2))
    for side in (1, -1):
        models.append(
            rail(rng, walk, 0.5, s_head - 0.1, side * (half - 0.08), deck_m, style, rail_tint)
        )
        gaps = ((stair - 0.6, stair + 0.6),) if side == 1 else ()
        models.append(
            rail(
                rng,
                walk,
                s_head + 0.1,
                length - 0.1,
                side * (head_half - 0.08),
                deck_m,
                style,
                rail_tint,
                gaps,
            )
        )
    models.append(cross_rail(walk, s_head + 0.1, half, head_half, deck_m, style, rail_tint))
    models.append(cross_rail(walk, length - 0.1, 0.0, head_half, deck_m, style, rail_tint))
    steel = [ladder(walk, stair, head_half, deck_m, -0.8)]
    paint = [
        bollards(walk, np.array([s_head + 1.0, length - 1.0]), head_half - 0.45, deck_m),
        bollards(walk, np.array([s_head + 1.0, length - 1.0]), -head_half + 0.45, deck_m),
    ]
    models.append({("paint", _FURNITURE): join(steel + paint)})
    lamp_s = np.arange(6.0, length - 1.0, rng.uniform(14, 22))
    lamp_w = np.where(lamp_s > s_head, head_half - 0.28, half - 0.28) * np.where(
        np.arange(len(lamp_s)) % 2, 1, -1
    )
    models += lamps(
        rng,
        walk,
        lamp_s,
        lamp_w,
        deck_m,
        draw_colour(rng, [(0.03, 0.05, 0.045), (0.2, 0.21, 0.21), (0.04, 0.04, 0.045)]),
    )
    bench = garden_item(rng, "bench")
    bench_s = np.arange(11.0, s_head - 3, rng.uniform(9, 16))
    for i, s in enumerate(bench_s):
        side = 1 if i % 2 else -1
        models.append(
            place(
                bench,
                walk.at(s, side * (half - 0.62), deck_m),
                float(walk.heading(s)) - side * np.pi / 2,
            )
        )
    if head_long > 7.5 and rng.random() < 0.75:
        size = (min(0.5 * head_long, 6.0), min(1.1 * head_half, 5.0))
        kiosk = pavilion(
            rng,
            size,
            draw_colour(
                rng, [(0.5, 0.5, 0.47), (0.34, 0.42, 0.44), (0.44, 0.38, 0.26), (0.3, 0.12, 0.1)]
            ),
        )
        mid = s_head + 0.55 * head_long
        models.append(place(kiosk, walk.at(mid, 0.0, deck_m - 0.01), float(walk.heading(mid))))
    models.append({("wood", _BARRIER): join(wooden)} if wooden else {})
    models.append({("concrete", _BARRIER): join(cast)} if cast else {})
    return merge(models)


def jetty(rng: np.random.Generator, line, *, deck_m: float, bed_m: BedHeight) -> Model:
    """A narrow timber landing stage: mooring posts above the deck, ropes, tyres, a ladder.

    Args:
        rng: the lane of the jetty.
        line: (k, 2) its middle, from the shore outwards [m].
        deck_m: height of the deck [m].
        bed_m: height of the sea's bed [m] at points (n, 2) -> (n,).
    """
    walk = Walk(line)
    half = rng.uniform(0.75, 1.2)
    wood = weathered_timber(rng)
    s = np.linspace(0.6, walk.length - 0.3, max(int(walk.length / rng.uniform(2.4, 3.4)), 2))
    tones = np.clip(rng.normal(1, 0.12, (2 * len(s), 1)), 0.6, 1.4) * wood * 0.85
    at_s, at_w = np.repeat(s, 2), np.tile([-half - 0.02, half + 0.02], len(s))
    foot = walk.at(at_s, at_w, 0.0)
    foot[:, 2] = np.minimum(np.asarray(bed_m(foot[:, :2])) - 0.5, deck_m - 0.8)
    tall = (np.arange(len(at_s)) // 2) % 2 == 0
    head = walk.at(at_s, at_w, deck_m + np.where(tall, rng.uniform(0.5, 1.1, len(at_s)), -0.02))
    steps = np.linspace(0, walk.length, max(int(walk.length / 3), 1) + 1)
    wooden = [
        piles(foot, head, 0.11, tones),
        beams(
            walk.at(s, -half - 0.2, deck_m - 0.22),
            walk.at(s, half + 0.2, deck_m - 0.22),
            0.12,
            0.2,
            wood * 0.8,
        ),
    ]
    for w in (-half + 0.12, 0.0, half - 0.12):
        wooden.append(
            beams(
                walk.at(steps[:-1], w, deck_m - 0.12),
                walk.at(steps[1:], w, deck_m - 0.12),
                0.09,
                0.16,
                wood * 0.7,
            )
        )
    clear = (deck_m - np.maximum(np.asarray(bed_m(walk.at(s, 0 * s, 0)[:, :2])), -0.3)) > 0.9
    if clear.any():
        sb = s[clear]
        wooden.append(
            beams(
                walk.at(sb + 0.14, -half, -0.2),
                walk.at(sb + 0.14, half, deck_m - 0.3),
                0.05,
                0.14,
                wood * 0.75,
            )
        )
    high = walk.at(at_s, at_w, head[:, 2])[tall]
    ropes = []
    if rng.random() < 0.5:  # a rope from post to post on one side
        row = high[1::2] - [0, 0, 0.12]
        ropes += [sagging(a, b, rng.uniform(0.08, 0.25), 0.014) for a, b in itertools.pairwise(row)]
    turn = np.linspace(0, 2 * np.pi, 13)
    ring = tube(
        np.column_stack([0.24 * np.cos(turn), 0 * turn, 0.24 * np.sin(turn)]),
        0.085,
        6,
        capped=False,
    )
    out = np.flatnonzero(~tall)
    tyre_at = walk.at(at_s[out], at_w[out] + np.sign(at_w[out]) * 0.22, deck_m - 0.3)
    tyres = copies(ring, tyre_at, rotation=yaw_matrix(walk.heading(at_s[out])))
    deck = planks(rng, walk, 0.0, walk.length, half, deck_m, wood)
    steel = [ladder(walk, walk.length - 1.0, half, deck_m, -0.7)]
    if rng.random() < 0.5:
        wooden.append(beams(high[::2] - [0, 0, 0.1], high[::2] + [0, 0, 0.05], 0.24, 0.05, wood))
    models: list[Model] = [
        {("wood", _DECK): deck, ("wood", _BARRIER): join(wooden), ("rubber", _BARRIER): tyres},
        {("paint", _FURNITURE): join(steel)},
    ]
    if ropes:
        models.append({("fabric", _BARRIER): join(ropes)})
    if rng.random() < 0.6:
        models += lamps(
            rng,
            walk,
            np.array([walk.length - 0.4]),
            np.array([-half - 0.1]),
            deck_m,
            np.array(DARK),
        )
    return merge(models)
