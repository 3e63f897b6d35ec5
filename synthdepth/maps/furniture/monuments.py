"""What stands in the middle of a square: fountains and statues."""

import dataclasses

import numpy as np

from synthdepth.maps.furniture.parts import (
    LABEL,
    Surfaces,
    boxes,
    disc,
    item,
    lathe,
    ringed,
    turned,
)
from synthdepth.maps.furniture.posters import decals
from synthdepth.maps.geometry import box, copies, join, merge, tube
from synthdepth.maps.people.body import person
from synthdepth.maps.people.crowd import draw_person

_BRONZES = ((0.085, 0.065, 0.035), (0.10, 0.15, 0.125), (0.05, 0.042, 0.03))


def fountain(rng: np.random.Generator) -> Surfaces:
    """A basin of 4.5-7 m with one or two bowls on a stem, water, and jets of spray."""
    radius, rim = rng.uniform(2.2, 3.4), rng.uniform(0.45, 0.6)
    wall = lathe(
        [
            (radius + 0.22, -0.08),
            (radius + 0.22, 0.12),
            (radius + 0.08, 0.16),
            (radius + 0.06, rim - 0.1),
            (radius + 0.18, rim - 0.06),
            (radius + 0.18, rim),
            (radius - 0.16, rim + 0.005),
            (radius - 0.16, 0.1),
        ],
        28,
    )
    step = lathe([(radius + 0.75, -0.08), (radius + 0.75, 0.09)], 28)
    pool = disc(radius - 0.1, (0, 0, rim - 0.14), (1, 1, 1), 28)
    high = rng.uniform(1.3, 1.7)
    bowl = 0.42 * radius
    stem = lathe(
        [
            (0.55, 0.0),
            (0.5, rim),
            (0.28, rim + 0.1),
            (0.20, 0.5 * (rim + high)),
            (0.26, high - 0.15),
            (0.3, high - 0.05),
        ],
        14,
    )
    dish = lathe(
        [
            (0.25, high - 0.12),
            (0.7 * bowl, high),
            (bowl, high + 0.2),
            (bowl, high + 0.26),
            (bowl - 0.09, high + 0.265),
            (0.7 * bowl, high + 0.1),
            (0.1, high + 0.09),
        ],
        20,
    )
    top = high + 0.95
    upper = lathe(
        [
            (0.2, high + 0.05),
            (0.14, high + 0.4),
            (0.12, top - 0.15),
            (0.45, top),
            (0.55, top + 0.12),
            (0.48, top + 0.125),
            (0.3, top + 0.06),
            (0.08, top + 0.05),
            (0.09, top + 0.2),
            (0.02, top + 0.34),
        ],
        14,
    )
    water = [pool, disc(bowl - 0.05, (0, 0, high + 0.2), (1, 1, 1), 20)]
    spray = []
    # Falling threads of water from both bowls, and a plume.
    for r, z0, z1, n in ((bowl, high + 0.22, rim - 0.14, 40), (0.55, top + 0.1, high + 0.2, 22)):
        t = np.linspace(0, 1, 5)
        for _ in range(n):
            spread = rng.uniform(0.12, 0.3)
            fall = np.column_stack([r + spread * t, 0 * t, z0 - (z0 - z1) * t**2])
            thread = tube(fall, rng.uniform(0.4, 1.2) * np.array([9, 8, 10, 13, 20]) * 1e-3, 3)
            spray.append(turned(thread, rng.uniform(0, 2 * np.pi)))
    plume = rng.uniform(0.8, 1.6)
    t = np.linspace(0, 1, 9)
    arc = np.column_stack(
        [0.05 + 0.42 * t, 0 * t, top + 0.3 + plume * 4 * t * (1 - t) * 0.6 - 0.15 * t]
    )
    spray.append(ringed(tube(arc, np.linspace(0.006, 0.018, 9), 4), 10))
    foam = join(spray).tinted((0.66, 0.68, 0.70))
    return item(concrete=[wall, step, stem, dish, upper], glass=water, paint=[foam])


def statue(rng: np.random.Generator) -> Surfaces:
    """A bronze figure, 1.4-1.8 times life size, on a stepped plinth."""
    high, scale = rng.uniform(1.9, 3.0), rng.uniform(1.35, 1.75)
    steps = [((2.6, 0.16), -0.06), ((2.1, 0.16), 0.10), ((1.4, 0.2), 0.26)]
    blocks = [box((w, w, h), (0, 0, z)) for (w, h), z in steps]
    shaft = box((1.15, 1.15, high - 0.62), (0, 0, 0.46))
    crown = boxes(
        [[1.34, 1.34, 0.10], [1.2, 1.2, 0.07]], [[0, 0, high - 0.17], [0, 0, high - 0.07]]
    )
    plate = box((0.02, 0.55, 0.36), (0.58, 0, 0.42 * high + 0.2), (0.07, 0.055, 0.03))
    rows = np.arange(5)
    inset = 0.04 * (rows % 2)
    lines = np.column_stack([inset - 0.2, -0.05 * rows, 0.2 - inset, 0.02 - 0.05 * rows])
    text = decals(lines, (0.2, 0.16, 0.09), 1).moved([0.59, 0, 0.42 * high + 0.48])
    bronze = np.array(_BRONZES[rng.integers(len(_BRONZES))])
    pose = ("talking", "standing", "walking")[rng.integers(3)]
    model = dataclasses.replace(
        draw_person(rng, pose), bag="none", hair="short", top="coat", bottom="trousers", phone=False
    )
    figure = join(list(person(model).values()))
    figure = copies(figure, [[0, 0, high - 0.005]], scale=scale)
    # Bronze weathers green from above and stays brown where it is sheltered.
    lit = np.clip((figure.vertices[:, 2:] - high) / (1.8 * scale), 0, 1)
    figure = figure.tinted(bronze * (0.8 + 0.5 * lit))
    return merge(
        [
            item(concrete=[*blocks, shaft, crown], paint=[plate, text]),
            {("paint", LABEL): turned(figure)},
        ]
    )
