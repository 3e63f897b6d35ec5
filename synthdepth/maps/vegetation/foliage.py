"""What plants are made of: leaf clumps and tapering branches, thousands to a call."""

import numpy as np

from synthdepth.maps.geometry import Geometry, cross, geometry


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) scaled to length 1."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.maximum(length, 1e-9)


def directions(rng: np.random.Generator, count: int) -> np.ndarray:
    """Directions spread evenly over the sphere, (count, 3) float64."""
    return unit(rng.normal(size=(count, 3)))


def clumps(centre, along, normal, length_m, width_m, tint, skew=0.0, fold=0.35) -> Geometry:
    """`k` leaf clumps: two bent leaflets each, one triangle a leaflet, spread from a common stalk.

    Two leaflets show twice the edges of one kite for the same two triangles, and their fold gives
    each clump two shades.

    Args:
        centre: (k, 3) middle of the clump [m].
        along: (k, 3) direction from the twig to the tips.
        normal: (k, 3) the side that faces out; made perpendicular to `along`.
        length_m: (k,) from stalk to tips.
        width_m: (k,) across.
        tint: (k, 3) linear reflectance.
        skew: scalar or (k,), how far the sides slide along the clump, in lengths.
        fold: drop of both side corners, in widths.
    """
    centre = np.asarray(centre, np.float64)
    a = unit(np.asarray(along, np.float64))
    s = unit(cross(normal, a))
    n = cross(a, s)
    k = len(centre)
    half = (np.broadcast_to(length_m, k) / 2)[:, None]
    wide = (np.broadcast_to(width_m, k) / 2)[:, None]
    slide = np.broadcast_to(skew, k)[:, None] * 2
    low = centre - 2 * fold * wide * n
    tip = centre - 0.3 * half * n

    def at(middle, forward, left):
        return middle + forward * half * a + left * wide * s

    corners = np.stack(
        [
            at(centre, -1, 0),
            at(low, slide, -1),
            at(tip, 1 + slide, -0.5),
            at(tip, 1 - slide, 0.5),
            at(low, -slide, 1),
        ],
        axis=1,
    )
    o = np.zeros_like(half)
    uv = np.stack(
        [
            np.hstack([o, o]),
            np.hstack([wide, half]),
            np.hstack([wide / 2, 2 * half]),
            np.hstack([-wide / 2, 2 * half]),
            np.hstack([-wide, half]),
        ],
        axis=1,
    )
    first = 5 * np.arange(k)[:, None]
    faces = np.concatenate([first + [0, 1, 2], first + [0, 3, 4]], axis=1)
    return geometry(corners, faces, uv, np.repeat(np.broadcast_to(tint, (k, 3)), 5, axis=0))


def tapers(path, radius_m, sides: int, tint) -> Geometry:
    """`b` round branches at once, each running to a point.

    Vertices are shared around the branch, so u (metres) runs out and back instead of wrapping.

    Args:
        path: (b, s, 3) [m], s >= 2.
        radius_m: (b, s - 1), of all stations but the last, which is the tip.
        sides: corners of the cross section.
        tint: (3,), (b, 1, 3) or (b, s, 3).
    """
    p = np.asarray(path, np.float64)
    b, s, _ = p.shape
    r = np.broadcast_to(np.asarray(radius_m, np.float64), (b, s - 1))
    forward = unit(np.gradient(p, axis=1))
    # One reference axis a branch: a Frenet frame would flip where it is straight.
    reference = np.eye(3)[np.argmin(np.abs(forward).max(axis=1), axis=1)]
    x = unit(cross(forward, reference[:, None]))
    y = cross(forward, x)
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(turn)[:, None] * x[:, :-1, None] + np.sin(turn)[:, None] * y[:, :-1, None]
    rings = p[:, :-1, None] + r[..., None, None] * ring
    vertices = np.concatenate([rings.reshape(b, -1, 3), p[:, -1:]], axis=1)

    run = np.linalg.norm(np.diff(p, axis=1), axis=-1).cumsum(axis=1)
    run = np.concatenate([np.zeros((b, 1)), run], axis=1)
    out_and_back = np.minimum(turn, 2 * np.pi - turn)
    uv_rings = np.stack(
        np.broadcast_arrays(r[:, :1, None] * out_and_back, run[:, :-1, None]), axis=-1
    )
    uv_tip = np.stack([np.zeros(b), run[:, -1]], axis=-1)[:, None]
    uv = np.concatenate([uv_rings.reshape(b, -1, 2), uv_tip], axis=1)

    tint = np.broadcast_to(np.asarray(tint, np.float64), (b, s, 3))
    tints = np.concatenate([np.repeat(tint[:, :-1], sides, axis=1), tint[:, -1:]], axis=1)

    row, col = np.meshgrid(np.arange(s - 2) * sides, np.arange(sides), indexing="ij")
    i, j = (row + col).ravel(), (row + (col + 1) % sides).ravel()
    last = np.arange(sides)
    cone = np.stack(
        [
            (s - 2) * sides + last,
            (s - 2) * sides + (last + 1) % sides,
            np.full(sides, (s - 1) * sides),
        ],
        axis=1,
    )
    wall = np.concatenate([np.stack([i, j, j + sides], 1), np.stack([i, j + sides, i + sides], 1)])
    faces = np.concatenate([wall, cone])
    n = (s - 1) * sides + 1
    faces = faces[None] + (n * np.arange(b))[:, None, None]
    return geometry(vertices, faces, uv, tints.reshape(-1, 3))


def arcs(start, control, end, segments: int) -> np.ndarray:
    """Quadratic Bezier curves: three (b, 3) points each -> (b, segments + 1, 3)."""
    t = np.linspace(0, 1, segments + 1)[None, :, None]
    return (1 - t) ** 2 * start[:, None] + 2 * t * (1 - t) * control[:, None] + t**2 * end[:, None]


def dark_cores(centre, radius_m, tint, rng: np.random.Generator) -> Geometry:
    """`k` rough dark balls of 20 triangles, what is seen through the gaps of a shrub.

    Args:
        centre: (k, 3) [m].
        radius_m: (k, 3) half axes [m].
        tint: (k, 3).
        rng: of the roughness.
    """
    g = (1 + 5**0.5) / 2
    v = np.array(
        [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g]]
        + [[0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    ) / np.hypot(1, g)
    f = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4]]
        + [[11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8]]
        + [[3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    )
    k = len(centre)
    rough = rng.uniform(0.75, 1.2, (k, 12, 1))
    vertices = centre[:, None] + rough * v * np.asarray(radius_m)[:, None]
    faces = f[None] + 12 * np.arange(k)[:, None, None]
    return geometry(vertices, faces, tint=np.repeat(tint, 12, axis=0))
