"""Cargo ships, for the horizon."""

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.coast.boat_parts import (
    Parts,
    add,
    finished,
)
from synthdepth.maps.coast.hulls import Hull, deck, skin
from synthdepth.maps.coast.small_craft import BOTTOMS
from synthdepth.maps.gardens.parts import draw_colour
from synthdepth.maps.geometry import Model, box, copies, tube

_WHITE = np.array([0.62, 0.62, 0.59])


def cargo_ship(rng: np.random.Generator) -> Model:
    """A container or bulk ship of 110 to 200 m, for the horizon: few triangles."""
    length = rng.uniform(110.0, 200.0)
    k = length / 150
    hull = Hull(
        length_m=length,
        beam_m=0.155 * length,
        sheer_m=(11 * k, 10 * k, 14 * k),
        keel_m=(5 * k, 8 * k, 7 * k),
        transom=0.8,
        section="flat",
        stem_rake_m=7 * k,
        bow_power=4.5,
        widest=0.5,
        stern_rake_m=3 * k,
    )
    colour = draw_colour(
        rng,
        [
            (0.02, 0.05, 0.14),
            (0.03, 0.03, 0.035),
            (0.22, 0.04, 0.03),
            (0.05, 0.16, 0.12),
            (0.2, 0.21, 0.22),
        ],
    )
    parts: Parts = {}
    add(
        parts,
        "paint",
        skin(hull, [(1.5 * k, draw_colour(rng, BOTTOMS[:1])), ("sheer", colour)], 14),
        deck(hull, (0.16, 0.07, 0.05), camber_m=0.2),
    )
    z = 10.3 * k
    x = -0.38 * length
    levels = 6
    for i in range(levels):
        w = (0.13 - 0.012 * i) * length
        add(parts, "paint", box((10 * k, w, 2.9 * k), (x, 0, z + 2.9 * k * i), _WHITE))
        add(parts, "glass", box((10.05 * k, w * 0.9, 0.9 * k), (x, 0, z + 2.9 * k * i + 1.4 * k)))
    top = z + 2.9 * k * levels
    add(
        parts,
        "paint",
        box((4 * k, 0.15 * length, 0.6 * k), (x + 3 * k, 0, top - 3.2 * k), _WHITE),
        box((5 * k, 4 * k, 7 * k), (x - 6 * k, 0, top - 6 * k), colour),
        tube([[x, 0, top], [x, 0, top + 9 * k]], 0.35 * k, 5, _WHITE),
        tube([[0.45 * length, 0, 13 * k], [0.45 * length, 0, 24 * k]], 0.35 * k, 5, _WHITE),
    )
    if rng.random() < 0.6:  # containers in bays
        size = np.array([12.2, 2.44, 2.6])
        bays = np.arange(-0.3 * length, 0.38 * length, 13.4)
        rows = int(0.13 * length / 2.5)
        b, r, t = np.meshgrid(bays, np.arange(rows) - (rows - 1) / 2, np.arange(6), indexing="ij")
        high = rng.integers(1, 6, (len(bays), rows))
        keep = (t < high[..., None]).ravel()
        at = np.column_stack([b.ravel(), r.ravel() * 2.5, z + 1 + t.ravel() * 2.6])[keep]
        at = at[
            np.abs(at[:, 1])
            < 0.92 * np.interp(at[:, 0], [0.25 * length, 0.5 * length], [0.0775 * length, 0])
        ]
        tones = np.array(
            [
                (0.25, 0.05, 0.03),
                (0.04, 0.09, 0.2),
                (0.3, 0.3, 0.29),
                (0.06, 0.15, 0.1),
                (0.35, 0.16, 0.03),
                (0.12, 0.05, 0.04),
            ]
        )
        add(
            parts,
            "paint",
            copies(
                box(size),
                at,
                tint=tones[rng.integers(6, size=len(at))] * rng.uniform(0.7, 1.1, (len(at), 1)),
            ),
        )
    else:  # hatches and deck cranes
        for u in np.linspace(-0.25, 0.33, 5):
            add(
                parts,
                "paint",
                box((0.085 * length, 0.1 * length, 2.2 * k), (u * length, 0, z), (0.2, 0.12, 0.08)),
            )
            foot = np.array([(u - 0.055) * length, 0, z])
            add(
                parts,
                "paint",
                tube([foot, foot + [0, 0, 12 * k]], [1.3 * k, 1.1 * k], 8, (0.5, 0.35, 0.06)),
                beams(
                    [foot + [0, 0, 11 * k]],
                    [foot + [16 * k, 3 * k, 15 * k]],
                    1.0 * k,
                    1.0 * k,
                    (0.5, 0.35, 0.06),
                ),
            )
    return finished(parts)


SHIPS = {"cargo_ship": cargo_ship}
