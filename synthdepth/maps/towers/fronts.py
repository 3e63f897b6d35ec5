"""Ground floors parted into stretches: shops, entrances, lobbies; and the wall round each."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from synthdepth.maps.towers.facades import soiling
from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Key, Panels, faces, ring

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

# How far walls reach into the ground [m].
SUNK_M = 0.3
# Shop fronts' colours and awnings' cloth.
FRONTS = np.array(
    [
        [0.05, 0.05, 0.055], [0.02, 0.045, 0.035], [0.03, 0.05, 0.1], [0.16, 0.03, 0.03],
        [0.35, 0.34, 0.31], [0.13, 0.08, 0.05], [0.5, 0.5, 0.48], [0.09, 0.1, 0.11],
        [0.2, 0.17, 0.12], [0.07, 0.12, 0.13],
    ]
)  # fmt: skip
WARM = (0.6, 0.5, 0.34)


class Fronts(NamedTuple):
    """Stretches of ground-floor wall: all (k,).

    Attributes:
        wall: number of the wall.
        a, b: extent along the wall [m].
        kind: one of `KINDS`, as its number.
    """

    wall: np.ndarray
    a: np.ndarray
    b: np.ndarray
    kind: np.ndarray

    def of(self, *names: str) -> "Fronts":
        """Those of some kinds."""
        rows = np.isin(self.kind, [KINDS.index(n) for n in names])
        return Fronts(*(x[rows] for x in self))


KINDS = ("shop", "shutter", "entrance", "lobby", "flat", "blank", "service", "dock")
_MIX = {
    "shops": (("shop", "shutter", "blank"), (0.86, 0.12, 0.02), (4.2, 8.0)),
    "lobby": (("lobby", "shop"), (0.82, 0.18), (6.0, 10.0)),
    "flats": (("flat", "service"), (0.93, 0.07), (2.6, 3.6)),
    "dock": (("dock", "flat", "shop"), (0.35, 0.4, 0.25), (4.2, 5.4)),
}
_BACK = (("blank", "service", "flat", "dock"), (0.55, 0.2, 0.15, 0.1), (4.0, 8.0))


def fronts_of(params: "Tower", edges: Edges, rng: np.random.Generator) -> Fronts:
    """The ground floor's walls parted into stretches; each street side has an entrance."""
    rows = []
    for w in np.flatnonzero(edges.tier == 0):
        length = edges.length_m[w]
        kinds, shares, widths = _MIX[params.ground] if edges.street[w] else _BACK
        count = max(1, round(length / rng.uniform(*widths)))
        cuts = length * np.arange(count + 1) / count
        cuts[1:-1] += rng.uniform(-0.12, 0.12, count - 1) * length / count
        kind = [KINDS.index(kinds[i]) for i in rng.choice(len(kinds), count, p=shares)]
        if edges.street[w]:
            # The entrance takes part of a stretch, the middle one of a lobby.
            at = count // 2 if params.ground == "lobby" else int(rng.integers(count))
            own = min(4.6 if params.ground == "lobby" else 2.9, cuts[at + 1] - cuts[at])
            if cuts[at + 1] - cuts[at] - own > 1.6:
                cuts = np.insert(cuts, at + 1, cuts[at] + own)
                kind.insert(at, KINDS.index("entrance"))
                count += 1
            else:
                kind[at] = KINDS.index("entrance")
        rows += [(w, cuts[i], cuts[i + 1], kind[i]) for i in range(count)]
    wall, a, b, kind = (np.array(c) for c in zip(*rows, strict=True))
    return Fronts(wall, a, b, kind)


def base_wall(params: "Tower") -> tuple[Key, np.ndarray]:
    """Key and tint of the ground floor's wall: of stone where it is rusticated."""
    material, tint = params.trim if params.rusticated else params.wall
    return (material, "building"), np.asarray(tint) * soiling(0.0)


# Bands of a ground-floor wall with the shade of their lower and upper edges: splashes darken the
# foot.
_FOOT_M = 0.45


def _bands(top: float):
    return (-SUNK_M, _FOOT_M, 0.62, 0.88), (_FOOT_M, top, 0.88, 1.0)


def plain_wall(panels: Panels, params: "Tower", f: Fronts, top: float) -> None:
    """Walls without openings."""
    key, tint = base_wall(params)
    for low, high, lower, upper in _bands(top):
        panels.add(key, tint, faces(f.a, f.b, low, high), f.wall, (lower, lower, upper, upper))


def pierced_wall(panels: Panels, params: "Tower", f: Fronts, top: float, margin, height: float):
    """Walls with a hole of `height` that leaves `margin` on each side: the hole's s0, s1 (k,)."""
    key, tint = base_wall(params)
    s0, s1 = f.a + margin, f.b - margin
    for low, high, lower, upper in _bands(top):
        shade = np.ones((len(f.a), 4, 4))
        shade[:, :2] = lower, lower, upper, upper
        hole = ring(f.a, f.b, low, high, s0, s1, low, np.clip(height, low, high))
        panels.add(key, tint, hole, f.wall, shade)
    return s0, s1


def repeat(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Owner and number within the owner of `counts` (k,) things each."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
