"""The ground of the streets: carriageways, kerbs and pavements.

Carriageways lie at z = 0, everything else at `KERB_HEIGHT_M`. Ground is cut into cells, so that no
triangle is large.
"""

import numpy as np
import shapely

from synthdepth.maps.downtown.grid import Grid, strip
from synthdepth.maps.geometry import Geometry, Model, geometry, join, merge, quads

KERB_HEIGHT_M, KERB_WIDTH_M = 0.12, 0.16
CELL_M = 24.0
DISC_M = 560.0  # streets and blocks end here
BEDDING_M = 0.5  # depth of a closed sheet below, which stops rays at hairline cracks


def disc(radius_m: float = DISC_M) -> shapely.Geometry:
    """A circle around the middle."""
    return shapely.Point(0, 0).buffer(radius_m, quad_segs=24)


def _cut(pieces: np.ndarray, axis: int, cell_m: float) -> np.ndarray:
    """Pieces cut at the multiples of `cell_m` across an axis."""
    bounds = shapely.bounds(pieces)
    first = np.floor(bounds[:, axis] / cell_m).astype(int)
    count = np.floor(bounds[:, axis + 2] / cell_m).astype(int) - first + 1
    owner = np.repeat(np.arange(len(pieces)), count)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + first[owner]
    box = np.full((len(owner), 4), [-1e5, -1e5, 1e5, 1e5])
    box[:, axis], box[:, axis + 2] = number * cell_m, (number + 1) * cell_m
    several = count[owner] > 1
    cut = pieces[owner]
    cut[several] = shapely.intersection(cut[several], shapely.box(*box[several].T))
    return shapely.get_parts(cut)


def triangles(area, cell_m: float = CELL_M) -> np.ndarray:
    """Counter-clockwise triangles (t, 3, 2) of one or more areas, none larger than a cell."""
    pieces = shapely.get_parts(np.atleast_1d(np.asarray(area, dtype=object)))
    for axis in (0, 1):
        pieces = pieces[(shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-4)]
        pieces = _cut(pieces, axis, cell_m)
    pieces = pieces[(shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-4)]
    if not len(pieces):
        return np.zeros((0, 3, 2))
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(pieces))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3].astype(np.float32)
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2
    corners = np.where((area < 0)[:, None, None], corners[:, ::-1], corners)
    return corners[np.abs(area) > 1e-5].astype(np.float64)


def _patina(xy: np.ndarray, strength: float) -> np.ndarray:
    """A smooth unevenness (n,) about 1, in patches of 15 to 100 m."""
    x, y = xy.T
    wave = np.sin(x / 17 + 2 * np.sin(y / 31)) + np.sin(y / 13 + 2 * np.sin(x / 41))
    return 1 + strength * 0.5 * wave


def flat(corners: np.ndarray, z_m: float, angle_rad=0.0, tint=(1, 1, 1), uneven=0.06) -> Geometry:
    """Triangles (t, 3, 2) at a height, the texture turned by `angle_rad`; tint (3,) or (t, 3)."""
    xy = corners.reshape(-1, 2)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    uv = np.stack([xy @ [c, s], xy @ [-s, c]], 1)
    tint = np.broadcast_to(np.asarray(tint, float), (len(corners), 3))
    colour = np.repeat(tint, 3, axis=0) * _patina(xy, uneven)[:, None]
    z = np.full((len(xy), 1), z_m)
    return geometry(np.concatenate([xy, z], 1), np.arange(len(xy)), uv, colour)


def laid(area, z_m: float, angle_rad=0.0, tint=(1, 1, 1), uneven=0.06) -> Geometry:
    """An area at a height; see `flat`."""
    return flat(triangles(area), z_m, angle_rad, tint, uneven)


def islands_of(grid: Grid) -> np.ndarray:
    """What the carriageways leave: (k,) polygons [m]."""
    parts = shapely.get_parts(shapely.difference(disc(), grid.carriageway))
    return parts[shapely.area(parts) > 4.0]


def island_angle(island: shapely.Geometry) -> float:
    """Direction of the longer side of an island's bounding rectangle [rad]."""
    ring = shapely.get_coordinates(shapely.minimum_rotated_rectangle(island))
    side = np.diff(ring[:3], axis=0)
    u = side[np.argmax(np.linalg.norm(side, axis=1))]
    return float(np.arctan2(u[1], u[0]))


