"""Stands: stepped terraces with seats in coloured blocks, stairs, mouths and railings.

Frame: x along the stand, the pitch towards -y; the origin is below the middle of its front.
"""

import dataclasses
import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import Geometry, Model, box, copies, join, merge, quads
from synthdepth.maps.stadium.roofs import Roof, draw_roof, stand_roof

SEAT_M = 0.5
STAIR_M = 1.2
_STEEL = (0.3, 0.31, 0.32)
_MOUTH_M = 2.6
_SEAT_COLOURS = (
    (0.03, 0.06, 0.24), (0.28, 0.025, 0.03), (0.02, 0.12, 0.05), (0.5, 0.36, 0.03),
    (0.55, 0.55, 0.53), (0.08, 0.085, 0.09), (0.1, 0.22, 0.38), (0.36, 0.1, 0.02),
    (0.12, 0.02, 0.05),
)  # fmt: skip


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stand:
    """One stand; lengths in metres.

    Attributes:
        length_m: along the pitch.
        rows: of seats.
        tread_m, riser_m: of a step.
        front_m: height of the lowest step.
        seating: "seats", "benches" or "standing".
        colours: (2, 3) linear reflectances of the seats.
        pattern: "plain", "blocks", "bands", "diagonal" or "chequers".
        mouths: x of the openings that lead in below the seats.
        stairs: x of the stairs' middles.
        roof: the roof, or none.
        clad: (3,) tint of the sheets on its back.
    """

    length_m: float
    rows: int
    tread_m: float
    riser_m: float
    front_m: float
    seating: str
    colours: np.ndarray
    pattern: str
    mouths: np.ndarray
    stairs: np.ndarray
    roof: Roof | None
    clad: np.ndarray

    @property
    def depth_m(self) -> float:
        """From the front wall to the back wall."""
        return self.rows * self.tread_m + 1.2

    @property
    def top_m(self) -> float:
        """Height of the uppermost step."""
        return self.front_m + self.rows * self.riser_m


def club_colours(rng: np.random.Generator) -> np.ndarray:
    """Two colours (2, 3) of a club, linear reflectances."""
    pick = rng.permutation(len(_SEAT_COLOURS))[:2]
    return np.array(_SEAT_COLOURS)[pick]


def draw_stand(
    rng: np.random.Generator, length_m: float, rows: int, covered: bool, colours: np.ndarray
) -> Stand:
    """A stand of about a length for a number of rows."""
    large = rows >= 9
    count = max(round(length_m / rng.uniform(8.5, 13.0)), 1)
    stairs = (np.arange(count + 1) / count - 0.5) * (length_m - STAIR_M - 0.3)
    mouths = np.zeros(0)
    if rows >= 11:
        middle = (stairs[1:] + stairs[:-1]) / 2
        mouths = middle[rng.integers(2) :: 2]
    seating = "seats" if large else str(rng.choice(["seats", "benches", "standing"]))
    front = rng.uniform(1.0, 1.6) if large else rng.uniform(0.25, 0.6)
    tread, riser = rng.uniform(0.76, 0.86), rng.uniform(0.36, 0.46) if large else 0.3
    back = front + rows * riser
    shades = [(0.4, 0.41, 0.42), (0.55, 0.55, 0.53), (0.2, 0.22, 0.24), colours[0] * 0.8 + 0.05]
    return Stand(
        length_m=length_m,
        rows=rows,
        tread_m=float(tread),
        riser_m=float(riser),
        front_m=float(front),
        seating=seating,
        colours=colours if rng.random() < 0.75 else np.stack([colours[0], np.full(3, 0.5)]),
        pattern=str(rng.choice(["plain", "blocks", "bands", "diagonal", "chequers"])),
        mouths=mouths,
        stairs=stairs,
        roof=draw_roof(rng, length_m, rows * tread + 1.2, back, large) if covered else None,
        clad=np.asarray(shades[rng.integers(4)]) * rng.uniform(0.85, 1.1),
    )


