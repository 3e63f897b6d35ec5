"""The ground of the coast: a mesh whose rows follow the waterline, the cliffs and the road.

Near the flights the rows lie closest on cliff faces, so that nothing stretches there; around them
rings of growing cells reach the horizon.
"""

import dataclasses

import numpy as np
from scipy import ndimage

from synthdepth.maps.coast.shore import REACH_M, Shore, cliff_run, smooth

HALF_M = 300.0  # the near mesh covers |s| up to this
STEP_M = 1.2  # between its columns, and about that between its rows
ROAD_WIDTH_M = 6.6
VERGE_M = 1.1  # of gravel beside the road
MAX_GRADE = 0.09  # of the road
KEEP = 4  # every fourth vertex of its edge goes on into the rings


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pad:
    """Levelled ground, in local coordinates.

    Attributes:
        s_m, t_m: its middle.
        heading_rad: of its first axis against s.
        half_m: half its length and width.
        z_m: its height.
        blend_m: the ground around it meets it over this distance.
    """

    s_m: float
    t_m: float
    heading_rad: float
    half_m: tuple[float, float]
    z_m: float
    blend_m: float = 6.0

    def outside_m(self, s, t) -> np.ndarray:
        """Distance of places from it [m], 0 within."""
        c, z = np.cos(self.heading_rad), np.sin(self.heading_rad)
        a, b = c * (s - self.s_m) + z * (t - self.t_m), c * (t - self.t_m) - z * (s - self.s_m)
        a, b = np.abs(a) - self.half_m[0], np.abs(b) - self.half_m[1]
        return np.hypot(np.maximum(a, 0), np.maximum(b, 0))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Ground:
    """The ground as built.

    Attributes:
        shore: the coast without road and pads.
        road_t_m, road_z_m: (n,) tables over s like those of `shore`, of the road's middle.
        s: (columns,) [m].
        lines: (8, columns) t of the lines that rows follow: the mesh's seaward edge, 26 m off the
            waterline, the waterline, foot and brow of the cliff, both edges of the road, the
            mesh's landward edge.
        starts: (8,) the row on each of them.
        t, z: (rows, columns) [m].
    """

    shore: Shore
    road_t_m: np.ndarray
    road_z_m: np.ndarray
    s: np.ndarray
    lines: np.ndarray
    starts: np.ndarray
    t: np.ndarray
    z: np.ndarray

    def height_m(self, xy) -> np.ndarray:
        """Height of the ground or the sea bed [m] at world places (n, 2): (n,)."""
        s, t = self.shore.to_local(np.asarray(xy, np.float64).reshape(-1, 2))
        column = (s - self.s[0]) / (self.s[1] - self.s[0])
        inside = (column >= 0) & (column <= len(self.s) - 1)
        low = np.clip(column.astype(np.int64), 0, len(self.s) - 2)
        part = column - low
        lines = self.lines[:, low] * (1 - part) + self.lines[:, low + 1] * part
        inside &= (t >= lines[0]) & (t <= lines[-1])
        z = np.empty(len(s))
        k = np.clip((t >= lines).sum(axis=0) - 1, 0, len(lines) - 2)
        each = np.arange(len(s))
        share = (t - lines[k, each]) / (lines[k + 1, each] - lines[k, each])
        share = np.clip(share, 0.0, 1.0)
        # On the cliff rows lie evenly in height, not in t.
        counts = np.diff(self.starts)
        share = np.where(k == 3, np.interp(share, *_cliff_rows(counts[3])), share)
        row = self.starts[k] + share * counts[k]
        z[inside] = ndimage.map_coordinates(
            self.z, np.stack([row, column])[:, inside], order=1, mode="nearest"
        )
        if not inside.all():
            z[~inside] = levelled(self.shore, self.road_t_m, self.road_z_m, s[~inside], t[~inside])
        return z

    def surface_m(self, xy) -> np.ndarray:
        """Height of the ground, or of the sea where that lies higher: (n,) [m]."""
        return np.maximum(self.height_m(xy), 0.0)

    def away_m(self, xy) -> np.ndarray:
        """Distance inland from the waterline [m] at world places (n, 2)."""
        return self.shore.away_m(*self.shore.to_local(xy))

    def behind_m(self, xy) -> np.ndarray:
        """Distance inland from the cliff's brow or the dunes' foot [m] at world places (n, 2)."""
        s, t = self.shore.to_local(xy)
        look_up = self.shore.look_up
        return self.shore.away_m(s, t) - look_up("beach_m", s) - look_up("run_m", s)

    def from_road_m(self, xy) -> np.ndarray:
        """Distance from the road's middle [m], positive inland, at world places (n, 2)."""
        s, t = self.shore.to_local(xy)
        return t - _table(self.road_t_m, s)


