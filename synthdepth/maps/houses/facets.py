"""Planar facets collected by material and built at once: for things made of hundreds of boxes.

A house is some 300 boxes and 1000 quads; one `Geometry` for each would cost more than the rest.
"""

import functools

import numpy as np

from synthdepth.maps.geometry import Geometry, cross

# Corners of the six faces of a box, 0 = low and 1 = high, seen from outside counter-clockwise;
# sides first (their first edge is level), then top and bottom.
_BOX = np.array(
    [
        [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
        [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]],
        [[1, 1, 0], [0, 1, 0], [0, 1, 1], [1, 1, 1]],
        [[0, 1, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1]],
        [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        [[0, 1, 0], [1, 1, 0], [1, 0, 0], [0, 0, 0]],
    ],
    bool,
)
# Splash and soil: reflectance left on what is below ground, so that bases darken towards it.
_BURIED = 0.55

Key = tuple[str, str]


class Facets:
    """A growing set of planar quads and boxes, by (material, label).

    Corners are counter-clockwise seen from outside and the first edge is level, so that the
    texture's u follows it. Texture coordinates are the corner's own position along the facet's
    axes: they go on without a seam over all pieces of a cut wall. A triangle repeats its third
    corner; quads without area are dropped.
    """

    def __init__(self) -> None:
        self._ids: dict[Key, int] = {}
        self._quads: list[tuple] = []
        self._boxes: list[tuple] = []
        self._arrays: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def id_of(self, key: Key) -> int:
        """The number of a (material, label), for `add`."""
        return self._ids.setdefault(key, len(self._ids))

    def quad(self, key: Key, tint, a, b, c, d) -> None:
        """One quad from four corners (3,) [m]."""
        self._quads.append((self.id_of(key), *tint, *a, *b, *c, *d))

    def box(self, key: Key, tint, low, high, without: int = -1) -> None:
        """One axis-aligned box from its lowest and highest corner (3,) [m].

        `without` leaves out a side: 0 at low y, 1 at high x, 2 at high y, 3 at low x.
        """
        self._boxes.append((self.id_of(key), *tint, *low, *high, without))

    def add(self, key: Key | np.ndarray, tint, corners: np.ndarray) -> None:
        """`k` quads: corners (k, 4, 3) [m], `key` one for all or ids (k,), tint (3,) or (k, 3)."""
        k = len(corners)
        ids = key if isinstance(key, np.ndarray) else np.full(k, self.id_of(key))
        tints = np.empty((k, 3))
        tints[:] = tint
        self._arrays.append((ids, tints, corners))

    def _collected(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        ids, tints, corners = ([a[k] for a in self._arrays] for k in range(3))
        if self._quads:
            rows = np.array(self._quads, float)
            ids.append(rows[:, 0].astype(int))
            tints.append(rows[:, 1:4])
            corners.append(rows[:, 4:].reshape(-1, 4, 3))
        if self._boxes:
            rows = np.array(self._boxes, float)
            low, high = rows[:, None, None, 4:7], rows[:, None, None, 7:10]
            faces = np.where(_BOX, high, low)
            # Nobody sees the underside of what stands in the ground.
            seen = np.arange(6) != rows[:, 10:]
            seen[:, 5] = rows[:, 6] >= 0
            ids.append(np.repeat(rows[:, 0].astype(int), 6)[seen.ravel()])
            tints.append(np.repeat(rows[:, 1:4], 6, axis=0)[seen.ravel()])
            corners.append(faces[seen])
        return np.concatenate(ids), np.concatenate(tints), np.concatenate(corners)

    def model(self) -> dict[Key, Geometry]:
        """Everything collected, as a `Model`."""
        if not (self._arrays or self._quads or self._boxes):
            return {}
        ids, tints, p = self._collected()
        along = p[:, 1] - p[:, 0]
        normal = cross(along, p[:, 2] - p[:, 0])
        area = np.sqrt((normal * normal).sum(1))
        keep = area > 1e-7
        order = np.flatnonzero(keep)[np.argsort(ids[keep], kind="stable")]
        p, along, normal = p[order], along[order], normal[order]
        along /= np.sqrt((along * along).sum(1))[:, None]
        up = cross(normal, along) / area[order, None]
        uv = np.empty((len(p), 4, 2), np.float32)
        uv[..., 0] = np.einsum("kcx,kx->kc", p, along)
        uv[..., 1] = np.einsum("kcx,kx->kc", p, up)
        shade = np.where(p[..., 2] < -0.02, _BURIED, 1.0)
        tint = (tints[order][:, None] * shade[..., None]).astype(np.float32)
        second = cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 0])
        is_quad = (second * second).sum(1) > 1e-14
        p = p.astype(np.float32)
        stops = np.cumsum(np.bincount(ids[order], minlength=len(self._ids)))
        model, start = {}, 0
        for key, number in self._ids.items():
            stop = int(stops[number])
            if stop > start:
                part = slice(start, stop)
                first = np.arange(0, 4 * (stop - start), 4, dtype=np.int32)[:, None]
                half = first[is_quad[part]]
                faces = np.concatenate(
                    [first + np.array([0, 1, 2], np.int32), half + np.array([0, 2, 3], np.int32)]
                )
                model[key] = Geometry(
                    p[part].reshape(-1, 3),
                    faces,
                    uv[part].reshape(-1, 2),
                    tint[part].reshape(-1, 3),
                )
            start = stop
        return model


@functools.cache
def _unit_column(sides: int) -> np.ndarray:
    """(k, 4, 3): sides and lid of a column of radius and height 1."""
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    rim = np.stack([np.cos(turn), np.sin(turn)], 1)
    corners = np.empty((sides + sides // 2 - 1, 4, 3))
    corners[:sides, [0, 3], :2] = rim[:-1, None]
    corners[:sides, [1, 2], :2] = rim[1:, None]
    corners[:sides, :2, 2], corners[:sides, 2:, 2] = 0, 1
    fan = 2 * np.arange(sides // 2 - 1)[:, None] + [0, 1, 2, 3]
    fan[:, 0] = 0
    corners[sides:, :, :2], corners[sides:, :, 2] = rim[fan], 1
    return corners


def add_column(facets: Facets, key: Key, tint, x, y, radius, low, high, sides=8) -> None:
    """A round post or pipe with a lid; an even number of sides."""
    facets.add(key, tint, _unit_column(sides) * [radius, radius, high - low] + [x, y, low])
