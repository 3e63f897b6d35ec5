"""Groynes and breakwaters: what holds the sand and keeps off the sea."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.armour import draw_stone, rock_armour, tetrapod_armour
from synthdepth.maps.coast.lofts import STEEL, lathe, sheet
from synthdepth.maps.coast.staging import BedHeight, Walk, piles, slab, weathered_timber
from synthdepth.maps.gardens.parts import draw_colour
from synthdepth.maps.geometry import Model, join, merge, tube

_BARRIER, _DECK = "barrier", "pavement"


def groyne(rng: np.random.Generator, line, bed_m: BedHeight) -> Model:
    """A sea groyne: rows of posts, close together or with planks between, lower towards the sea.

    Args:
        rng: the lane of the groynes.
        line: (k, 2) from the beach into the sea [m].
        bed_m: height of the sand and the sea's bed [m] at points (n, 2) -> (n,).
    """
    walk = Walk(line)
    wood = weathered_timber(rng) * 0.85
    close = rng.random() < 0.5
    pitch = rng.uniform(0.3, 0.36) if close else rng.uniform(1.6, 2.4)
    k = max(int(walk.length / pitch), 2)
    s = np.linspace(0, walk.length, k)
    offsets = (0.0, 0.5) if close and rng.random() < 0.4 else (0.0,)
    parts, top0 = [], rng.uniform(0.7, 1.3)
    for w in offsets:
        at = walk.at(s, w + rng.normal(0, 0.02, k), 0.0)
        bed = np.asarray(bed_m(at[:, :2]), np.float64)
        smooth = np.interp(
            s, np.linspace(0, walk.length, 6), bed[np.linspace(0, k - 1, 6).astype(int)]
        )
        top = np.maximum(
            smooth + top0 * np.linspace(1, 0.9, k), rng.uniform(0.35, 0.6)
        ) + rng.normal(0, 0.06 if close else 0.12, k)
        foot = np.column_stack([at[:, :2], np.minimum(bed - 0.5, top - 0.6)])
        head = np.column_stack([at[:, :2] + rng.normal(0, 0.02, (k, 2)), top])
        tones = np.clip(rng.normal(1, 0.15, (k, 1)), 0.55, 1.5) * wood
        radius = rng.uniform(0.11, 0.16, k) if close else rng.uniform(0.14, 0.18, k)
        parts.append(piles(foot, head, radius, tones))
    if not close:
        for level in np.arange(-0.3, top0 - 0.1, 0.24):
            z = np.stack([smooth[:-1] + level, smooth[1:] + level], 1)
            keep = (z < np.stack([top[:-1], top[1:]], 1) - 0.15).all(axis=1) & (
                rng.random(k - 1) < 0.94
            )
            i = np.flatnonzero(keep)
            tones = (
                np.clip(rng.normal(1, 0.12, (len(i), 1)), 0.6, 1.4)
                * wood
                * np.where(z[i, :1] < 0.8, 0.5, 1.0)
            )
            if len(i):
                parts.append(
                    beams(
                        walk.at(s[i], 0.17, z[i, 0] + 0.1),
                        walk.at(s[i + 1], 0.17, z[i, 1] + 0.1),
                        0.07,
                        0.22,
                        tones,
                    )
                )
    models: list[Model] = [{("wood", _BARRIER): join(parts)}]
    if rng.random() < 0.6:  # a beacon on the last post
        foot = head[-1]
        rod = tube([foot - [0, 0, 0.5], foot + [0, 0, 2.6]], 0.06, 6, (0.25, 0.25, 0.25))
        basket = lathe(
            [0.05, 0.28, 0.28, 0.05],
            [0, 0.03, 0.5, 0.53],
            8,
            draw_colour(rng, [(0.35, 0.03, 0.02), (0.03, 0.15, 0.06)]),
        )
        models.append({("paint", "pole"): join([rod, basket.moved(foot + [0, 0, 2.5])])})
    return merge(models)


def breakwater(rng: np.random.Generator, line, bed_m: BedHeight) -> Model:
    """A rubble mound of rocks or tetrapods, at times with a walkway on top and a light at its end.

    Args:
        rng: the lane of the breakwater.
        line: (k, 2) its crest, from the shore outwards [m].
        bed_m: height of the sea's bed [m] at points (n, 2) -> (n,).
    """
    walk = Walk(line)
    crest, half = rng.uniform(1.9, 2.8), rng.uniform(1.6, 2.4)
    slope = rng.uniform(1.4, 1.8)
    steps = np.linspace(-1.0, walk.length + 1.0, max(int(walk.length / 4), 2) + 1)
    deep = np.minimum(
        np.asarray(bed_m(walk.at(np.clip(steps, 0, walk.length), 0 * steps, 0)[:, :2])) - 0.4, 0.6
    )
    run = (crest - deep) * slope
    stone = draw_stone(rng)
    # The core: a bank that shows dark between the stones.
    w = np.stack([-half - run, 0 * run - half, 0 * run + half, half + run], 1)
    z = np.stack([deep, 0 * deep + crest - 0.9, 0 * deep + crest - 0.9, deep], 1)
    core = walk.at(np.clip(steps, 0, walk.length)[:, None], w, z)
    tip = walk.at(walk.length, np.zeros(3), 0.0)[0]
    yaw = float(walk.heading(walk.length))
    turn = np.linspace(-np.pi / 2, np.pi / 2, 9)
    out = np.stack(
        [
            np.cos(turn) * np.cos(yaw) - np.sin(turn) * np.sin(yaw),
            np.cos(turn) * np.sin(yaw) + np.sin(turn) * np.cos(yaw),
            0 * turn,
        ],
        -1,
    )
    head = np.stack(
        [
            tip + out * (half + run[-1]) + [0, 0, deep[-1]],
            tip + out * half + [0, 0, crest - 0.9],
            tip + out * 0 + [0, 0, crest - 0.9],
        ]
    )
    mound = join([sheet(core[:, ::-1]), sheet(head)]).tinted(0.55 * stone)
    armour = tetrapod_armour if rng.random() < 0.25 else rock_armour
    size = rng.uniform(1.1, 1.5)
    # Stones on a shaken grid over the crest, the slopes and round the head.
    reach = half + float(run.max())
    pitch = 0.72 * size
    s, w = np.meshgrid(
        np.arange(-0.5, walk.length + reach, pitch),
        np.arange(-reach, reach, 0.85 * pitch),
        indexing="ij",
    )
    s = s.ravel() + rng.uniform(-0.4, 0.4, s.size) * pitch
    w = w.ravel() + rng.uniform(-0.4, 0.4, w.size) * pitch
    beyond = np.maximum(s - walk.length, 0.0)
    radial = np.hypot(w, beyond)
    keep = radial < half + np.interp(s, steps, run)
    s, w, beyond, radial = s[keep], w[keep], beyond[keep], radial[keep]
    z = crest - np.maximum(radial - half, 0) / slope - 0.42 * size + rng.normal(0, 0.13, len(s))
    # What lies deep under water is never seen.
    seen = z > -0.9 * size
    s, w, z, beyond, radial = s[seen], w[seen], z[seen], beyond[seen], radial[seen]
    at = walk.at(np.minimum(s, walk.length), w, z)
    at[:, 0] += beyond * np.cos(yaw)
    at[:, 1] += beyond * np.sin(yaw)
    paved = rng.random() < 0.45
    if paved:
        clear = (radial > half + 0.2) | (beyond > half)
        at = at[clear]
    models: list[Model] = [{("rock", "obstacle"): mound}, armour(rng, at, size, stone)]
    if paved:
        steps = np.linspace(0, walk.length + 0.5 * half, max(int(walk.length / 4), 1) + 1)
        models.append(
            {("concrete", _DECK): slab(walk, np.minimum(steps, walk.length), half, crest + 0.25)}
        )
    foot = np.array([tip[0], tip[1], crest - 0.2])
    if rng.random() < 0.7:
        tint = draw_colour(rng, [(0.36, 0.03, 0.02), (0.03, 0.16, 0.07), (0.6, 0.6, 0.57)])
        tower = lathe(
            [0.75, 0.75, 0.34, 0.28, 0.42, 0.42], [-0.8, 0.6, 0.65, 4.2, 4.25, 4.35], 10, tint
        )
        lantern = lathe([0.16, 0.18, 0.05], [4.35, 4.75, 4.95], 8, (0.4, 0.42, 0.4))
        turn = 2 * np.pi * np.arange(9) / 8
        ringp = np.column_stack([0.4 * np.cos(turn), 0.4 * np.sin(turn), np.full(9, 4.35)])
        rails = [tube(ringp + [0, 0, h], 0.012, 4, STEEL, capped=False) for h in (0.5, 0.95)]
        posts = round_bars(ringp[:-1], ringp[:-1] + [0, 0, 0.95], 0.012, STEEL, 4)
        ladder = [
            round_bars([[0.42, y, -0.3]], [[0.42, y, 4.4]], 0.02, STEEL, 5) for y in (-0.2, 0.2)
        ]
        z = np.arange(0.1, 4.3, 0.3)
        rungs = round_bars(
            np.column_stack([0 * z + 0.42, 0 * z - 0.2, z]),
            np.column_stack([0 * z + 0.42, 0 * z + 0.2, z]),
            0.014,
            STEEL,
            4,
        )
        models.append(
            {("paint", "pole"): join([tower, lantern, *rails, posts, *ladder, rungs]).moved(foot)}
        )
    return merge(models)
