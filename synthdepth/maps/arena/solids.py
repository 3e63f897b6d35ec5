"""Solids with textures in true metres: many boxes at once, wedges, solids of revolution."""

import numpy as np

from synthdepth.maps.geometry import Geometry, geometry, join, quads, yaw_matrix

SUNK_M = 0.05  # how deep a base stands in the ground

# Corners of a unit box's faces (6, 4, 3): sides, top, bottom.
_FACES = np.array(
    [
        [[-1, -1, 0], [1, -1, 0], [1, -1, 1], [-1, -1, 1]],
        [[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]],
        [[1, 1, 0], [-1, 1, 0], [-1, 1, 1], [1, 1, 1]],
        [[-1, 1, 0], [-1, -1, 0], [-1, -1, 1], [-1, 1, 1]],
        [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
        [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]],
    ]
) * [0.5, 0.5, 1.0]  # fmt: skip


def cuboids(base, size, yaw_rad=0.0, tint=(1.0, 1.0, 1.0), sunk_m: float = SUNK_M) -> Geometry:
    """Boxes, 12 triangles each, the texture running on at another place for each.

    Args:
        base: (k, 3) middles of their bases [m].
        size: (3,) or (k, 3) [m].
        yaw_rad: scalar or (k,).
        tint: (3,) or (k, 3).
        sunk_m: how far they reach below their bases.
    """
    base = np.asarray(base, np.float64).reshape(-1, 3)
    k = len(base)
    if not k:
        return join([])
    size = np.broadcast_to(np.asarray(size, np.float64), (k, 3)) + [0, 0, sunk_m]
    turn = yaw_matrix(np.broadcast_to(np.asarray(yaw_rad, np.float64), k))
    corners = np.einsum("kij,kfcj->kfci", turn, _FACES * size[:, None, None])
    corners = corners + (base - [0, 0, sunk_m])[:, None, None]
    # A fixed sequence of shifts, so that neighbours do not repeat one another.
    shift = np.outer(np.arange(6 * k) + 7.0 * np.abs(base[:, 0]).sum() % 50, [0.754878, 0.0])
    colour = np.broadcast_to(np.asarray(tint, np.float64), (k, 3))
    return quads(corners.reshape(-1, 4, 3), np.repeat(colour, 6, axis=0), shift * 3.1)


def wedge(length_m: float, width_m: float, height_m: float, tint) -> Geometry:
    """A ramp that rises along +x from x = 0, centred on y."""
    x, y, z, s = length_m, width_m / 2, height_m, -SUNK_M
    slope = quads([[[0, -y, s], [x, -y, z], [x, y, z], [0, y, s]]], tint)
    back = quads([[[x, -y, s], [x, y, s], [x, y, z], [x, -y, z]]], tint)
    under = quads([[[0, y, s], [x, y, s], [x, -y, s], [0, -y, s]]], tint)
    cheeks = geometry(
        [[0, -y, s], [x, -y, s], [x, -y, z], [0, y, s], [x, y, z], [x, y, s]],
        [[0, 1, 2], [3, 4, 5]],
        [[0, s], [x, s], [x, z], [0, s], [x, z], [x, s]],
        tint,
    )
    return join([slope, back, under, cheeks])


def revolved(pieces, sides: int, tint, at=(0.0, 0.0, 0.0)) -> Geometry:
    """A solid of revolution about z.

    Args:
        pieces: polylines of (radius, height) [m], each shaded smoothly in itself; going up, the
            outside lies to the right.
        sides: corners of the cross section.
        tint: (3,).
        at: (3,) [m].
    """
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    parts = []
    for piece in pieces:
        r, z = np.asarray(piece, np.float64).T
        n = len(r)
        v = np.stack(
            [r[:, None] * np.cos(turn), r[:, None] * np.sin(turn), z[:, None] + 0 * turn], -1
        )
        along = np.concatenate([[0], np.cumsum(np.hypot(np.diff(r), np.diff(z)))])
        uv = np.stack([r.max() * turn + 0 * along[:, None], along[:, None] + 0 * turn], -1)
        i = np.arange(n * (sides + 1)).reshape(n, sides + 1)
        a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
        lower, upper = np.stack([a, b, c], -1), np.stack([a, c, d], -1)
        faces = np.concatenate([lower[r[:-1] > 1e-9], upper[r[1:] > 1e-9]]).reshape(-1, 3)
        parts.append(geometry(v.reshape(-1, 3), faces, uv.reshape(-1, 2), tint))
    return join(parts).moved(at)


def cylinder(radius_m: float, height_m: float, tint, sides: int = 28, rim_m=0.03) -> Geometry:
    """An upright cylinder with a rounded rim, standing in the ground."""
    r, h = radius_m, height_m
    b = min(rim_m, 0.3 * r)
    side = [(r, -SUNK_M), (r, h - b)]
    return revolved([side, [(r, h - b), (r - b, h)], [(r - b, h), (0.0, h)]], sides, tint)


def sphere(radius_m: float, tint, sides: int = 32) -> Geometry:
    """A ball that rests in the ground by a twelfth of its radius."""
    t = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
    ring = np.column_stack([radius_m * np.cos(t), radius_m * (np.sin(t) + 11 / 12)])
    ring[[0, -1], 0] = 0.0
    return revolved([ring], sides, tint)


def cone(radius_m: float, height_m: float, tint, sides: int = 28, tip_m: float = 0.0) -> Geometry:
    """A cone, or a frustum with a tip of radius `tip_m`."""
    pieces = [[(radius_m, -SUNK_M), (tip_m, height_m)]]
    if tip_m > 0:
        pieces.append([(tip_m, height_m), (0.0, height_m)])
    return revolved(pieces, sides, tint)


def lying(part: Geometry, length_m: float, radius_m: float) -> Geometry:
    """An upright round part of a length laid along x on the ground, its middle at the origin."""
    x, y, z = part.vertices.astype(np.float64).T
    laid = np.column_stack([z - length_m / 2, y, -x + radius_m - 0.02])
    return geometry(laid, part.faces, part.uv, part.tint)


def pipe(length_m: float, radius_m: float, wall_m: float, tint, sides: int = 24) -> Geometry:
    """A pipe along x, open at both ends, lying on the ground."""
    r, q, n = radius_m, radius_m - wall_m, length_m
    outside, inside = [(r, 0.0), (r, n)], [(q, n), (q, 0.0)]
    ends = [[(r, n), (q, n)], [(q, 0.0), (r, 0.0)]]
    return lying(revolved([outside, inside, *ends], sides, tint), n, r)