def _carriageways(rng: np.random.Generator, grid: Grid) -> Model:
    """Asphalt, street by street: u runs along the street, and each is of another age."""
    tone = np.clip(rng.normal(1.0, 0.17, len(grid.lines)), 0.65, 1.4)
    tone = tone[grid.line] * rng.uniform(0.92, 1.08, len(grid.line))
    length, along = grid.length_m, grid.along
    strips, parts = [], []
    inside = np.linalg.norm((grid.start + grid.end) / 2, axis=1) < DISC_M - 60
    for edge in np.flatnonzero(inside & (length - grid.setback_m.sum(axis=1) > 8)):
        s0, s1 = grid.setback_m[edge, 0], length[edge] - grid.setback_m[edge, 1]
        width = grid.profile(edge).carriageway_m
        ends = grid.at(edge, np.array([s0, s1]), np.zeros(2))
        strips.append(shapely.Polygon(strip(ends[0], ends[1], width)))
        stations = np.linspace(s0, s1, int(np.ceil((s1 - s0) / 16)) + 1)
        low, high = (grid.at(edge, stations, np.full(len(stations), w)) for w in
                     (-width / 2, width / 2))  # fmt: skip
        cells = np.stack([low[:-1], low[1:], high[1:], high[:-1]], 1)
        corners = cells[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 2)
        angle = np.arctan2(along[edge, 1], along[edge, 0])
        parts.append(flat(corners, 0.0, angle, (tone[edge],) * 3, 0.08))
    rest = shapely.difference(grid.carriageway, shapely.union_all(strips))
    rest = shapely.intersection(rest, disc())
    parts.append(laid(rest, 0.0, grid.angle_rad, (0.95,) * 3, 0.12))
    return {("asphalt", "road"): join(parts)}


def _kerbs(islands: np.ndarray, inner: np.ndarray) -> Model:
    """Kerb stones: their tops and the upright faces towards the carriageway."""
    rings = shapely.get_rings(shapely.orient_polygons(islands))
    xy, index = shapely.get_coordinates(rings, return_index=True)
    ends = np.stack([xy[:-1], xy[1:]], 1)[index[1:] == index[:-1]]
    ends = ends[(np.hypot(*ends.mean(axis=1).T) < DISC_M - 3)]
    ends = ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 2e-3]
    pieces = []
    for a, b in ends:  # long ones in pieces
        n = max(1, int(np.linalg.norm(b - a) / CELL_M))
        t = np.linspace(0, 1, n + 1)[:, None]
        line = a + t * (b - a)
        pieces.append(np.stack([line[:-1], line[1:]], 1))
    ends = np.concatenate(pieces)
    z = np.array([-0.03, -0.03, KERB_HEIGHT_M, KERB_HEIGHT_M])
    corner = ends[:, [0, 1, 1, 0]]
    faces = np.concatenate([corner, np.broadcast_to(z[None, :, None], (len(ends), 4, 1))], 2)
    ring = shapely.difference(islands, inner)
    return {
        ("concrete", "pavement"): join(
            [quads(faces, (0.82, 0.82, 0.8)), laid(ring, KERB_HEIGHT_M, tint=(0.95, 0.95, 0.93))]
        )
    }


_PAVINGS = (
    ("paving", (1.0, 1.0, 1.0)),
    ("paving", (0.72, 0.72, 0.73)),
    ("concrete", (0.95, 0.94, 0.92)),
    ("concrete", (0.75, 0.74, 0.72)),
    ("brick", (0.24, 0.23, 0.22)),
    ("brick", (0.25, 0.16, 0.12)),
)


def _pavements(rng: np.random.Generator, grid: Grid, islands, inner) -> list[Model]:
    """Pavements of slabs, concrete or clinker; at some kerbs a strip of setts."""
    models = []
    scene = rng.permutation(len(_PAVINGS))[:3]
    near = shapely.distance(islands, shapely.Point(0, 0)) < 420
    for island, within, fine in zip(islands, inner, near, strict=True):
        material, tint = _PAVINGS[scene[int(rng.choice(3, p=[0.6, 0.28, 0.12]))]]
        tint = np.array(tint) * rng.uniform(0.85, 1.1)
        setts, angle = rng.random() < 0.45, island_angle(island)
        street = shapely.intersection(within, grid.street_land)
        if setts and fine:
            edge = shapely.difference(street, island.buffer(-1.25, join_style="mitre"))
            street = shapely.difference(street, edge)
            strip_ = laid(edge, KERB_HEIGHT_M, angle, (0.2, 0.195, 0.19))
            models.append({("brick", "pavement"): strip_})
        models.append({(material, "pavement"): laid(street, KERB_HEIGHT_M, angle, tint, 0.08)})
    return models


def street_surface(rng: np.random.Generator, grid: Grid) -> Model:
    """Carriageways at z = 0, kerbs and pavements at `KERB_HEIGHT_M`, within `DISC_M`."""
    islands = islands_of(grid)
    inner = shapely.buffer(islands, -KERB_WIDTH_M, join_style="mitre")
    models = [
        _carriageways(rng, grid),
        _kerbs(islands, inner),
        *_pavements(rng, grid, islands, inner),
    ]
    h = DISC_M + 5
    low, high = -h, h
    corners = [[low, low], [high, low], [high, high], [low, high]]
    bed = quads([[[*corner, -BEDDING_M] for corner in corners]], (0.8,) * 3)
    return merge([*models, {("asphalt", "ground"): bed}])
