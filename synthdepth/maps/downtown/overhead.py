"""What hangs over a city's streets: span wires, contact lines, string lights, footbridges."""

import numpy as np

from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.downtown.ground import KERB_HEIGHT_M
from synthdepth.maps.downtown.paint import crossing_m
from synthdepth.maps.furniture.poles import catenary, wires
from synthdepth.maps.furniture.structures import footbridge
from synthdepth.maps.geometry import Model, copies, place, tube

_REACH_M = 330.0
_BULB_EVERY_M = 0.9
_TRAM_HEIGHT_M = 5.6


def overhead(
    rng: np.random.Generator, grid: Grid, *, cable_share: float, bridges: int
) -> list[Model]:
    """Cables and bridges.

    Args:
        rng: the lane of what hangs.
        grid: the streets.
        cable_share: share of the streets that have cables across; one avenue in three of those has
            a tram's contact line.
        bridges: footbridges over the avenues nearest to the middle.
    """
    middle = np.linalg.norm((grid.start + grid.end) / 2, axis=1)
    near = np.flatnonzero((middle < _REACH_M) & (grid.length_m > 40))
    tram = rng.random(len(grid.lines)) < 0.34
    spans, bulbs = [np.zeros((0, 2, 3))], [np.zeros((0, 2, 3))]
    contact = [np.zeros((0, 2, 3))]
    for edge in near:
        profile = grid.profile(edge)
        if rng.random() > cable_share:
            continue
        first, last = crossing_m(grid)[edge]
        run = grid.length_m[edge] - first - last
        reach = profile.width_m / 2 + 0.4
        if profile.kind == "avenue" and tram[grid.line[edge]]:
            s = np.arange(first, first + run, 24.0)
            spans.append(_across(rng, grid, edge, s, reach, (7.0, 7.6)))
            for offset, _ in profile.lanes[:2]:
                ends = grid.at(np.full(2, edge), np.array([first - 6, first + run + 6]), offset)
                contact.append(np.column_stack([ends, [_TRAM_HEIGHT_M] * 2])[None])
        else:
            s = np.sort(rng.uniform(first, first + run, max(1, int(run / 30))))
            lit = rng.random() < 0.3
            (bulbs if lit else spans).append(
                _across(rng, grid, edge, s, reach, (5.5, 8.5) if lit else (6.5, 16.0))
            )
    models: list[Model] = []
    spans, bulbs, contact = (np.concatenate(rows) for rows in (spans, bulbs, contact))
    if len(spans):
        sag = rng.uniform(0.008, 0.03, len(spans))
        lines = catenary(spans[:, 0], spans[:, 1], sag, 10)
        models.append({("metal", "wire"): wires(lines, 0.011, (0.16, 0.16, 0.17))})
    if len(contact):
        lines = catenary(contact[:, 0], contact[:, 1], 0.0015, 16)
        models.append({("metal", "wire"): wires(lines, 0.009, (0.35, 0.22, 0.13))})
    if len(bulbs):
        models.append(_string_lights(rng, bulbs))
    return models + _footbridges(rng, grid, near, bridges)


def _across(rng, grid: Grid, edge: int, s: np.ndarray, reach: float, height) -> np.ndarray:
    """Ends (k, 2, 3) of cables from house to house."""
    k = len(s)
    ends = [grid.at(np.full(k, edge), s + rng.normal(0, 1.2, k), side * reach) for side in (1, -1)]
    z = rng.uniform(*height, k)
    return np.stack([np.column_stack([xy, z + rng.normal(0, 0.3, k)]) for xy in ends], axis=1)


def _string_lights(rng: np.random.Generator, ends: np.ndarray) -> Model:
    lines = catenary(ends[:, 0], ends[:, 1], rng.uniform(0.02, 0.05, len(ends)), 14)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    share = np.linspace(0.03, 0.97, int(np.median(length) / _BULB_EVERY_M))
    at = share * 14
    low = np.minimum(at.astype(int), 13)
    part = (at - low)[None, :, None]
    where = lines[:, low] * (1 - part) + lines[:, low + 1] * part
    bulb = tube([[0, 0, -0.02], [0, 0, -0.06], [0, 0, -0.13]], [0.018, 0.045, 0.012], 6)
    colour = (0.75, 0.55, 0.3)
    return {
        ("metal", "wire"): wires(lines, 0.008, (0.06, 0.06, 0.06)),
        ("signal", "wire"): copies(bulb, where.reshape(-1, 3)).tinted(colour),
    }


def _footbridges(rng, grid: Grid, near: np.ndarray, count: int) -> list[Model]:
    """Bridges across the avenues nearest to the middle, between their junctions."""
    wide = [e for e in near if grid.profile(e).kind == "avenue" and grid.length_m[e] > 60]
    nearest = sorted(wide, key=lambda e: np.linalg.norm((grid.start[e] + grid.end[e]) / 2))
    models = []
    for edge in nearest[:count]:
        profile = grid.profile(edge)
        model = footbridge(
            rng, span_m=profile.carriageway_m + 1.6, clearance_m=float(rng.uniform(4.6, 5.4))
        )
        u = grid.along[edge]
        at = grid.at(edge, np.array(0.5 * grid.length_m[edge]), np.array(0.0))
        models.append(place(model, [*at, KERB_HEIGHT_M - 0.02], np.arctan2(u[1], u[0]) + np.pi / 2))
    return models
