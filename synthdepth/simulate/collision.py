"""Whether and when a sphere on its way touches a world's triangles: exact, between samples too.

Broad phase: a binary tree of boxes over the triangles in Morton order (C. Lauterbach et al., "Fast
BVH Construction on GPUs", Eurographics 2009, section 3), complete and without pointers, walked a
level at a time for all queries together. Narrow phase: closed forms, see `triangles`.
"""

import numpy as np

from synthdepth.maps.world import LABELS, World
from synthdepth.simulate.triangles import first_touch, segment_distance

_LEAF = 4  # triangles of a leaf
_BITS = 16  # of a Morton code along each axis
_NAMES = {number: name for name, number in LABELS.items()}
_CHUNK = 1 << 14  # queries times triangles that are compared at a time


class Mesh:
    """Triangles that can be hit, in a tree of boxes.

    Args:
        triangles: (m, 3, 3) corners [m]; kept as float32.
        labels: (m,) values of `LABELS`.

    Attributes:
        triangles: (m, 3, 3) float32 [m], in the tree's order.
        labels: (m,) uint8, likewise.
    """

    def __init__(self, triangles: np.ndarray, labels: np.ndarray):
        triangles = np.asarray(triangles, np.float32).reshape(-1, 3, 3)
        a, b, c = (triangles[:, i] for i in range(3))
        order = np.argsort(_morton(a + b + c), kind="stable")
        self.triangles = triangles[order]
        self.labels = np.asarray(labels, np.uint8)[order]
        a, b, c = (self.triangles[:, i] for i in range(3))
        leaves = max(-(-len(order) // _LEAF), 1)
        depth = (leaves - 1).bit_length()
        lower, upper = np.empty((2, _LEAF << depth, 3), np.float32)
        lower[:], upper[:] = np.inf, -np.inf  # no triangle: touches nothing
        lower[: len(order)] = np.minimum(np.minimum(a, b), c)
        upper[: len(order)] = np.maximum(np.maximum(a, b), c)
        self._levels: list[tuple[np.ndarray, np.ndarray]] = []
        while len(lower) > 1:
            lower = np.minimum(lower[0::2], lower[1::2])
            upper = np.maximum(upper[0::2], upper[1::2])
            if len(lower) <= 1 << depth:
                self._levels.insert(0, (lower, upper))

    @classmethod
    def of_world(cls, world: World, around_m: float = 100.0) -> "Mesh":
        """The triangles within a world's flight bounds widened by `around_m`."""
        low, high = world.flight_bounds + [[-around_m], [around_m]]
        triangles, labels = [np.zeros((0, 3, 3), np.float32)], [np.zeros(0, np.uint8)]
        for (_, label), part in world.surfaces.items():
            corners = part.triangles
            xy = corners[..., :2]
            near = (xy.max(axis=1) >= low).all(axis=1) & (xy.min(axis=1) <= high).all(axis=1)
            triangles.append(corners[near])
            labels.append(np.full(len(triangles[-1]), LABELS[label], np.uint8))
        return cls(np.concatenate(triangles), np.concatenate(labels))

    def label_name(self, triangle: int) -> str:
        """The label of a triangle."""
        return _NAMES[int(self.labels[triangle])]

    def first_contact(
        self, start_m: np.ndarray, end_m: np.ndarray, radius_m: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """When spheres that move along segments first touch something.

        Args:
            start_m, end_m: (n, 3) centres [m].
            radius_m: 0 or more.

        Returns:
            (n,) float64 share of the way, 0 where it touches from the start, inf where it never
            does; and (n,) int64 the triangle touched first, -1 where there is none.
        """
        start, end = (np.asarray(x, np.float64).reshape(-1, 3) for x in (start_m, end_m))
        share, touched = np.full(len(start), np.inf), np.full(len(start), -1)
        for query, triangle in self._near(start, end, np.full(len(start), float(radius_m))):
            found = first_touch(
                start[query], end[query], radius_m, self.triangles[triangle].astype(np.float64)
            )
            _keep_least(share, touched, query, triangle, found)
        return share, touched

    def distance(
        self, start_m: np.ndarray, end_m: np.ndarray, within_m: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """How near segments come to any triangle.

        Args:
            start_m, end_m: (n, 3) [m]; a point is a segment from itself to itself.
            within_m: (n,) or scalar [m]: how far to look; much dearer than `first_contact` if wide.

        Returns:
            (n,) float64 distance [m], inf where it is more than `within_m`; and (n,) int64 the
            nearest triangle, -1 where there is none.
        """
        start, end = (np.asarray(x, np.float64).reshape(-1, 3) for x in (start_m, end_m))
        within = np.broadcast_to(np.asarray(within_m, np.float64), len(start))
        nearest, which = np.full(len(start), np.inf), np.full(len(start), -1)
        for query, triangle in self._near(start, end, within):
            found = segment_distance(
                start[query], end[query], self.triangles[triangle].astype(np.float64)
            )
            found[found > within[query]] = np.inf
            _keep_least(nearest, which, query, triangle, found)
        return nearest, which

    def _near(self, start: np.ndarray, end: np.ndarray, radius_m: np.ndarray):
        """Queries and triangles (k,) each whose boxes lie within the radius, in chunks."""
        # The tree is float32: outward, so that rounding loses nothing.
        lower = np.nextafter((np.minimum(start, end)).astype(np.float32), np.float32(-np.inf))
        upper = np.nextafter((np.maximum(start, end)).astype(np.float32), np.float32(np.inf))
        reach = np.nextafter((radius_m**2 * (1 + 1e-6)).astype(np.float32), np.float32(np.inf))
        query, node = np.arange(len(start)), np.zeros(len(start), np.int64)
        for level, boxes in enumerate(self._levels):
            if level:
                query = np.repeat(query, 2)
                node = (2 * node[:, None] + [0, 1]).ravel()
            gap = np.maximum(boxes[0][node] - upper[query], lower[query] - boxes[1][node])
            near = np.square(np.maximum(gap, 0)).sum(axis=1) <= reach[query]
            query, node = query[near], node[near]
        query = np.repeat(query, _LEAF)
        triangle = (_LEAF * node[:, None] + np.arange(_LEAF)).ravel()
        there = triangle < len(self.triangles)
        query, triangle = query[there], triangle[there]
        for i in range(0, len(query), _CHUNK):
            yield query[i : i + _CHUNK], triangle[i : i + _CHUNK]


def _keep_least(values, which, query, triangle, found) -> None:
    """Lower `values` and set `which` where a found value is less; of equal ones the first stays."""
    order = np.lexsort((triangle, found, query))
    query, triangle, found = query[order], triangle[order], found[order]
    first = np.flatnonzero(np.diff(query, prepend=-1))
    query, triangle, found = query[first], triangle[first], found[first]
    less = found < values[query]
    values[query[less]], which[query[less]] = found[less], triangle[less]


def _morton(points: np.ndarray) -> np.ndarray:
    """Morton codes (m,) int64 of points (m, 3) on a grid over all of them."""
    if not len(points):
        return np.zeros(0, np.int64)
    low, high = points.min(axis=0), points.max(axis=0)
    scale = (2**_BITS - 1) / np.maximum(high - low, np.float32(1e-6))
    code = np.zeros(len(points), np.int64)
    for axis in range(3):
        # Spreads the bits of a number three apart.
        bits = ((points[:, axis] - low[axis]) * scale[axis]).astype(np.int64)
        bits = (bits | bits << 16) & 0x0000FF0000FF
        bits = (bits | bits << 8) & 0x00F00F00F00F
        bits = (bits | bits << 4) & 0x0C30C30C30C3
        bits = (bits | bits << 2) & 0x249249249249
        code |= bits << axis
    return code
