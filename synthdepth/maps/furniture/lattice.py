"""Lattices of thin bars: masts, jibs, trusses and pylons."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.geometry import Geometry, join


def lattice(
    rings: np.ndarray,
    chord_m: float,
    brace_m: float,
    tint=(1.0, 1.0, 1.0),
    *,
    crossed: bool = False,
    level: bool = True,
    open_faces: tuple[int, ...] = (),
) -> Geometry:
    """Chords through the corners of cross sections, braced on every face.

    Args:
        rings: (n, c, 3) corners of n sections [m], c of 2 (a flat truss) or more.
        chord_m, brace_m: radii [m].
        tint: (3,).
        crossed: two diagonals a panel; otherwise one, alternating.
        level: bars round each section too.
        open_faces: faces without braces, numbered by their first corner.
    """
    r = np.asarray(rings, np.float64)
    n, c = r.shape[:2]
    first = [i for i in range(c if c > 2 else 1) if i not in open_faces]
    nxt = [(i + 1) % c for i in first]
    ends: list[tuple[np.ndarray, np.ndarray]] = []
    a, b = r[:, first], r[:, nxt]
    odd = (np.arange(n - 1) % 2 == 1)[:, None, None]
    ends.append((np.where(odd, b[:-1], a[:-1]), np.where(odd, a[1:], b[1:])))
    if crossed:
        ends.append((np.where(odd, a[:-1], b[:-1]), np.where(odd, b[1:], a[1:])))
    if level:
        ends.append((a, b))
    start = np.concatenate([s.reshape(-1, 3) for s, _ in ends])
    stop = np.concatenate([e.reshape(-1, 3) for _, e in ends])
    chords = round_bars(r[:-1].reshape(-1, 3), r[1:].reshape(-1, 3), chord_m, sides=5)
    return join([chords, round_bars(start, stop, brace_m, sides=4)]).tinted(tint)


def square_rings(z, half) -> np.ndarray:
    """Square sections (n, 4, 3) about z at heights (n,), `half` (n,) their half widths [m]."""
    z, half = np.broadcast_arrays(np.asarray(z, float), np.asarray(half, float))
    corner = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1.0]])
    xy = half[:, None, None] * corner
    return np.concatenate([xy, np.broadcast_to(z[:, None, None], (len(z), 4, 1))], axis=2)


def between(start: np.ndarray, stop: np.ndarray, panels: int) -> np.ndarray:
    """Sections (panels + 1, c, 3) from one (c, 3) to another."""
    t = np.linspace(0, 1, panels + 1)[:, None, None]
    return np.asarray(start) * (1 - t) + np.asarray(stop) * t


def bands(part: Geometry, height_m: float, colours, count: int) -> Geometry:
    """Paints a part in `count` bands up to `height_m`, as masts are against aircraft."""
    # By bar, not by vertex: a bar has one colour.
    band = np.clip((part.vertices[:, 2] / height_m * count).astype(int), 0, count - 1)
    return part.tinted(np.asarray(colours)[band % len(colours)])
