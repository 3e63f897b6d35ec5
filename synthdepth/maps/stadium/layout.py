"""Sharing a site among the main ground, pitches, courts, car park, buildings and groves.

The site is a rectangle in its own frame. The main ground lies near its middle; the land around it
is cut again and again by straight lines (guillotine cuts), each piece of land taking the largest
thing that still fits and is wanted. Paths follow the cuts, trees and hedges fill what is left.
"""

import dataclasses

import numpy as np
import shapely


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plot:
    """A rectangle of land and what it is for.

    Attributes:
        kind: what stands there.
        centre: (2,) [m].
        size: (2,) along its own x and y [m].
        yaw_rad: of its own x: 0 or a quarter turn.
    """

    kind: str
    centre: np.ndarray
    size: np.ndarray
    yaw_rad: float

    @property
    def area(self) -> shapely.Polygon:
        """Its land in the site's frame."""
        size = self.size if abs(np.cos(self.yaw_rad)) > 0.5 else self.size[::-1]
        x, y = self.centre
        return shapely.box(x - size[0] / 2, y - size[1] / 2, x + size[0] / 2, y + size[1] / 2)


# Least and most size along x and y [m]; longer first.
SIZES = {
    "pitch": ((100, 62), (116, 78)),
    "small_pitch": ((62, 40), (78, 52)),
    "mini_pitch": ((44, 28), (54, 36)),
    "tennis": ((38, 36), (40, 71)),
    "cage": ((36, 21), (46, 28)),
    "basketball": ((33, 20), (37, 23)),
    "playground": ((24, 18), (38, 30)),
    "skate": ((28, 18), (36, 26)),
    "clubhouse": ((28, 20), (40, 26)),
    "yard": ((16, 14), (24, 20)),
    "grove": ((9, 7), (400, 400)),
}
_FILLERS = ("pitch", "small_pitch", "tennis", "mini_pitch", "cage", "basketball")
GAP_M = 6.5
_Rect = tuple[float, float, float, float]


def _fits(kind: str, w: float, h: float) -> bool:
    (a, b), _ = SIZES[kind]
    return (w >= a and h >= b) or (w >= b and h >= a)


def _placed(rng: np.random.Generator, kind: str, rect: _Rect) -> tuple[Plot, _Rect]:
    """A plot in one corner of the rectangle, and the rectangle that it takes there."""
    x0, y0, x1, y1 = rect
    w, h = x1 - x0, y1 - y0
    (a, b), (c, d) = SIZES[kind]
    upright = not (w >= a and h >= b) or (h >= a and w >= b and (h > w) == (rng.random() < 0.75))
    low, high = ((b, a), (d, c)) if upright else ((a, b), (c, d))
    size = np.array([min(w, rng.uniform(low[0], high[0])), min(h, rng.uniform(low[1], high[1]))])
    # What would be left over is too narrow for anything: take it.
    room = np.array([w, h])
    rest = room - size
    stretch = np.minimum(np.where(rest < 10, room, size), np.array(high, float) + 6)
    size = np.maximum(size, stretch)
    right, top = rng.random(2) < 0.5
    cx = x1 - size[0] / 2 if right else x0 + size[0] / 2
    cy = y1 - size[1] / 2 if top else y0 + size[1] / 2
    taken = (cx - size[0] / 2, cy - size[1] / 2, cx + size[0] / 2, cy + size[1] / 2)
    own = size[::-1] if upright else size
    yaw = np.pi / 2 if upright else 0.0
    if rng.random() < 0.5:
        yaw += np.pi
    return Plot(kind=kind, centre=np.array([cx, cy]), size=own, yaw_rad=float(yaw)), taken


def _rests(rng: np.random.Generator, rect: _Rect, taken: _Rect) -> list[_Rect]:
    """What a plot in a corner leaves, as two rectangles with a path's gap before them."""
    x0, y0, x1, y1 = rect
    a0, b0, a1, b1 = taken
    beside = (a1 + GAP_M, x1) if a0 - x0 < 0.01 else (x0, a0 - GAP_M)
    above = (b1 + GAP_M, y1) if b0 - y0 < 0.01 else (y0, b0 - GAP_M)
    w, h = beside[1] - beside[0], above[1] - above[0]
    # The cut runs so that the larger rest stays whole.
    if w * (y1 - y0) > h * (x1 - x0):
        rests = [
            (beside[0], y0, beside[1], y1),
            (min(a0, x0) if a0 - x0 < 0.01 else a0, above[0], a1, above[1]),
        ]
    else:
        rests = [(x0, above[0], x1, above[1]), (beside[0], b0, beside[1], b1)]
    return [r for r in rests if r[2] - r[0] > 5 and r[3] - r[1] > 5]


def _open_m2(rects: list[_Rect]) -> float:
    return sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in rects)


