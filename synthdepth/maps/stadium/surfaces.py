"""The ground of a sports site as meshes: patches cut along grids, with stripes, wear and drift."""

import dataclasses

import numpy as np
import shapely
from shapely import affinity

from synthdepth.maps.geometry import Geometry, Model, geometry, merge, yaw_matrix
from synthdepth.maps.stadium.piece import Patch

_SHEET_CELLS = 8
_LEAST_HEIGHT_M = 4e-4


def _cells(area: shapely.Geometry, cell_m: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Lower corners (k, 2) of the grid's cells over an area."""
    x0, y0, x1, y1 = area.bounds
    low = np.floor((np.array([x0, y0]) - origin) / cell_m).astype(int)
    high = np.ceil((np.array([x1, y1]) - origin) / cell_m).astype(int)
    i, j = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]), indexing="ij")
    return np.column_stack([i.ravel(), j.ravel()])


def _boxes(cells: np.ndarray, cell_m: np.ndarray, origin: np.ndarray) -> np.ndarray:
    low = origin + cells * cell_m
    return shapely.box(*low.T, *(low + cell_m).T)


def tessellate(
    area: shapely.Geometry, cell_m: tuple[float, float], origin_m=(0.0, 0.0)
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (t, 3, 2) of an area cut along a grid, and each one's column of the grid (t,)."""
    if area.is_empty:
        return np.zeros((0, 3, 2)), np.zeros(0, int)
    cell, origin = np.asarray(cell_m, float), np.asarray(origin_m, float)
    # First in sheets: cutting many small cells out of one large polygon takes long.
    sheet = _SHEET_CELLS * cell
    sheets = _cells(area, sheet, origin)
    parts = shapely.intersection(_boxes(sheets, sheet, origin), area)
    filled = shapely.area(parts) > 1e-6
    sheets, parts = sheets[filled], parts[filled]
    inner = np.stack(np.meshgrid(*[np.arange(_SHEET_CELLS)] * 2, indexing="ij"), -1).reshape(-1, 2)
    whole = shapely.area(parts) > (1 - 1e-9) * sheet.prod()
    full = (sheets[whole, None] * _SHEET_CELLS + inner).reshape(-1, 2)
    cells = (sheets[~whole, None] * _SHEET_CELLS + inner).reshape(-1, 2)
    owner = np.repeat(np.flatnonzero(~whole), len(inner))
    boxes = _boxes(cells, cell, origin)
    shapely.prepare(parts)
    inside = shapely.contains(parts[owner], boxes)
    full = np.concatenate([full, cells[inside]])
    cut = ~inside & shapely.intersects(parts[owner], boxes)
    pieces = shapely.intersection(boxes[cut], parts[owner[cut]])
    pieces, index = shapely.get_parts(pieces, return_index=True)
    solid = (shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-5)
    pieces, column = pieces[solid], cells[cut][index[solid], 0]
    triangles, index = shapely.get_parts(
        shapely.constrained_delaunay_triangles(pieces), return_index=True
    )
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    low = origin + full * cell
    square = low[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * cell
    corners = np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]], corners])
    columns = np.concatenate([full[:, 0], full[:, 0], column[index]])
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    corners = np.where((double < 0)[:, None, None], corners[:, ::-1], corners)
    keep = _solid(corners)
    return corners[keep], columns[keep]


def _solid(corners: np.ndarray) -> np.ndarray:
    """Which triangles (t, 3, 2) are higher than rounding to float32 could flatten, (t,) bool."""
    edges = np.roll(corners, -1, axis=1) - corners
    double = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    return double > _LEAST_HEIGHT_M * np.hypot(edges[..., 0], edges[..., 1]).max(axis=1)


