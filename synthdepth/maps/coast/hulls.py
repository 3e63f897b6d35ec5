"""Boats' hulls: lofted from sections between a keel line and a sheer line.

x is forward, 0 at mid-length; z = 0 is the waterline. A hull is described by shares: s from the
stern (0) to the bow (1), h from the keel (0) to the sheer (1).
"""

import dataclasses

import numpy as np

from synthdepth.maps.coast.lofts import both_sides, mirrored, sheet
from synthdepth.maps.geometry import Geometry, join, tube

_KEYS = (0.0, 0.45, 1.0)  # stern, middle and bow, where heights are given
# Half widths over h of the sections amidships.
_SECTIONS = {
    "chine": ((0.0, 0.36, 0.42, 1.0), (0.0, 0.83, 0.88, 1.0)),
    "flat": ((0.0, 0.1, 0.2, 1.0), (0.0, 0.78, 0.86, 1.0)),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Hull:
    """Lines of a hull.

    Attributes:
        length_m: over all, at the sheer.
        beam_m: greatest width, at the sheer.
        sheer_m: height of the sheer above the water at stern, middle and bow.
        keel_m: depth of the keel below the water at stern, middle and bow, all > 0.
        transom: width of the stern as a share of the beam; near 0 for double-enders.
        widest: s of the greatest width.
        bow_power: fullness of the bow, 1.6 (fine) to 3.5 (bluff).
        section: "round", "chine" or "flat".
        stem_rake_m: how far the foot of the stem lies aft of its head.
        stern_rake_m: how far the foot of the stern lies ahead of its top; < 0 leans the other way.
    """

    length_m: float
    beam_m: float
    sheer_m: tuple[float, float, float]
    keel_m: tuple[float, float, float]
    transom: float = 0.8
    widest: float = 0.42
    bow_power: float = 2.2
    section: str = "round"
    stem_rake_m: float = 0.5
    stern_rake_m: float = 0.1

    def half_beam(self, s) -> np.ndarray:
        """Half width [m] at the sheer."""
        s = np.asarray(s, np.float64)
        aft = np.clip((self.widest - s) / self.widest, 0, 1)
        fore = np.clip((s - self.widest) / (1 - self.widest), 0, 1)
        share = np.where(s < self.widest, 1 - (1 - self.transom) * aft**2, 1 - fore**self.bow_power)
        return self.beam_m / 2 * np.maximum(share, 0.006)

    def sheer(self, s) -> np.ndarray:
        """Height of the sheer [m]."""
        return _parabola(self.sheer_m, s)

    def keel(self, s) -> np.ndarray:
        """Height of the keel [m], negative."""
        return -np.maximum(_parabola(self.keel_m, s), 0.02)

    def section_share(self, s, h) -> np.ndarray:
        """Half width as a share of that at the sheer."""
        s, h = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(h, np.float64))
        if self.section == "round":
            middle = (1 - (1 - np.clip(h, 0, 1)) ** 2.4) ** (1 / 2.0)
        else:
            middle = np.interp(h, *_SECTIONS[self.section])
        flared = 0.62 * h + 0.38 * h**2.2
        t = np.clip((s - 0.5) / 0.5, 0, 1)
        bow = t * t * (3 - 2 * t)
        return (1 - bow) * middle + bow * flared

    def points(self, s, z) -> np.ndarray:
        """Points (..., 3) of the left side at shares `s` and heights `z` [m], broadcast."""
        s, z = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(z, np.float64))
        h = np.clip((z - self.keel(s)) / (self.sheer(s) - self.keel(s)), 0, 1)
        stem_h = np.clip((z - self.keel(1.0)) / (self.sheer(1.0) - self.keel(1.0)), 0, 1)
        stern_h = np.clip((z - self.keel(0.0)) / (self.sheer(0.0) - self.keel(0.0)), 0, 1)
        stem = self.length_m / 2 - self.stem_rake_m * (1 - stem_h) ** 1.6
        stern = -self.length_m / 2 + self.stern_rake_m * (1 - stern_h)
        y = self.half_beam(s) * self.section_share(s, h)
        return np.stack([stern + s * (stem - stern), y, z], -1)

    def edge(self, s, inset_m: float = 0.0, lift_m: float = 0.0) -> np.ndarray:
        """Points (k, 3) of the left sheer at shares `s` (k,), moved inboard and up."""
        p = self.points(s, self.sheer(s))
        p[..., 1] = np.maximum(p[..., 1] - inset_m, 0.004)
        p[..., 2] += lift_m
        return p

    def share_at(self, x: float) -> float:
        """s of the sheer's point at `x` [m]."""
        return float(np.clip(x / self.length_m + 0.5, 0, 1))