def _mouth_rows(stand: Stand) -> tuple[int, int]:
    """First row that a mouth takes, and the one after its last."""
    return 3, min(3 + int(np.ceil(2.3 / stand.riser_m)), stand.rows - 2)


def _terrace(stand: Stand) -> Geometry:
    """Treads, risers, ends and the lining of the mouths, in concrete."""
    half = stand.length_m / 2
    low, high = _mouth_rows(stand)
    edges = np.concatenate(
        [
            [-half],
            np.sort(np.concatenate([stand.mouths - _MOUTH_M / 2, stand.mouths + _MOUTH_M / 2])),
            [half],
        ]
    )
    corners = []
    cuts = np.arange(-half, half + 1, stand.length_m / max(round(stand.length_m / 24), 1))
    for row in range(stand.rows + 1):
        y, z = row * stand.tread_m, stand.front_m + row * stand.riser_m
        wide = stand.tread_m if row < stand.rows else 1.2
        spans = edges if low <= row < high and len(stand.mouths) else np.array([-half, half])
        for a, b in spans.reshape(-1, 2):
            inner = cuts[(cuts > a + 0.5) & (cuts < b - 0.5)]
            x = np.concatenate([[a], inner, [b]])
            x0, x1 = x[:-1], x[1:]
            o = np.ones_like(x0)
            foot = z - stand.riser_m if row else -0.15
            for ya, za, yb, zb in ((y, foot, y, z), (y, z, y + wide, z)):
                corners.append(
                    np.stack(
                        [
                            np.stack([x0, ya * o, za * o], 1), np.stack([x1, ya * o, za * o], 1),
                            np.stack([x1, yb * o, zb * o], 1), np.stack([x0, yb * o, zb * o], 1),
                        ],
                        axis=1,
                    )
                )  # fmt: skip
        ends = [-half, half]
        for x in ends:
            corners.append(
                np.array([[[x, y, -0.15], [x, y + wide, -0.15], [x, y + wide, z], [x, y, z]]])
            )
    floor = stand.front_m + low * stand.riser_m - 0.02
    ya, yb = low * stand.tread_m, high * stand.tread_m
    top = stand.front_m + high * stand.riser_m
    for x in stand.mouths:
        a, b = x - _MOUTH_M / 2, x + _MOUTH_M / 2
        lining = [
            [[a, ya, floor], [b, ya, floor], [b, yb, floor], [a, yb, floor]],
            [[a, yb, floor], [b, yb, floor], [b, yb, top], [a, yb, top]],
            [[a, ya, floor], [a, yb, floor], [a, yb, top], [a, ya, floor + 0.9]],
            [[b, yb, floor], [b, ya, floor], [b, ya, floor + 0.9], [b, yb, top]],
        ]
        corners.append(np.array(lining))
    y = stand.rows * stand.tread_m + 1.2
    corners.append(
        np.array(
            [[[half, y, -0.15], [-half, y, -0.15], [-half, y, stand.top_m], [half, y, stand.top_m]]]
        )
    )
    return quads(np.concatenate(corners))


def _steps(stand: Stand) -> Geometry:
    """Half steps in the stairs."""
    row = np.arange(stand.rows)
    x, r = np.meshgrid(stand.stairs, row, indexing="ij")
    x, r = x.ravel(), r.ravel()
    at = np.column_stack(
        [x, (r + 1) * stand.tread_m - 0.15, stand.front_m + r * stand.riser_m - 0.01]
    )
    return copies(box((STAIR_M - 0.1, 0.3, stand.riser_m / 2 + 0.01)), at)


