"""The ground of a suburb as meshes: carriageway, kerb, pavement, verges, lawns and driveways.

The plan's areas are triangulated, and the triangles sliced along a grid, so that they follow the
terrain. All areas share their edges: there are no gaps and no overlaps.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from synthdepth.maps.geometry import Geometry, Model, geometry, join, quads
from synthdepth.maps.streets.plan import KERB_WIDTH_M, StreetPlan
from synthdepth.maps.terrain import Terrain
from synthdepth.maps.tessellation import (
    draped,
    rings,
    segments,
    sliced,
    sliced_segments,
    triangulated,
)

KERB_HEIGHT_M = 0.12
DROPPED_KERB_M = 0.03
FLARE_M = 0.5  # beside a driveway the kerb comes down over this length
BEDDING_M = 0.6  # depth of the closed sheet below, which stops rays at hairline cracks


def _carved(pieces: np.ndarray, area: shapely.Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Each piece without `area`, and what `area` takes of the pieces."""
    parts = shapely.get_parts(area)
    i, j = shapely.STRtree(parts).query(pieces, predicate="intersects")
    taken = shapely.intersection(pieces[i], parts[j])
    left = pieces.copy()
    turn = np.arange(len(i)) - np.searchsorted(i, i)  # one part after the other from each piece
    for k in range(int(turn.max(initial=-1)) + 1):
        at = turn == k
        left[i[at]] = shapely.difference(left[i[at]], parts[j[at]])
    return left, taken


class _DroppedKerbs:
    """How far kerb, verge and driveway dip where a driveway meets the carriageway."""

    def __init__(self, plan: StreetPlan, drives: shapely.Geometry):
        self.verge_m = plan.verge_m
        self.drives = shapely.STRtree(shapely.get_parts(drives))
        self.kerbs = shapely.STRtree(shapely.linestrings(segments(rings(plan.carriageway))))

    def dip_m(self, xy: np.ndarray, on_kerb: bool) -> np.ndarray:
        """(n,) [m] at points (n, 2): full at the kerb, none at the pavement and past the flares."""
        dip = np.zeros(len(xy))
        points = shapely.points(xy)
        (i, _), d = self.drives.query_nearest(
            points, max_distance=1.01 * FLARE_M, return_distance=True, all_matches=False
        )
        dip[i] = np.clip(1 - d / FLARE_M, 0, 1)
        if not on_kerb:
            (i, _), d = self.kerbs.query_nearest(points, return_distance=True, all_matches=False)
            dip[i] *= 1 - np.clip((d - KERB_WIDTH_M) / self.verge_m, 0, 1)
        return dip * (KERB_HEIGHT_M - DROPPED_KERB_M)


def _kerb_faces(plan: StreetPlan, terrain: Terrain, dips: _DroppedKerbs, grown) -> Geometry:
    """The kerb's upright face, from the carriageway up to the kerb's top."""
    ends = segments(rings(plan.carriageway))
    outer = (np.abs(ends) > plan.half_size_m - 1e-6).all(axis=1).any(axis=1)
    edge = shapely.multilinestrings(shapely.linestrings(ends[~outer]))
    faces = []
    for lines in (shapely.difference(edge, grown), shapely.intersection(edge, grown)):
        a, b = sliced_segments(segments(shapely.get_parts(lines))).transpose(1, 0, 2)
        dip = [np.zeros(len(a))] * 2 if not faces else [dips.dip_m(p, True) for p in (a, b)]
        ground = [terrain.height_m(p) for p in (a, b)]
        # The carriageway lies to the left from a to b, so the face is seen from there.
        corner = [
            np.column_stack([xy, z])
            for xy, z in (
                (b, ground[1] - KERB_HEIGHT_M),
                (a, ground[0] - KERB_HEIGHT_M),
                (a, ground[0] - dip[0]),
                (b, ground[1] - dip[1]),
            )
        ]
        faces.append(quads(np.stack(corner, 1), (0.92, 0.92, 0.9)))
    return join(faces)


