"""Lines of soccer pitches, courts and running tracks, after the laws of each game."""

import numpy as np
import shapely

from synthdepth.maps.geometry import Geometry, Model, geometry
from synthdepth.maps.stadium.surfaces import tessellate

LINE_M = 0.12
_LIFT_M = 0.008


def arc(x: float, y: float, radius: float, start_deg: float, end_deg: float) -> shapely.Geometry:
    """An arc as a polyline with chords that stray by less than 1 cm."""
    n = max(int(abs(end_deg - start_deg) / np.degrees(2 * np.sqrt(2 * 0.004 / radius))), 4)
    a = np.radians(np.linspace(start_deg, end_deg, n + 1))
    return shapely.LineString(np.column_stack([x + radius * np.cos(a), y + radius * np.sin(a)]))


def stroked(lines, width_m: float) -> shapely.Geometry:
    """The area that lines of a width cover, counted once where they cross."""
    return shapely.union_all(
        shapely.buffer(list(lines), width_m / 2, cap_style="square", join_style="mitre")
    )


def soccer_lines(length_m: float, width_m: float) -> shapely.Geometry:
    """Lines of a pitch (IFAB, Law 1); areas shrink with pitches too small for them.

    Lines belong to the areas that they bound: their outer edges have the measures of the law.
    """
    k = min(1.0, length_m / 90.0, width_m / 58.0)
    half, side, w = length_m / 2 - LINE_M / 2, width_m / 2 - LINE_M / 2, LINE_M / 2
    lines = [
        shapely.box(-half, -side, half, side).exterior,
        shapely.LineString([(0, -side), (0, side)]),
        arc(0, 0, 9.15 * k - w, 0, 360),
    ]
    for s in (-1, 1):
        for depth, post in ((16.5 * k, 16.5 * k), (5.5 * k, 5.5 * k)):
            y = 3.66 * min(1.0, 1.2 * k) + post - w
            x = s * (half - depth + LINE_M)
            lines.append(shapely.LineString([(s * half, -y), (x, -y), (x, y), (s * half, y)]))
        spot = length_m / 2 - 11 * k
        opening = np.degrees(np.arccos(5.5 / 9.15)) - 0.3
        middle = 180.0 if s > 0 else 0.0
        lines.append(arc(s * spot, 0, 9.15 * k - w, middle - opening, middle + opening))
        for t in (-1, 1):
            first = {(1, 1): 180.0, (-1, 1): 270.0, (-1, -1): 0.0, (1, -1): 90.0}[s, t]
            lines.append(arc(s * half, t * side, 1.0 - w, first, first + 90))
    spots = [shapely.Point(s * (length_m / 2 - 11 * k), 0).buffer(0.11) for s in (-1, 1)]
    spots.append(shapely.Point(0, 0).buffer(0.11))
    # Ends of the corner arcs are square: what juts out of the field goes.
    field = shapely.box(-length_m / 2, -width_m / 2, length_m / 2, width_m / 2)
    return shapely.intersection(shapely.union_all([stroked(lines, LINE_M), *spots]), field)


def tennis_lines() -> shapely.Geometry:
    """A court of 23.77 x 10.97 m."""
    lines = [shapely.box(-11.86, -5.46, 11.86, 5.46).exterior]
    lines += [shapely.LineString([(-11.86, s * 4.09), (11.86, s * 4.09)]) for s in (-1, 1)]
    lines += [shapely.LineString([(s * 6.4, -4.09), (s * 6.4, 4.09)]) for s in (-1, 1)]
    lines.append(shapely.LineString([(-6.4, 0), (6.4, 0)]))
    return stroked(lines, 0.05)


def basketball_lines() -> shapely.Geometry:
    """A court of 28 x 15 m (FIBA)."""
    lines = [shapely.box(-13.97, -7.47, 13.97, 7.47).exterior]
    lines += [shapely.LineString([(0, -7.47), (0, 7.47)]), arc(0, 0, 1.8, 0, 360)]
    for s in (-1, 1):
        hoop, edge = s * 12.425, s * 13.97
        lines.append(
            shapely.LineString([(edge, -2.45), (s * 8.2, -2.45), (s * 8.2, 2.45), (edge, 2.45)])
        )
        middle = 180.0 if s > 0 else 0.0
        lines.append(arc(s * 8.2, 0, 1.8, middle - 90, middle + 90))
        opening = np.degrees(np.arcsin(6.6 / 6.75))
        lines.append(arc(hoop, 0, 6.75, middle - opening, middle + opening))
        foot = hoop - s * np.sqrt(6.75**2 - 6.6**2)
        lines += [shapely.LineString([(edge, t * 6.6), (foot, t * 6.6)]) for t in (-1, 1)]
    return stroked(lines, 0.05)


def track_lines(straight_m: float, radius_m: float, lanes: int) -> shapely.Geometry:
    """Lanes of 1.22 m around a field, and the finish."""
    lines = []
    for lane in range(lanes + 1):
        r = radius_m + 1.22 * lane
        lines.append(shapely.LinearRing(oval(straight_m, r)))
    lines += [
        shapely.LineString([(x, -radius_m), (x, -radius_m - 1.22 * lanes)])
        for x in (straight_m / 2, -straight_m / 2 + 8)
    ]
    return stroked(lines, 0.05)


def oval(straight_m: float, radius_m: float) -> np.ndarray:
    """A stadium curve (k, 2): two straights and two half circles."""
    right = shapely.get_coordinates(arc(straight_m / 2, 0, radius_m, -90, 90))
    left = shapely.get_coordinates(arc(-straight_m / 2, 0, radius_m, 90, 270))
    return np.concatenate([right, left])


def flat_mesh(area: shapely.Geometry, tint=(1.0, 1.0, 1.0), lift_m: float = _LIFT_M) -> Geometry:
    """An area as triangles a little above the ground, in cells that follow the land."""
    corners, _ = tessellate(area, (6.0, 6.0))
    xyz = np.concatenate([corners, np.full((*corners.shape[:2], 1), lift_m)], axis=2)
    return geometry(xyz, np.arange(3 * len(corners)), tint=tint)


def paint(area: shapely.Geometry, material: str, tint, label: str = "ground") -> Model:
    """Paint on the ground."""
    return {(material, label): flat_mesh(area, tint)}
