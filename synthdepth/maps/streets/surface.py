"""The ground of a suburb as meshes: carriageway, kerb, pavement, verges, lawns and driveways.

The plan's areas are triangulated, and the triangles sliced along a grid, so that they follow the
terrain. All areas share their edges: there are no gaps and no overlaps.
"""

from collections.abc import Callable, Sequence

import numpy as np
import shapely

from synthdepth.maps.geometry import Geometry, Model, geometry, join, quads
from synthdepth.maps.streets.plan import KERB_WIDTH_M, StreetPlan
from synthdepth.maps.terrain import Terrain

CELL_M = 15.625
SHEET_CELLS = 4  # areas are triangulated in squares of so many cells: large polygons take long
KERB_HEIGHT_M = 0.12
DROPPED_KERB_M = 0.03
FLARE_M = 0.5  # beside a driveway the kerb comes down over this length
BEDDING_M = 0.6  # depth of the closed sheet below, which stops rays at hairline cracks


def _sheets(pieces: np.ndarray, owner: np.ndarray, axis: int, first: int, last: int):
    """Pieces cut across an axis at the multiples `first` < i < `last` of a sheet, by halving."""
    if last - first <= 1 or not len(pieces):
        return [pieces], [owner]
    middle = (first + last) // 2
    at = middle * SHEET_CELLS * CELL_M
    bounds = shapely.bounds(pieces)
    low, high = bounds[:, axis] < at, bounds[:, axis + 2] > at
    both = low & high
    lower, upper = [-1e4, -1e4, 1e4, 1e4], [-1e4, -1e4, 1e4, 1e4]
    lower[axis + 2] = upper[axis] = at
    cut_pieces, cut_owner = [], []
    for box, only, span in (
        (lower, low & ~high, (first, middle)),
        (upper, high & ~low, (middle, last)),
    ):
        cut = shapely.intersection(pieces[both], shapely.box(*box))
        cut, index = shapely.get_parts(cut, return_index=True)
        part, own = _sheets(
            np.concatenate([pieces[only], cut]),
            np.concatenate([owner[only], owner[both][index]]),
            axis,
            *span,
        )
        cut_pieces += part
        cut_owner += own
    return cut_pieces, cut_owner