def _bedding(terrain: Terrain, half_m: float) -> Geometry:
    n = 40
    axis = np.linspace(-half_m, half_m, n + 1)
    xy = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([i, i + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + n + 1], 1)]
    )
    return geometry(np.column_stack([xy, terrain.height_m(xy) - BEDDING_M]), faces)


def street_surface(
    plan: StreetPlan, terrain: Terrain, driveways: Sequence[np.ndarray] = ()
) -> Model:
    """The finished ground inside the map's square.

    Lawns and pavements lie at `terrain.height_m`, the carriageway `KERB_HEIGHT_M` below.

    Args:
        plan: streets and lots.
        terrain: heights.
        driveways: polygons (k, 2) [m], which may overlap each other and reach onto the
            carriageway: they pave what they cover of lots and verge, and drop the kerb.
    """
    h = plan.half_size_m
    polygons = shapely.make_valid([shapely.Polygon(d) for d in driveways])
    drives = shapely.union_all(polygons)
    grown = shapely.buffer(drives, FLARE_M, join_style="mitre", mitre_limit=2.0)
    flares = shapely.difference(grown, drives)
    dips = _DroppedKerbs(plan, drives)

    lots = np.array([shapely.Polygon(lot.polygon) for lot in plan.lots], dtype=object)
    taken_land = shapely.union_all([plan.street_land, *lots])
    rest = shapely.difference(shapely.box(-h, -h, h, h), taken_land)
    lawns, paved = _carved(lots, drives)
    kerb, verge = plan.kerb, plan.verge
    layers = {
        "carriageway": [plan.carriageway],
        "kerb": [shapely.difference(kerb, grown)],
        "dropped kerb": [shapely.intersection(kerb, drives), shapely.intersection(kerb, flares)],
        "verge": [shapely.difference(verge, grown)],
        "flare": [shapely.intersection(verge, flares)],
        "apron": [shapely.intersection(verge, drives)],
        "pavement": [plan.pavement],
        "driveway": [shapely.intersection(rest, drives), *paved],
        "lawn": [shapely.difference(rest, drives), *lawns],
    }
    corners, shape = triangulated(np.array([s for part in layers.values() for s in part]))
    corners, shape = sliced(corners, shape)
    first = np.cumsum([0] + [len(part) for part in layers.values()])
    layer = np.searchsorted(first, shape, side="right") - 1
    of = {name: corners[layer == i] for i, name in enumerate(layers)}
    lot_tint = np.array([(1.0, 1.0, 1.0)] + [lot.lawn_tint for lot in plan.lots])
    lawn_tint = lot_tint[shape[layer == len(layers) - 1] - first[-2]]

    flat = terrain.height_m
    verge_tint = (1.04, 1.0, 0.97)
    concrete = [
        draped(of["kerb"], flat, (0.97, 0.97, 0.95)),
        draped(of["dropped kerb"], lambda p: flat(p) - dips.dip_m(p, True), (0.97, 0.97, 0.95)),
        draped(of["apron"], lambda p: flat(p) - dips.dip_m(p, False)),
        draped(of["driveway"], flat, uneven=0.1),
        _kerb_faces(plan, terrain, dips, grown),
    ]
    grass = [
        draped(of["verge"], flat, verge_tint),
        draped(of["flare"], lambda p: flat(p) - dips.dip_m(p, False), verge_tint),
        draped(of["lawn"], flat, lawn_tint),
    ]
    return {
        ("asphalt", "road"): draped(
            of["carriageway"], lambda p: flat(p) - KERB_HEIGHT_M, uneven=0.12
        ),
        ("concrete", "pavement"): join(concrete),
        ("paving", "pavement"): draped(of["pavement"], flat),
        ("grass", "ground"): join(grass),
        ("soil", "ground"): _bedding(terrain, h),
    }
