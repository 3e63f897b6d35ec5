"""The ground of a city's streets: carriageways, kerbs and pavements."""

import numpy as np
import shapely

from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.geometry import Geometry, Model, geometry, join, quads
from synthdepth.maps.tessellation import (
    draped,
    rings,
    segments,
    sliced,
    sliced_segments,
    triangulated,
)

KERB_HEIGHT_M, KERB_WIDTH_M = 0.12, 0.2
EDGE_M = 600.0  # streets end here; the land beyond is the skyline's
_BEDDING_M = 0.5  # depth of a closed sheet below, which stops rays at hairline cracks


def street_ground(grid: Grid) -> Model:
    """Carriageways at z = 0, kerbs and pavements `KERB_HEIGHT_M` above."""
    disc = shapely.Point(0, 0).buffer(EDGE_M, quad_segs=32)
    road = shapely.intersection(grid.carriageway, disc)
    land = shapely.intersection(grid.street_land, disc)
    stone = shapely.intersection(road.buffer(KERB_WIDTH_M, join_style="mitre"), land)
    layers = [road, shapely.difference(stone, road), shapely.difference(land, stone)]
    corners, layer = sliced(*triangulated(np.array(layers, dtype=object)))

    def level(z):
        return lambda xy: np.full(len(xy), z)

    return {
        ("asphalt", "road"): draped(corners[layer == 0], level(0.0), uneven=0.16),
        ("concrete", "pavement"): join(
            [
                draped(corners[layer == 1], level(KERB_HEIGHT_M), (0.95, 0.95, 0.93)),
                _kerb_faces(road),
            ]
        ),
        ("paving", "pavement"): draped(corners[layer == 2], level(KERB_HEIGHT_M), uneven=0.14),
        ("soil", "ground"): _bedding(),
    }


def _kerb_faces(road: shapely.Geometry) -> Geometry:
    a, b = sliced_segments(segments(rings(road))).transpose(1, 0, 2)
    inside = np.hypot(*((a + b) / 2).T) < EDGE_M - 1
    a, b = a[inside], b[inside]
    low, high = np.zeros(len(a)), np.full(len(a), KERB_HEIGHT_M)
    # The carriageway lies to the left from a to b, so the face is seen from there.
    corner = [np.column_stack([xy, z]) for xy, z in ((b, low), (a, low), (a, high), (b, high))]
    return quads(np.stack(corner, 1), (0.9, 0.9, 0.88))


def _bedding() -> Geometry:
    turn = 2 * np.pi * np.arange(96) / 96
    radius = np.linspace(0, EDGE_M, 25)[1:, None]
    rim = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=-1).reshape(-1, 2)
    xy = np.concatenate([[[0.0, 0.0]], rim])
    step, nxt = np.arange(96), (np.arange(96) + 1) % 96
    fan = np.stack([np.zeros(96, int), 1 + step, 1 + nxt], axis=1)
    inner = 1 + 96 * np.arange(23)[:, None]
    a, b, c, d = inner + step, inner + nxt, inner + 96 + step, inner + 96 + nxt
    bands = np.concatenate([np.stack([a, c, d], -1), np.stack([a, d, b], -1)]).reshape(-1, 3)
    vertices = np.column_stack([xy, np.full(len(xy), -_BEDDING_M)])
    return geometry(vertices, np.concatenate([fan, bands]))