def _triangles(shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (t, 3, 2) of the polygons' triangles, counter-clockwise, and each one's polygon."""
    pieces, shape = shapely.get_parts(np.asarray(shapes, dtype=object), return_index=True)
    large = np.ptp(shapely.bounds(pieces).reshape(-1, 2, 2), axis=1).max(axis=1) > 100
    cut, own = pieces[large], shape[large]
    n = int(np.ceil(np.abs(shapely.bounds(cut)).max() / (SHEET_CELLS * CELL_M)))
    for axis in (0, 1):
        cut, own = map(np.concatenate, _sheets(cut, own, axis, -n, n))
    pieces = np.concatenate([pieces[~large], cut])
    shape = np.concatenate([shape[~large], own])
    flat = np.flatnonzero((shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-5))
    parts, index = shapely.get_parts(
        shapely.constrained_delaunay_triangles(pieces[flat]), return_index=True
    )
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    corners = np.where((_area_m2(corners) < 0)[:, None, None], corners[:, ::-1], corners)
    return corners, shape[flat[index]]


def _area_m2(corners: np.ndarray) -> np.ndarray:
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2


def _middle_line(c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which shapes with coordinates c (n, corners) straddle a grid line, and their middle one."""
    first = np.floor(c.min(axis=1) / CELL_M + 1e-7) + 1
    last = np.ceil(c.max(axis=1) / CELL_M - 1e-7) - 1
    return last >= first, (first + last) // 2 * CELL_M


def _meet(p: np.ndarray, q: np.ndarray, axis: int, line: np.ndarray) -> np.ndarray:
    """Where segments p-q (n, 2) cross coordinate `line`: the same from either end."""
    swap = ((p[:, 0] > q[:, 0]) | ((p[:, 0] == q[:, 0]) & (p[:, 1] > q[:, 1])))[:, None]
    a, b = np.where(swap, q, p), np.where(swap, p, q)
    span = b[:, axis] - a[:, axis]
    t = np.where(span == 0, 0.0, (line - a[:, axis]) / np.where(span == 0, 1.0, span))
    point = a + np.clip(t, 0, 1)[:, None] * (b - a)
    point[:, axis] = line
    return point


def _sliced(corners: np.ndarray, tag: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (t, 3, 2) cut along the grid lines, each at its middle line until none is left."""
    done_corners, done_tag = [], []
    for axis in (0, 1):
        while len(corners):
            straddles, line = _middle_line(corners[:, :, axis])
            done_corners.append(corners[~straddles])
            done_tag.append(tag[~straddles])
            c, g, line = corners[straddles], tag[straddles], line[straddles]
            offset = c[:, :, axis] - line[:, None]
            above, below = offset > 1e-7, offset < -1e-7
            # The corner that is alone on its side comes first.
            alone = np.where(above.sum(1) == 1, above.argmax(1), below.argmax(1))
            c = np.take_along_axis(c, ((alone[:, None] + [0, 1, 2]) % 3)[:, :, None], axis=1)
            v0, v1, v2 = c[:, 0], c[:, 1], c[:, 2]
            p1, p2 = _meet(v0, v1, axis, line), _meet(v0, v2, axis, line)
            # The shorter diagonal of the part that two corners share.
            short = (np.linalg.norm(p1 - v2, axis=1) < np.linalg.norm(p2 - v1, axis=1))[:, None]
            corners = np.concatenate(
                [
                    np.stack([v0, p1, p2], 1),
                    np.stack([v1, v2, np.where(short, p1, p2)], 1),
                    np.stack([p1, np.where(short, v2, v1), p2], 1),
                ]
            )
            tag = np.concatenate([g, g, g])
            solid = _area_m2(corners) > 1e-6
            corners, tag = corners[solid], tag[solid]
        corners, tag = np.concatenate(done_corners), np.concatenate(done_tag)
        done_corners, done_tag = [], []
    return corners, tag


def _sliced_segments(ends: np.ndarray) -> np.ndarray:
    """Segments (n, 2, 2) cut along the grid lines."""
    for axis in (0, 1):
        done = []
        while len(ends):
            straddles, line = _middle_line(ends[:, :, axis])
            done.append(ends[~straddles])
            p, q, line = ends[straddles, 0], ends[straddles, 1], line[straddles]
            m = _meet(p, q, axis, line)
            ends = np.concatenate([np.stack([p, m], 1), np.stack([m, q], 1)])
        ends = np.concatenate(done)
    return ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 1e-3]


def _segments(lines) -> np.ndarray:
    """Segments (n, 2, 2) of rings and lines."""
    xy, index = shapely.get_coordinates(lines, return_index=True)
    return np.stack([xy[:-1], xy[1:]], 1)[index[1:] == index[:-1]]


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


def _patina(xy: np.ndarray, strength: float) -> np.ndarray:
    """A smooth unevenness (n,) about 1, in patches of 40 to 200 m."""
    x, y = xy.T
    wave = np.sin(x / 31 + 2 * np.sin(y / 57)) + np.sin(y / 23 + 2 * np.sin(x / 71))
    return 1 + strength * 0.5 * wave


def _rings(area: shapely.Geometry) -> np.ndarray:
    return shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area)))


class _DroppedKerbs:
    """How far kerb, verge and driveway dip where a driveway meets the carriageway."""

    def __init__(self, plan: StreetPlan, drives: shapely.Geometry):
        self.verge_m = plan.verge_m
        self.drives = shapely.STRtree(shapely.get_parts(drives))
        self.kerbs = shapely.STRtree(shapely.linestrings(_segments(_rings(plan.carriageway))))

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


def _draped(
    corners: np.ndarray,
    height_m: Callable[[np.ndarray], np.ndarray],
    tint=(1.0, 1.0, 1.0),
    uneven: float = 0.06,
) -> Geometry:
    """Triangles (t, 3, 2) at `height_m`; tint (3,) or one for each triangle (t, 3)."""
    # What rounding to float32 would flatten is left out.
    solid = _area_m2(corners.astype(np.float32).astype(np.float64)) > 1e-7
    tint = np.broadcast_to(np.asarray(tint, np.float64), (len(corners), 3))[solid]
    corners = corners[solid]
    xy = corners.reshape(-1, 2)
    tint = np.repeat(tint, 3, axis=0)
    # Equal corners of equal tint are shared; the offset tells tints apart.
    key = (xy[:, 0] + 4096 * np.round(1000 * tint[:, 0])) + 1j * xy[:, 1]
    _, first, back = np.unique(key, return_index=True, return_inverse=True)
    xy = xy[first]
    colour = tint[first] * _patina(xy, uneven)[:, None]
    return geometry(np.column_stack([xy, height_m(xy)]), back.reshape(-1, 3), tint=colour)


def _kerb_faces(plan: StreetPlan, terrain: Terrain, dips: _DroppedKerbs, grown) -> Geometry:
    """The kerb's upright face, from the carriageway up to the kerb's top."""
    ends = _segments(_rings(plan.carriageway))
    outer = (np.abs(ends) > plan.half_size_m - 1e-6).all(axis=1).any(axis=1)
    edge = shapely.multilinestrings(shapely.linestrings(ends[~outer]))
    faces = []
    for lines in (shapely.difference(edge, grown), shapely.intersection(edge, grown)):
        a, b = _sliced_segments(_segments(shapely.get_parts(lines))).transpose(1, 0, 2)
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
    corners, shape = _triangles(np.array([s for part in layers.values() for s in part]))
    corners, shape = _sliced(corners, shape)
    first = np.cumsum([0] + [len(part) for part in layers.values()])
    layer = np.searchsorted(first, shape, side="right") - 1
    of = {name: corners[layer == i] for i, name in enumerate(layers)}
    lot_tint = np.array([(1.0, 1.0, 1.0)] + [lot.lawn_tint for lot in plan.lots])
    lawn_tint = lot_tint[shape[layer == len(layers) - 1] - first[-2]]

    flat = terrain.height_m
    verge_tint = (1.04, 1.0, 0.97)
    concrete = [
        _draped(of["kerb"], flat, (0.97, 0.97, 0.95)),
        _draped(of["dropped kerb"], lambda p: flat(p) - dips.dip_m(p, True), (0.97, 0.97, 0.95)),
        _draped(of["apron"], lambda p: flat(p) - dips.dip_m(p, False)),
        _draped(of["driveway"], flat, uneven=0.1),
        _kerb_faces(plan, terrain, dips, grown),
    ]
    grass = [
        _draped(of["verge"], flat, verge_tint),
        _draped(of["flare"], lambda p: flat(p) - dips.dip_m(p, False), verge_tint),
        _draped(of["lawn"], flat, lawn_tint),
    ]
    return {
        ("asphalt", "road"): _draped(
            of["carriageway"], lambda p: flat(p) - KERB_HEIGHT_M, uneven=0.12
        ),
        ("concrete", "pavement"): join(concrete),
        ("paving", "pavement"): _draped(of["pavement"], flat),
        ("grass", "ground"): join(grass),
        ("soil", "ground"): _bedding(terrain, h),
    }
