"""Masses of a tower: podium, shaft, setbacks, and the walls that bound them."""

import dataclasses

import numpy as np

from synthdepth.maps.towers.panels import mitres, outward


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tier:
    """A prism of storeys.

    Attributes:
        polygon: (n, 2) float64 CCW [m].
        first: its lowest storey, 0 being the ground floor.
        last: the storey above its highest.
        street: (n,) bool, edges with windows all over.
        parapet_m: above its roof.
    """

    polygon: np.ndarray
    first: int
    last: int
    street: np.ndarray
    parapet_m: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Edges:
    """The walls of all tiers.

    Attributes:
        frames: (w, 4) x, y, dx, dy: where each starts and its direction.
        length_m: (w,).
        tier: (w,) int.
        street: (w,) bool.
    """

    frames: np.ndarray
    length_m: np.ndarray
    tier: np.ndarray
    street: np.ndarray


def inset(polygon: np.ndarray, by_m: np.ndarray) -> np.ndarray | None:
    """A CCW polygon (n, 2) with each edge moved in by `by_m` (n,); none where an edge would be
    shorter than 6 m or the polygon thinner than 9 m."""
    normal = outward(polygon)
    foot = polygon - by_m[:, None] * normal
    along = np.roll(polygon, -1, axis=0) - polygon
    before, at = np.roll(along, 1, axis=0), np.roll(foot, 1, axis=0)
    # Each corner: where the moved edge before it meets the moved edge after it.
    cross = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    if (np.abs(cross) < 1e-3).any():
        return None
    gap = foot - at
    t = (gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]) / cross
    corners = at + t[:, None] * before
    edge = np.roll(corners, -1, axis=0) - corners
    if ((edge * along).sum(1) <= 0).any() or np.linalg.norm(edge, axis=1).min() < 6.0:
        return None
    across = (corners[None] - corners[:, None]) @ outward(corners)[:, :, None]
    if (-across[..., 0]).max(axis=1).min() < 9.0:
        return None
    return corners


def draw_tiers(
    rng: np.random.Generator, footprint: np.ndarray, street: np.ndarray, storeys: int
) -> tuple[Tier, ...]:
    """Podium and setbacks of 2-6 m for the tall, a penthouse for some of the others."""
    cuts: list[int] = []
    if storeys >= 15:
        if rng.random() < 0.6:
            cuts.append(int(rng.integers(2, 7)))
        shares = np.sort(rng.uniform(0.45, 0.95, int(rng.integers(0 if cuts else 1, 4))))
        cuts += [round(s * storeys) for s in shares]
    elif storeys >= 8:
        if rng.random() < 0.45:
            cuts.append(storeys - int(rng.integers(1, 4)))
    elif storeys >= 4 and rng.random() < 0.25:
        cuts.append(storeys - 1)
    cuts = [c for c, d in zip(cuts, [0, *cuts], strict=False) if c - d >= 2 and c < storeys]
    tiers, polygon, first, open_sides = [], footprint, 0, street
    for cut in [*cuts, storeys]:
        tiers.append(
            Tier(
                polygon=polygon,
                first=first,
                last=cut,
                street=open_sides,
                parapet_m=float(rng.uniform(0.8, 1.3)),
            )
        )
        if cut == storeys:
            break
        by = rng.uniform(2.0, 6.0 if storeys >= 15 else 3.0) * rng.uniform(0.5, 1.2, len(polygon))
        smaller = inset(polygon, np.where(open_sides | (rng.random(len(polygon)) < 0.6), by, 0.0))
        if smaller is None:
            tiers[-1] = dataclasses.replace(tiers[-1], last=storeys)
            break
        moved = np.abs(((smaller - polygon) * outward(polygon)).sum(1)) > 0.1
        polygon, first, open_sides = smaller, cut, open_sides | moved
    return tuple(tiers)


def edges_of(tiers: tuple[Tier, ...]) -> Edges:
    """The walls of all tiers, tier by tier, edge by edge."""
    start = np.concatenate([t.polygon for t in tiers])
    stop = np.concatenate([np.roll(t.polygon, -1, axis=0) for t in tiers])
    length = np.linalg.norm(stop - start, axis=1)
    return Edges(
        frames=np.concatenate([start, (stop - start) / length[:, None]], axis=1),
        length_m=length,
        tier=np.repeat(np.arange(len(tiers)), [len(t.polygon) for t in tiers]),
        street=np.concatenate([t.street for t in tiers]),
    )


def grown(polygon: np.ndarray, by_m: float) -> np.ndarray:
    """A CCW polygon (n, 2) with every edge moved out by `by_m`; in where negative."""
    return polygon + by_m * mitres(polygon)