def _parabola(values: tuple[float, float, float], s) -> np.ndarray:
    a, b, c = values
    p, q, r = _KEYS
    s = np.asarray(s, np.float64)
    return (
        a * (s - q) * (s - r) / ((p - q) * (p - r))
        + b * (s - p) * (s - r) / ((q - p) * (q - r))
        + c * (s - p) * (s - q) / ((r - p) * (r - q))
    )


def stations(count: int) -> np.ndarray:
    """Shares s (count,), closer together towards the bow, where the hull curves."""
    u = np.linspace(0, 1, count)
    return 1 - (1 - u) ** 1.45


def skin(hull: Hull, bands, count: int = 18) -> Geometry:
    """The outside of a hull and its transom, in horizontal or sheer-parallel bands of colour.

    Args:
        hull: its lines.
        bands: ((top, tint), ...) from the keel up. A top is a height [m] above the water, or a
            string "sheer" or "sheer-0.08", that many metres below the sheer.
        count: stations.
    """
    s = stations(count)
    parts = []
    low = hull.keel(s)
    for k, (top, tint) in enumerate(bands):
        high = _top(hull, s, top)
        rows = 6 if k == 0 else (2 if np.max(high - low) < 0.2 else 4)
        t = np.linspace(0, 1, rows)[:, None]
        side = hull.points(s[None], low + t * (high - low))
        if k == 0:
            side[0, :, 1] = 0.0
        parts += [sheet(side[:, ::-1], tint), mirrored(sheet(side[:, ::-1], tint))]
        stern = side[:, 0]
        parts.append(sheet(np.stack([stern, stern * [1, -1, 1]], axis=1), tint))
        low = high
    return join(parts)


def _top(hull: Hull, s: np.ndarray, top) -> np.ndarray:
    if isinstance(top, str):
        below = float(top.removeprefix("sheer") or 0.0)
        return hull.sheer(s) + below
    return np.minimum(np.full(len(s), float(top)), hull.sheer(s) - 0.05)


def strakes(hull: Hull, tints, count: int = 16, lap_m: float = 0.012) -> Geometry:
    """A clinker-built outside: one plank over the next, tints (k, 3) from the keel up."""
    s = stations(count)
    levels = np.linspace(0, 1, len(tints) + 1) ** 0.85
    low, rise = hull.keel(s), hull.sheer(s) - hull.keel(s)
    parts = []
    for k, tint in enumerate(tints):
        side = hull.points(s[None], low + levels[k : k + 2, None] * rise)
        # Outboard by a plank's thickness at its lower edge, tapering out at stem and stern.
        side[0, :, 1] += lap_m * np.minimum(1, 4 * (1 - s)) * (k > 0)
        if k == 0:
            side[0, :, 1] = 0.0
        under = np.stack([side[0] - [0, lap_m, 0], side[0]])
        under[0, :, 1] = np.maximum(under[0, :, 1], 0.0)
        outside = [sheet(side[:, ::-1], tint)]
        if k > 0:
            outside.append(sheet(under[:, ::-1], tint))
        parts += [both_sides(part) for part in outside]
        stern = side[:, 0]
        parts.append(sheet(np.stack([stern, stern * [1, -1, 1]], axis=1), tint))
    return join(parts)