def seats(stand: Stand) -> tuple[np.ndarray, np.ndarray]:
    """Places of people (k, 3) on the steps, and the row of each."""
    half = stand.length_m / 2 - 0.5
    x = np.arange(-half, half + 1e-6, SEAT_M)
    x = x[np.abs(x[:, None] - stand.stairs).min(axis=1) > STAIR_M / 2 + SEAT_M / 2]
    row, x = np.meshgrid(np.arange(stand.rows), x, indexing="ij")
    row, x = row.ravel(), x.ravel()
    if len(stand.mouths):
        low, high = _mouth_rows(stand)
        beside = np.abs(x[:, None] - stand.mouths).min(axis=1) > _MOUTH_M / 2 + 0.5
        keep = beside | (row < low - 1) | (row > high)
        row, x = row[keep], x[keep]
    y = row * stand.tread_m + 0.5 * stand.tread_m
    return np.column_stack([x, y, stand.front_m + row * stand.riser_m]), row


def _seat_tints(rng: np.random.Generator, stand: Stand, at: np.ndarray, row) -> np.ndarray:
    x = at[:, 0] + stand.length_m / 2
    block = np.searchsorted(stand.stairs, at[:, 0])
    second = {
        "plain": np.zeros(len(at), bool),
        "blocks": block % 2 == 1,
        "bands": row % 6 >= 4,
        "diagonal": (x / SEAT_M + 1.5 * row) % 30 < 8,
        "chequers": ((x // 6).astype(int) + row // 4) % 2 == 1,
    }[stand.pattern]
    tint = np.where(second[:, None], stand.colours[1], stand.colours[0])
    # Plastic bleaches in the sun, seat by seat.
    faded = rng.uniform(0, 0.25, (len(at), 1)) * (1 - row[:, None] / (stand.rows + 4))
    return (tint * (1 - faded) + 0.3 * faded) * rng.uniform(0.88, 1.08, (len(at), 1))


def _seat() -> Geometry:
    """A shell seat that looks towards -y: back and seat pan, 10 triangles."""
    w, d = 0.21, 0.2
    pan = [[-w, -d, 0.43], [w, -d, 0.43], [w, d - 0.02, 0.4], [-w, d - 0.02, 0.4]]
    lip = [[-w, -d, 0.36], [w, -d, 0.36], [w, -d, 0.43], [-w, -d, 0.43]]
    back = [[-w, d - 0.02, 0.4], [w, d - 0.02, 0.4], [w, d + 0.06, 0.76], [-w, d + 0.06, 0.76]]
    rear = [[w, d + 0.03, 0.38], [-w, d + 0.03, 0.38], [-w, d + 0.09, 0.76], [w, d + 0.09, 0.76]]
    top = [back[3], back[2], rear[3], rear[2]]
    return quads(np.array([pan, lip, back, rear, top]))


def _seating(rng: np.random.Generator, stand: Stand) -> Model:
    at, row = seats(stand)
    if stand.seating == "seats":
        kept = rng.random(len(at)) > 0.008
        tint = _seat_tints(rng, stand, at, row)
        post = beams(at[kept] + [0, 0.16, 0.0], at[kept] + [0, 0.16, 0.4], 0.05, 0.05)
        thin = copies(_seat(), at[kept], tint=tint[kept])
        # Two faces of four of each post can be seen between the rows.
        return {
            ("paint", "obstacle"): join([thin, post.tinted(_STEEL)]) if len(at) < 2500 else thin
        }
    if stand.seating == "benches":
        ends = np.sort(np.concatenate([stand.stairs - STAIR_M / 2, stand.stairs + STAIR_M / 2]))[
            1:-1
        ]
        a, b = ends[0::2], ends[1::2]
        r = np.arange(stand.rows)
        y, z = (r + 0.55) * stand.tread_m, stand.front_m + r * stand.riser_m
        start = np.stack(
            [np.stack(np.broadcast_arrays(a[:, None], y + dy, z + 0.42), -1) for dy in (-0.1, 0.08)]
        ).reshape(-1, 3)
        end = start.copy()
        end[:, 0] = np.tile(np.repeat(b, stand.rows), 2)
        plank = beams(start, end, 0.15, 0.04, stand.colours[0] * 0.6 + [0.1, 0.08, 0.05])
        n = max(int((b - a).max() / 1.6), 1)
        t = (np.arange(n + 1) / n)[:, None]
        legs = (start[None] * (1 - t[..., None]) + end[None] * t[..., None]).reshape(-1, 3)
        legs = beams(legs - [0, 0, 0.42], legs - [0, 0, 0.02], 0.06, 0.05, _STEEL)
        return {("wood", "obstacle"): plank, ("paint", "obstacle"): legs}
    # Crush barriers on every third step.
    r = np.arange(1, stand.rows, 3)
    x = np.arange(-stand.length_m / 2 + 2.5, stand.length_m / 2 - 2, 4.4)
    x, r = (v.ravel() for v in np.meshgrid(x, r))
    x = x + 1.1 * (r % 2)
    foot = np.column_stack([x, r * stand.tread_m + 0.1, stand.front_m + r * stand.riser_m])
    return {("paint", "barrier"): _hoops(foot, 2.6, 1.1, stand.colours[0])}


def _hoops(foot: np.ndarray, wide: float, high: float, tint) -> Geometry:
    """Hooped rails (k) whose middles stand at `foot` (k, 3)."""
    w, up = np.array([wide / 2, 0, 0]), np.array([0, 0, high])
    a = np.concatenate([foot - w, foot + w, foot - w + up, foot - w + 0.5 * up])
    b = np.concatenate([foot - w + up, foot + w + up, foot + w + up, foot + w + 0.5 * up])
    return round_bars(a, b, 0.024, tint, 5)


def railing(path: np.ndarray, high: float, tint, spacing: float = 1.8, bars: int = 2) -> Geometry:
    """Posts and tubes along a polyline (k, 3) [m]."""
    path = np.asarray(path, np.float64)
    posts, a, b = [], [], []
    for p, q in itertools.pairwise(path):
        n = max(round(np.linalg.norm(q - p) / spacing), 1)
        posts.append(p + (np.arange(n + 1) / n)[:, None] * (q - p))
        for k in range(1, bars + 1):
            a.append(p + [0, 0, high * k / bars])
            b.append(q + [0, 0, high * k / bars])
    foot = np.concatenate(posts)
    return join(
        [
            round_bars(foot - [0, 0, 0.05], foot + [0, 0, high], 0.024, tint, 5),
            round_bars(np.array(a), np.array(b), 0.022, tint, 5),
        ]
    )


def _railings(stand: Stand) -> Geometry:
    half, rows = stand.length_m / 2, stand.rows
    front = np.array([[-half, 0.06, stand.front_m], [half, 0.06, stand.front_m]])
    parts = [railing(front, 1.0, _STEEL)]
    for x in (-half + 0.05, half - 0.05):
        ends = [[x, 0.06, stand.front_m], [x, rows * stand.tread_m, stand.top_m]]
        parts.append(railing(np.array([*ends, [x, stand.depth_m, stand.top_m]]), 1.05, _STEEL))
    if stand.roof is None:
        y = stand.depth_m - 0.06
        back = np.array([[-half, y, stand.top_m], [half, y, stand.top_m]])
        parts.append(railing(back, 1.1, _STEEL, bars=3))
    if rows >= 8:
        inner = stand.stairs[1:-1]
        r = np.arange(1, rows - 1, 2)
        x, r = (v.ravel() for v in np.meshgrid(inner, r))
        foot = np.column_stack([x, (r + 0.3) * stand.tread_m, stand.front_m + r * stand.riser_m])
        head = foot + [0, stand.tread_m, stand.riser_m + 0.9]
        parts.append(round_bars(foot, foot + [0, 0, 0.9], 0.022, _STEEL, 4))
        parts.append(round_bars(foot + [0, 0, 0.9], head, 0.022, _STEEL, 4))
    low, high = _mouth_rows(stand)
    for x in stand.mouths:
        a, b = x - _MOUTH_M / 2, x + _MOUTH_M / 2
        y0, y1 = (low + 0.1) * stand.tread_m, (high + 0.1) * stand.tread_m
        z0, z1 = stand.front_m + low * stand.riser_m, stand.front_m + high * stand.riser_m
        path = np.array([[a, y0, z0], [a, y1, z1], [b, y1, z1], [b, y0, z0]])
        parts.append(railing(path, 1.0, _STEEL))
    return join(parts)


def _back(rng: np.random.Generator, stand: Stand) -> Model:
    """What the town sees: sheets, doors, windows and a fascia."""
    half, y = stand.length_m / 2, stand.depth_m + 0.12
    top = stand.roof.back_m if stand.roof is not None else stand.top_m
    low = min(2.6, 0.55 * stand.top_m)
    n = max(round(stand.length_m / 12), 1)
    x = np.linspace(half, -half, n + 1)
    sheet = [[[a, y, low], [b, y, low], [b, y, top], [a, y, top]] for a, b in itertools.pairwise(x)]
    if stand.roof is not None:
        # Its inner side, above the last row.
        sheet += [
            [
                [b, y - 0.1, stand.top_m],
                [a, y - 0.1, stand.top_m],
                [a, y - 0.1, top],
                [b, y - 0.1, top],
            ]
            for a, b in itertools.pairwise(x)
        ]
    model = {("sheeting", "building"): quads(np.array(sheet), stand.clad)}
    if stand.top_m < 3:
        return model
    middle = (x[:-1] + x[1:]) / 2
    use = rng.integers(3, size=n)
    doors, frames, panes = [], [], []
    for at, kind in zip(middle, use, strict=True):
        if kind == 0:
            doors.append(box((rng.uniform(2.0, 3.4), 0.08, 2.3), (at, y, -0.05)))
        elif kind == 1:
            for dx in (-2.2, 0.0, 2.2):
                frames.append(box((1.7, 0.1, 1.2), (at + dx, y, 0.95)))
                a, b = at + dx + 0.78, at + dx - 0.78
                panes.append(
                    [
                        [a, y + 0.06, 1.02],
                        [b, y + 0.06, 1.02],
                        [b, y + 0.06, 2.08],
                        [a, y + 0.06, 2.08],
                    ]
                )
        else:
            doors.append(box((1.1, 0.08, 2.1), (at + rng.uniform(-3, 3), y, -0.05)))
    if doors:
        model["paint", "building"] = join(doors).tinted(stand.colours[0] * 0.7 + 0.03)
    if frames:
        trim = join(frames).tinted((0.35, 0.35, 0.34))
        model["paint", "building"] = (
            join([model.get(("paint", "building"), trim), trim]) if doors else trim
        )
        model["glass", "building"] = quads(np.array(panes))
    return model


def _dark_mouths(stand: Stand) -> Model:
    """The ways on, below the seats, too dark to see into."""
    low, high = _mouth_rows(stand)
    floor = stand.front_m + low * stand.riser_m
    y = high * stand.tread_m - 0.012
    a, b = stand.mouths - _MOUTH_M / 2 + 0.25, stand.mouths + _MOUTH_M / 2 - 0.25
    outline = ((a, floor), (b, floor), (b, floor + 2.1), (a, floor + 2.1))
    corners = np.stack([np.column_stack([x, 0 * x + y, 0 * x + z]) for x, z in outline], axis=1)
    return {("paint", "building"): quads(corners, (0.012, 0.012, 0.013))}


def stand_model(rng: np.random.Generator, stand: Stand) -> Model:
    """Build a stand."""
    models = [
        {("concrete", "building"): join([_terrace(stand), _steps(stand)])},
        _seating(rng, stand),
        {("paint", "barrier"): _railings(stand)},
        _back(rng, stand),
    ]
    if len(stand.mouths):
        models.append(_dark_mouths(stand))
    if stand.roof is not None:
        models.append(stand_roof(stand.roof, stand.colours[0]))
    return merge(models)