class Drift:
    """Slow changes of colour over a site: dry and lush, clover and damp patches, 3 to 60 m wide."""

    def __init__(self, rng: np.random.Generator, strength: float):
        k = 14
        length = np.geomspace(4.0, 70.0, k) * rng.uniform(0.8, 1.25, k)
        turn = rng.uniform(0, 2 * np.pi, k)
        self.wave = (2 * np.pi / length)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
        self.phase = rng.uniform(0, 2 * np.pi, (3, k))
        self.amplitude = strength * length**0.25 / np.sqrt(np.sum(length**0.5))

    def __call__(self, xy: np.ndarray) -> np.ndarray:
        """Colour multipliers (n, 3) at points (n, 2) [m]."""
        # A bent plane keeps the waves from showing as straight bands.
        bent = xy + 3.0 * np.sin(xy[:, ::-1] / 11.0 + [0.3, 1.1])
        angle = bent @ self.wave.T
        light, dry, lush = (np.sin(angle + phase) @ self.amplitude for phase in self.phase)
        dry, lush = np.clip(dry, -0.15, 0.5), np.clip(lush, 0, 0.5)
        return np.clip(
            np.stack(
                [1 + light + 1.5 * dry - 0.5 * lush, 1 + light + 0.5 * dry, 1 + light - 0.2 * lush],
                axis=1,
            ),
            0.6,
            1.6,
        )


def _patch_geometry(patch: Patch, drift: Drift) -> Geometry:
    """A patch's mesh at z = 0, in the frame of the site."""
    origin = np.asarray(patch.origin_m, float)
    flat = affinity.translate(patch.area, -origin[0], -origin[1])
    flat = affinity.rotate(flat, -patch.turn_rad, origin=(0, 0), use_radians=True)
    corners, column = tessellate(flat, patch.cell_m)
    if not len(corners):
        return geometry(np.zeros((0, 3)), np.zeros((0, 3)))
    xy = corners.reshape(-1, 2) @ yaw_matrix(patch.turn_rad)[:2, :2].T + origin
    if patch.surface[0] in ("turf", "grass", "worn_turf"):
        tint = drift(xy)
    else:
        tint = 0.75 + 0.25 * drift(xy)
    for x, y, radius, strength in patch.worn:
        away = np.hypot(xy[:, 0] - x, xy[:, 1] - y) / radius
        wear = strength * np.exp(-(away**2))[:, None]
        tint = tint * (1 + wear * np.array([0.95, 0.35, 0.55]))
    if patch.stripes:
        light = (column // patch.stripes) % 2 * 2.0 - 1.0
        stripe = np.repeat(patch.stripe_contrast * light, 3)[:, None]
        tint = tint * (1 + stripe * np.array([1.0, 0.9, 0.8]))
    tint = tint * np.asarray(patch.tint)
    key = np.round(
        np.column_stack([xy * 1e3, np.repeat(column // max(patch.stripes, 1), 3)])
    ).astype(np.int64)
    if not patch.stripes:
        key[:, 2] = 0
    _, first, back = np.unique(
        key[:, 0] * 4_000_000_007 + key[:, 1] * 1_009 + key[:, 2],
        return_index=True,
        return_inverse=True,
    )
    vertices = np.column_stack([xy[first], np.zeros(len(first))])
    faces = back.reshape(-1, 3)
    return geometry(vertices, faces[_solid(xy[first][faces])], tint=tint[first])


def ground(patches: list[Patch], site: shapely.Geometry, lawn: Patch, drift: Drift) -> Model:
    """The site's ground at z = 0: the patches, higher ranks first, and lawn between them.

    Args:
        patches: in the site's frame.
        site: the land to cover.
        lawn: what covers the rest; its area is not used.
        drift: colours of grass.
    """
    left = site
    models = []
    order = sorted(range(len(patches)), key=lambda i: (-patches[i].rank, i))
    for i in order:
        patch = patches[i]
        area = shapely.intersection(patch.area, left)
        left = shapely.difference(left, patch.area)
        mesh = _patch_geometry(_with_area(patch, area), drift)
        models.append({patch.surface: mesh})
    models.append({lawn.surface: _patch_geometry(_with_area(lawn, left), drift)})
    return merge(models)


def _with_area(patch: Patch, area: shapely.Geometry) -> Patch:
    return dataclasses.replace(patch, area=area)