def lining(hull: Hull, floor_m: float, tint, *, inset_m: float = 0.03, count: int = 16) -> Geometry:
    """The inside of an open boat: sides and transom down to a floor, and the gunwale's top."""
    s = stations(count) * 0.985
    sheer = hull.sheer(s)
    t = np.linspace(0, 1, 4)[:, None]
    side = hull.points(s[None], floor_m + t * (sheer - 0.001 - floor_m))
    side[..., 1] = np.maximum(side[..., 1] - inset_m, 0.002)
    side[:, 0, 0] += inset_m
    top = np.stack([side[-1], hull.points(s, sheer)])
    stern = side[:, 0]
    board = np.stack([stern, stern * [1, -1, 1]], axis=1)
    bottom = np.stack([side[0], side[0] * [1, -1, 1]])
    cap = hull.points(s[:1], sheer[:1])
    cap = np.stack(
        [np.stack([stern[-1], stern[-1] * [1, -1, 1]]), np.concatenate([cap, cap * [1, -1, 1]])]
    )
    return join(
        [
            both_sides(sheet(side)),
            both_sides(sheet(top)),
            sheet(board[:, ::-1]),
            sheet(bottom),
            sheet(cap),
        ]
    ).tinted(tint)


def deck(hull: Hull, tint, *, wells=(), camber_m: float = 0.06, drop_m: float = 0.0) -> Geometry:
    """The deck from side to side, with wells (cockpits, holds) let into it.

    Args:
        hull: its lines.
        tint: (3,).
        wells: ((s0, s1, half width [m], floor height [m]), ...), not overlapping.
        camber_m: rise of the middle over the edges.
        drop_m: height of the bulwarks around it.
    """
    s = stations(18) * 0.992
    for s0, s1, *_ in wells:
        s = s[(np.abs(s - s0) > 0.015) & (np.abs(s - s1) > 0.015)]
        s = np.concatenate([s, [s0, s1]])
    s = np.sort(s)
    parts, done = [], 0
    spans = []
    for well in sorted(wells):
        a, b = np.searchsorted(s, well[0] - 1e-9), np.searchsorted(s, well[1] - 1e-9)
        spans.append((done, a, None))
        spans.append((a, b, well))
        done = b
    spans.append((done, len(s) - 1, None))
    for a, b, well in spans:
        if b <= a:
            continue
        part = s[a : b + 1]
        side = hull.edge(part)
        side[:, 2] -= drop_m

        def rows(shares, part=part, side=side):
            grid = np.repeat(side[None], len(shares), 0)
            t = np.asarray(shares, np.float64).reshape(len(shares), -1)
            grid[..., 1] *= t
            grid[..., 2] += camber_m * (1 - t**2) * (hull.half_beam(part) / hull.beam_m * 2)
            return grid

        if well is None:
            parts.append(sheet(rows([1.0, 0.5, 0.0, -0.5, -1.0])[:, ::-1]))
            continue
        half = np.minimum(well[2], 0.9 * side[:, 1])
        inner = half / side[:, 1]
        strip = rows(np.stack([np.ones(len(part)), inner]))
        parts.append(both_sides(sheet(strip[:, ::-1])))
        rim = strip[1]
        foot = rim * [1, 0.94, 0] + [0, 0, well[3]]
        parts.append(both_sides(sheet(np.stack([foot, rim]))))
        parts.append(sheet(np.stack([foot, foot * [1, -1, 1]])[:, ::-1]))
        for end, step in ((0, 1), (-1, -1)):
            wide = np.array([1.0, 0.0, -1.0])[::step, None]
            low = foot[end] * [1, 0, 1] + foot[end] * [0, 1, 0] * wide
            high = rim[end] * [1, 0, 1] + rim[end] * [0, 1, 0] * wide
            high[1, 2] = rows([0.0])[0, end, 2]
            parts.append(sheet(np.stack([low, high])))
    return join(parts).tinted(tint)


def rub_rail(
    hull: Hull, radius_m: float, tint, *, below_m: float = 0.0, count: int = 22
) -> Geometry:
    """A bar along both sheers, meeting at the stem."""
    s = stations(count)
    left = hull.edge(s, -0.3 * radius_m, -below_m)
    left[-1, 1] = 0.0
    path = np.concatenate([left, left[-2::-1] * [1, -1, 1]])
    return tube(path, radius_m, 5, tint)