def fill(
    rng: np.random.Generator, rects: list[_Rect], wanted: list[str], grove_share: float
) -> list[Plot]:
    """Plots for as many of the wanted kinds as fit, in order, and groves for the rest.

    What is then left takes more pitches and courts, until groves have no more than their share.
    """
    plots, free = [], list(rects)
    todo, most = list(wanted), grove_share * _open_m2(rects)
    while todo or _open_m2(free) > most:
        more = [k for k in _FILLERS if any(_fits(k, r[2] - r[0], r[3] - r[1]) for r in free)]
        if not todo and not more:
            break
        # Small things would leave no room for large ones: of those that fit, the first mostly.
        kind = todo.pop(0) if todo else more[min(int(rng.exponential(0.9)), len(more) - 1)]
        able = [i for i, r in enumerate(free) if _fits(kind, r[2] - r[0], r[3] - r[1])]
        if not able:
            continue
        # The tightest of them, or now and then another.
        room = [(free[i][2] - free[i][0]) * (free[i][3] - free[i][1]) for i in able]
        order = np.argsort(room)
        pick = able[int(order[0 if rng.random() < 0.8 else rng.integers(len(order))])]
        rect = free.pop(pick)
        plot, taken = _placed(rng, kind, rect)
        plots.append(plot)
        free += _rests(rng, rect, taken)
    for x0, y0, x1, y1 in free:
        plots.append(
            Plot(
                kind="grove",
                centre=np.array([(x0 + x1) / 2, (y0 + y1) / 2]),
                size=np.array([x1 - x0, y1 - y0]),
                yaw_rad=0.0,
            )
        )
    return plots


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """A site's plan, in its own frame.

    Attributes:
        half_m: (2,) half sizes of the site.
        arena_at: (2,) middle of the main ground.
        plots: everything else.
        drives: ways from the street to the car park, (4, 2) each.
        paths: area of the ways.
    """

    half_m: np.ndarray
    arena_at: np.ndarray
    plots: list[Plot]
    drives: list[np.ndarray]
    paths: shapely.Geometry


def draw_layout(
    rng: np.random.Generator,
    half_m,
    arena_half_m,
    wanted: list[str],
    parking_m: float,
    path_m: float,
    grove_share: float,
) -> Layout:
    """Share a site.

    Args:
        rng: of all choices.
        half_m: (2,) half sizes of the site.
        arena_half_m: (2,) half sizes of the main ground.
        wanted: kinds of plots, most wanted first.
        parking_m: depth of the car park along the site's lower edge.
        path_m: width of the paths.
        grove_share: most of the land beside the main ground that groves take.
    """
    half, arena = np.asarray(half_m, float), np.asarray(arena_half_m, float)
    edge = 6.0  # a belt of hedge and trees along the street
    low, high = -half + edge, half - edge
    park_top = low[1] + parking_m
    spare = np.maximum(np.array([high[0] - low[0], high[1] - park_top - GAP_M]) - 2 * arena, 0)
    middle = np.array([0.0, (park_top + GAP_M + high[1]) / 2])
    at = middle + rng.uniform(-0.5, 0.5, 2) * np.minimum(spare, [30.0, 24.0])
    # The arena stays over the middle of the flights, too.
    at[1] = np.clip(at[1], park_top + GAP_M + arena[1], high[1] - arena[1])
    ax0, ay0, ax1, ay1 = *(at - arena), *(at + arena)
    length = float(np.clip(rng.uniform(0.45, 0.8) * (high[0] - low[0]), 60, 260))
    px0 = rng.uniform(low[0], high[0] - length)
    plots = [
        Plot(
            kind="parking",
            centre=np.array([px0 + length / 2, low[1] + parking_m / 2]),
            size=np.array([length, parking_m]),
            yaw_rad=0.0,
        )
    ]
    rects = [
        (low[0], low[1], px0 - GAP_M, park_top),
        (px0 + length + GAP_M, low[1], high[0], park_top),
    ]
    y0 = park_top + GAP_M
    if rng.random() < 0.5:  # the strips left and right of the arena run the whole way
        rects += [(low[0], y0, ax0 - GAP_M, high[1]), (ax1 + GAP_M, y0, high[0], high[1])]
        rects += [(ax0, ay1 + GAP_M, ax1, high[1]), (ax0, y0, ax1, ay0 - GAP_M)]
    else:
        rects += [(low[0], ay1 + GAP_M, high[0], high[1]), (low[0], y0, high[0], ay0 - GAP_M)]
        rects += [(low[0], ay0, ax0 - GAP_M, ay1), (ax1 + GAP_M, ay0, high[0], ay1)]
    rects = [r for r in rects if r[2] - r[0] > 6 and r[3] - r[1] > 6]
    plots += fill(rng, rects, wanted, grove_share)
    # Ways: rings around the arena and the larger plots, and the drive.
    ring = shapely.box(ax0, ay0, ax1, ay1).buffer(0.3 * GAP_M, join_style="mitre").exterior
    lines = [ring]
    for plot in plots:
        if plot.kind not in ("grove", "parking") and rng.random() < 0.75:
            outline = plot.area.buffer(0.3 * GAP_M, join_style="mitre").exterior
            corners = shapely.get_coordinates(outline)
            start = int(rng.integers(4))
            order = np.arange(start, start + int(rng.integers(2, 5))) % 4
            lines.append(shapely.LineString(corners[order]))
    inner = shapely.box(*(low - 2), *(high + 2))
    lines = [shapely.intersection(line, inner) for line in lines]
    drives = []
    for x in (px0 + 0.18 * length, px0 + 0.85 * length):
        drives.append(
            np.array(
                [
                    [x - 3.2, -half[1] - 12],
                    [x + 3.2, -half[1] - 12],
                    [x + 3.2, low[1] + 0.2],
                    [x - 3.2, low[1] + 0.2],
                ]
            )
        )
    gate = float(np.clip(rng.uniform(ax0, ax1), px0, px0 + length))
    lines.append(shapely.LineString([(gate, park_top - 0.5), (gate, ay0 - 1)]))
    paths = shapely.union_all(
        shapely.buffer(lines, path_m / 2, join_style="mitre", cap_style="square")
    )
    return Layout(half_m=half, arena_at=at, plots=plots, drives=drives, paths=paths)