def _table(values: np.ndarray, s) -> np.ndarray:
    return np.interp(s, np.arange(-REACH_M, REACH_M + 0.5), values)


def _cliff_rows(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Places of the cliff's rows (share of the run) and their number (share of the rows)."""
    rise = np.linspace(0, 1, count + 1)
    run = 0.75 * cliff_run(rise) + 0.25 * rise
    return run, rise


def _off_brow(shore: Shore, s, t) -> np.ndarray:
    """0 to 1: banks end before the cliff's brow."""
    brow = shore.look_up("beach_m", s) + shore.look_up("run_m", s)
    return smooth(shore.away_m(s, t) - brow, 0.0, 6.0)


def levelled(shore: Shore, road_t_m, road_z_m, s, t, pads: tuple[Pad, ...] = ()) -> np.ndarray:
    """Height of the ground with the road let into it, and with pads, at local places."""
    z = shore.natural_m(s, t)
    for pad in pads:
        near = (np.abs(s - pad.s_m) < 70) & (np.abs(t - pad.t_m) < 70)
        outside, lift = pad.outside_m(s[near], t[near]), pad.z_m - z[near]
        reach = pad.blend_m + 1.6 * np.abs(lift)
        z[near] += (
            lift * (1 - smooth(outside, 1.2, 1.2 + reach)) * _off_brow(shore, s[near], t[near])
        )
    aside = np.abs(t - _table(road_t_m, s))
    near = (aside < 40) & (np.abs(s) < HALF_M + 60)
    wide = ROAD_WIDTH_M / 2 + VERGE_M
    lift = _table(road_z_m, s[near]) - z[near]
    level = 1 - smooth(aside[near], wide, wide + np.minimum(9.0 + 1.5 * np.abs(lift), 35.0))
    level *= _off_brow(shore, s[near], t[near])
    # Cells beyond the near mesh are too coarse for a cutting.
    level *= 1 - smooth(np.abs(s[near]), HALF_M, HALF_M + 60)
    z[near] += lift * level
    return z


def draw_road(
    rng: np.random.Generator, shore: Shore, behind_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Tables of t and height of the road's middle over s [m]: it keeps behind cliffs and dunes."""
    s = np.arange(-REACH_M, REACH_M + 0.5)
    near = np.abs(s) <= HALF_M + 60
    brow = shore.line_m + (shore.beach_m + shore.run_m) * shore.stretch
    course = ndimage.gaussian_filter1d(shore.line_m, 75.0)
    course += 5.0 * np.sin(s / rng.uniform(70, 110) + rng.uniform(0, 6.28))
    course += max((brow - course)[near].max() + 13.0, (brow - course)[near].mean() + behind_m)
    # Beyond, it bears away from the shore.
    inner = int(REACH_M)
    reach = int(HALF_M + 60)
    for sign in (-1, 1):
        end = inner + sign * reach
        slope = course[end] - course[end - sign]
        run = np.arange(1, int(REACH_M) - reach + 1)
        bend = 0.3 * run - 90 * (1 - np.exp(-run / 300)) + slope * 300 * (1 - np.exp(-run / 300))
        course[end + sign * run] = course[end] + np.maximum(bend, -40)
    part = np.abs(s) < 1300
    z = np.full_like(s, 5.0)
    z[part] = ndimage.gaussian_filter1d(shore.natural_m(s[part], course[part]), 45.0)
    z[part] = np.maximum(z[part], 3.0)
    # Hills are cut and hollows filled until nothing is too steep to drive.
    steepest = np.abs(np.gradient(z[near])).max()
    middle = z[near].mean()
    z[part] = middle + (z[part] - middle) * min(1.0, MAX_GRADE / steepest)
    return course, z


def build_ground(
    shore: Shore, road: tuple[np.ndarray, np.ndarray], pads: tuple[Pad, ...] = ()
) -> Ground:
    """The near mesh's heights."""
    road_t, road_z = road
    columns = int(2 * HALF_M / STEP_M / KEEP) * KEEP
    s = np.linspace(-HALF_M, HALF_M, columns + 1)
    line, q = shore.look_up("line_m", s), shore.look_up("stretch", s)
    foot = line + shore.look_up("beach_m", s) * q
    brow = foot + shore.look_up("run_m", s) * q
    middle = _table(road_t, s)
    half = ROAD_WIDTH_M / 2
    seaward = min(-HALF_M, line.min() - 90.0)
    landward = max(HALF_M, middle.max() + 60.0)
    lines = np.stack(
        [
            np.full_like(s, seaward),
            line - 26.0 * q,
            line,
            foot,
            brow,
            middle - half,
            middle + half,
            np.full_like(s, landward),
        ]
    )
    # Rows fan out where the shore is ragged: their number suits the wider places.
    wide = np.quantile(np.diff(lines, axis=0), 0.85, axis=1)
    tall = shore.look_up("cliff_m", s).max()
    rows = np.array(
        [
            4,
            13,
            max(int(wide[2] / 1.15), 4),
            int(np.clip(tall / 1.1, 5, 46)),
            max(int(wide[4] / 1.4), 4),
            4,
            int(wide[6] / STEP_M),
        ]
    )
    rows[-1] += -rows.sum() % KEEP
    t = [lines[:1]]
    for k, count in enumerate(rows):
        share = _cliff_rows(count)[0] if k == 3 else np.linspace(0, 1, count + 1)
        t.append(lines[k] + share[1:, None] * (lines[k + 1] - lines[k]))
    t = np.concatenate(t)
    z = levelled(shore, road_t, road_z, np.broadcast_to(s, t.shape), t, pads)
    for edge in (z[0], z[-1], z[:, 0], z[:, -1]):
        edge[:] = on_chords(edge)
    for edge in (t[:, 0], t[:, -1]):
        edge[:] = on_chords(edge)
    return Ground(
        shore=shore,
        road_t_m=road_t,
        road_z_m=road_z,
        s=s,
        lines=lines,
        starts=np.concatenate([[0], np.cumsum(rows)]),
        t=t,
        z=z,
    )


def on_chords(values: np.ndarray) -> np.ndarray:
    """Values (n,) along an edge, moved onto straight lines between every fourth."""
    n = np.arange(len(values))
    return np.interp(n, n[::KEEP], values[::KEEP])


def perimeter(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Every fourth vertex (n, 2) round a mesh's edge, counter-clockwise; s, t: (rows, columns)."""
    edge = np.stack([s, t], -1)
    return np.concatenate(
        [
            edge[0, :-1:KEEP],
            edge[:-1:KEEP, -1],
            edge[-1, :0:-KEEP],
            edge[:0:-KEEP, 0],
        ]
    )


def rings(edge: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rings of growing cells around a mesh.

    Args:
        edge: (n, 2) the mesh's perimeter.
        reach: (k,) how many times farther than the perimeter each ring lies; the first is 1.

    Returns:
        (k, n, 2) places, and (m, 3) faces into them.
    """
    middle = (edge.min(axis=0) + edge.max(axis=0)) / 2
    places = middle + (edge - middle) * reach[:, None, None]
    k, n = len(reach), len(edge)
    ring, step = np.meshgrid(np.arange(k - 1), np.arange(n), indexing="ij")
    i, j = (ring * n + step).ravel(), (ring * n + (step + 1) % n).ravel()
    faces = np.concatenate([np.stack([i, i + n, j + n], 1), np.stack([i, j + n, j], 1)])
    return places, faces


def grid_faces(rows: int, columns: int) -> np.ndarray:
    """(rows - 1, columns - 1, 2, 3) faces of a grid whose rows run inland and columns along s."""
    i = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2)


def cut_quads(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(rows - 1, columns - 1, 2, 3) faces of the grid, each cell cut along its shorter diagonal."""
    rows, columns = s.shape
    i = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    rising = np.hypot(s[1:, 1:] - s[:-1, :-1], t[1:, 1:] - t[:-1, :-1])
    falling = np.hypot(s[1:, :-1] - s[:-1, 1:], t[1:, :-1] - t[:-1, 1:])
    short = (rising <= falling)[..., None]
    lower = np.where(short, np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    upper = np.where(short, np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    return np.stack([lower, upper], -2)
