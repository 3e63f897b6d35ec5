"""Roofs over rectangles: gable, hip, shed, slab and parapet, with eaves, fascia and gutters.

Roofs of adjoining rectangles simply pass into each other, which makes the valleys.
"""

import dataclasses
import math

import numpy as np

from synthdepth.maps.geometry import cross
from synthdepth.maps.houses.facets import Facets

# Top of the covering above the wall plate, and height of fascia and rake boards [m]: the boards
# reach a little below the plate, so that no light passes over the wall.
_COVER, _BOARD = 0.16, 0.22
_PARAPET_THICK = 0.22
FORMS = ("gable", "hip", "shed", "slab", "parapet")

Rect = tuple[float, float, float, float]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Roof:
    """A roof over a rectangle (x0, y0, x1, y1).

    Attributes:
        form: one of FORMS. A shed roof rises towards the left of its ridge axis.
        ridge: "x" or "y", the axis that the ridge follows; the longer one under a hip roof.
        pitch_deg: slope; 0 for slab and parapet.
        eaves_m: overhang at the eaves.
        rake_m: overhang at gable ends.
        ends: (low, high) along the ridge: "gable", "hip" or "inner" (within another roof).
        parapet_m: height of the parapet.
        ribbed: standing seams.
        capped: ridge and hip caps.
    """

    form: str
    ridge: str = "x"
    pitch_deg: float = 0.0
    eaves_m: float = 0.4
    rake_m: float = 0.3
    ends: tuple[str, str] = ("gable", "gable")
    parapet_m: float = 0.4
    ribbed: bool = False
    capped: bool = True

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise ValueError(f"roof form {self.form!r} is not one of {FORMS}")


def _local(rect: Rect, ridge: str) -> tuple[float, float, float, float]:
    """a0, a1 along the ridge and b0, b1 across it, a right-handed turn of x and y."""
    x0, y0, x1, y1 = rect
    return (x0, x1, y0, y1) if ridge == "x" else (y0, y1, -x1, -x0)


def _insets(roof: Roof, a0, a1, half) -> tuple[float, float]:
    """Run of the hips at both ends: how far the ridge stops short."""
    hip = [(roof.form == "hip" and end != "inner") or end == "hip" for end in roof.ends]
    room = (a1 - a0) / max(1, sum(hip))
    return tuple(min(half, room) if h else 0.0 for h in hip)


def roof_height(rect: Rect, plate_m: float, roof: Roof, x: float, y: float) -> float:
    """Height of the covering [m] above the point (x, y)."""
    if roof.form in ("slab", "parapet"):
        return plate_m + (0.24 if roof.form == "slab" else 0.0)
    a0, a1, b0, b1 = _local(rect, roof.ridge)
    a, b = (x, y) if roof.ridge == "x" else (y, -x)
    tan = math.tan(math.radians(roof.pitch_deg))
    if roof.form == "shed":
        return plate_m + _COVER + (b - b0) * tan
    half = (b1 - b0) / 2
    low, high = _insets(roof, a0, a1, half)
    run = half - abs(b - (b0 + b1) / 2)
    if low:
        run = min(run, (a - a0) * half / low)
    if high:
        run = min(run, (a1 - a) * half / high)
    return plate_m + _COVER + run * tan


def ridge_height(rect: Rect, plate_m: float, roof: Roof) -> float:
    """Height of the highest line [m]."""
    return roof_height(rect, plate_m, roof, (rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2)


def add_roof(
    facets: Facets,
    rect: Rect,
    plate_m: float,
    roof: Roof,
    cover: tuple[str, tuple],
    trim,
    gutter,
    wall: tuple[str, tuple],
    detail: int = 1,
) -> None:
    """Add one roof.

    Args:
        facets: where to.
        rect: outer faces of the walls [m].
        plate_m: top of the walls.
        roof: the roof.
        cover: (material, tint) of the covering.
        trim: tint of fascia and rake boards, or of the coping.
        gutter: tint of gutters, or None for no gutters.
        wall: (material, tint) of gable walls or of the parapet.
        detail: 1 or 0, which leaves out undersides, gutters, caps and seams.
    """
    if roof.form == "parapet":
        _parapet(facets, rect, plate_m, roof, cover, trim, wall)
    elif roof.form == "slab":
        x0, y0, x1, y1 = rect
        o = roof.eaves_m
        low, high = (x0 - o, y0 - o, plate_m - 0.02), (x1 + o, y1 + o, plate_m + 0.22)
        facets.box(("paint", "roof"), trim, low, high)
        # The membrane lies within a low metal edge.
        low = (x0 - o + 0.08, y0 - o + 0.08, plate_m + 0.1)
        facets.box(
            (cover[0], "roof"), cover[1], low, (x1 + o - 0.08, y1 + o - 0.08, plate_m + 0.24)
        )
    else:
        _pitched(facets, rect, plate_m, roof, cover, trim, gutter, wall, detail)


def _parapet(facets, rect, plate, roof, cover, trim, wall) -> None:
    x0, y0, x1, y1 = rect
    t, top = _PARAPET_THICK, plate + roof.parapet_m
    i = (x0 + t, y0 + t, x1 - t, y1 - t)
    corners = [(i[0], i[1]), (i[2], i[1]), (i[2], i[3]), (i[0], i[3])]
    facets.quad((cover[0], "roof"), cover[1], *[(x, y, plate) for x, y in corners])
    outer = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    for k in range(4):
        (ax, ay), (bx, by) = corners[k], corners[(k + 1) % 4]
        inside = ((bx, by, plate), (ax, ay, plate), (ax, ay, top), (bx, by, top))
        facets.quad((wall[0], "building"), wall[1], *inside)
        (ax, ay), (bx, by) = outer[k], outer[(k + 1) % 4]
        face = ((ax, ay, plate), (bx, by, plate), (bx, by, top), (ax, ay, top))
        facets.quad((wall[0], "building"), wall[1], *face)
    o, low, high = 0.03, top - 0.03, top + 0.04
    key = ("paint", "roof")
    facets.box(key, trim, (x0 - o, y0 - o, low), (x1 + o, i[1] + o, high))
    facets.box(key, trim, (x0 - o, i[3] - o, low), (x1 + o, y1 + o, high))
    facets.box(key, trim, (x0 - o, i[1] + o, low), (i[0] + o, i[3] - o, high))
    facets.box(key, trim, (i[2] - o, i[1] + o, low), (x1 + o, i[3] - o, high))


def _pitched(facets, rect, plate, roof, cover, trim, gutter, wall, detail) -> None:
    a0, a1, b0, b1 = _local(rect, roof.ridge)
    tan = math.tan(math.radians(roof.pitch_deg))
    o, shed = roof.eaves_m, roof.form == "shed"
    half = (b1 - b0) if shed else (b1 - b0) / 2
    insets = (0.0, 0.0) if shed else _insets(roof, a0 - o, a1 + o, half + o)
    over = [
        o if inset else (0.0 if end == "inner" else roof.rake_m)
        for inset, end in zip(insets, roof.ends, strict=True)
    ]
    l0, l1 = a0 - over[0], a1 + over[1]
    r0, r1 = l0 + insets[0], l1 - insets[1]
    eave = plate + _COVER - o * tan
    top = plate + _COVER + half * tan
    c0, c1, mid = b0 - o, b1 + o, (b0 + b1) / 2
    along_x = roof.ridge == "x"
    roof_key, board_key, wall_key = (cover[0], "roof"), ("paint", "roof"), (wall[0], "building")

    def at(a, b, z):
        return (a, b, z) if along_x else (-b, a, z)

    slopes = []
    if shed:
        # One slope from the low eave to the high one, which is a board too.
        high = plate + _COVER + (half + o) * tan
        slopes.append((at(l0, c0, eave), at(l1, c0, eave), at(l1, c1, high), at(l0, c1, high)))
        eaves = [(at(l0, c0, eave), at(l1, c0, eave)), (at(l1, c1, high), at(l0, c1, high))]
        rakes = [
            (at(l0, c1, high), at(l0, c0, eave)),
            (at(l1, c0, eave), at(l1, c1, high)),
        ]
        rise = plate + half * tan
        for a, first, second in ((a0, b1, b0), (a1, b0, b1)):
            peak = at(a, b1, rise)
            facets.quad(wall_key, wall[1], at(a, first, plate), at(a, second, plate), peak, peak)
        back = (at(a1, b1, plate), at(a0, b1, plate), at(a0, b1, rise), at(a1, b1, rise))
        facets.quad(wall_key, wall[1], *back)
    else:
        p0, p1 = at(r0, mid, top), at(r1, mid, top)
        front = (at(l0, c0, eave), at(l1, c0, eave))
        rear = (at(l1, c1, eave), at(l0, c1, eave))
        slopes += [(*front, p1, p0), (*rear, p0, p1)]
        eaves, rakes = [front, rear], []
        rise = plate + half * tan
        for low, inset, peak in ((True, insets[0], p0), (False, insets[1], p1)):
            side = (rear[1], front[0]) if low else (front[1], rear[0])
            if inset:
                slopes.append((*side, peak, peak))
                eaves.append(side)
                continue
            rakes += [(side[0], peak), (peak, side[1])]
            a, first, second = (a0, b1, b0) if low else (a1, b0, b1)
            if roof.ends[not low] == "inner":
                # Off the rake boards, which stand over the wall itself here.
                a += 0.03 if low else -0.03
            point = at(a, mid, rise)
            facets.quad(wall_key, wall[1], at(a, first, plate), at(a, second, plate), point, point)

    def lower(p, by=_BOARD):
        return (p[0], p[1], p[2] - by)

    for number, (a, b, c, d) in enumerate(slopes):
        # Sun, rain and age differ by exposure.
        shade = 1.0 - 0.04 * (number % 2)
        facets.quad(roof_key, [shade * t for t in cover[1]], a, b, c, d)
        if detail:
            under = (lower(b), lower(a), lower(d), lower(c))
            facets.quad(board_key, [0.8 * t for t in trim], *under)
    for a, b in eaves + rakes:
        facets.quad(board_key, trim, lower(a), lower(b), b, a)
    if not detail:
        return
    if gutter is not None:
        for a, b in eaves[: 1 if shed else None]:
            _gutter(facets, a, b, gutter)
    if roof.capped and not shed:
        _caps(facets, roof_key, cover[1], p0, p1, front, rear, insets, along_x, tan)
    if roof.ribbed and not any(insets):
        _seams(facets, roof_key, cover[1], slopes[: 1 if shed else 2])


def _gutter(facets, a, b, tint) -> None:
    """A channel of sheet, open above, 11 cm wide, along the eave from a to b."""
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    ox, oy = 0.11 * (b[1] - a[1]) / length, 0.11 * (a[0] - b[0]) / length
    low, high = a[2] - 0.13, a[2] - 0.03
    key = ("paint", "roof")
    foot = [(a[0] + ox, a[1] + oy), (b[0] + ox, b[1] + oy)]
    (px, py), (qx, qy) = foot
    facets.quad(key, tint, (px, py, low), (qx, qy, low), (qx, qy, high), (px, py, high))
    dark = [0.5 * t for t in tint]
    facets.quad(key, dark, (b[0], b[1], low), (a[0], a[1], low), (px, py, low), (qx, qy, low))
    for (ex, ey), (fx, fy) in (((a[0], a[1]), (px, py)), ((qx, qy), (b[0], b[1]))):
        facets.quad(key, tint, (ex, ey, low), (fx, fy, low), (fx, fy, high), (ex, ey, high))


def _caps(facets, key, tint, p0, p1, front, rear, insets, along_x, tan) -> None:
    """Ridge and hip caps, 4 cm high, their feet 5 mm within the covering."""
    width, rise = 0.15, 0.04
    axis = (1.0, 0.0) if along_x else (0.0, 1.0)
    across = (0.0, 1.0) if along_x else (-1.0, 0.0)
    drop = width * tan + 0.005
    shade = [0.92 * t for t in tint]

    def shift(p, d, by, dz):
        return (p[0] + d[0] * by, p[1] + d[1] * by, p[2] + dz)

    # Caps end a little outside the rake boards.
    p0, p1 = (
        shift(p, axis, 0.0 if inset else by, 0.0)
        for p, inset, by in ((p0, insets[0], -0.01), (p1, insets[1], 0.01))
    )
    up0, up1 = shift(p0, axis, 0, rise), shift(p1, axis, 0, rise)
    if p0 != p1:
        near = (shift(p0, across, -width, -drop), shift(p1, across, -width, -drop))
        far = (shift(p1, across, width, -drop), shift(p0, across, width, -drop))
        facets.quad(key, shade, *near, up1, up0)
        facets.quad(key, shade, *far, up0, up1)
        if not insets[0]:
            facets.quad(key, shade, far[1], near[0], up0, up0)
        if not insets[1]:
            facets.quad(key, shade, near[1], far[0], up1, up1)
    for inset, peak, sign, (left, right) in (
        (insets[0], p0, 1, (front[0], rear[1])),
        (insets[1], p1, -1, (front[1], rear[0])),
    ):
        if not inset:
            continue
        for corner, inward in ((left, 1), (right, -1)):
            foot, crest = shift(corner, axis, 0, rise), shift(peak, axis, 0, rise)
            # Level with the hip on either slope: along the ridge on the long one, across it on
            # the hipped end.
            on_long = [shift(p, axis, sign * width, -0.005) for p in (corner, peak)]
            on_end = [shift(p, across, inward * width, -0.005) for p in (corner, peak)]
            first = (on_long[0], foot, crest, on_long[1])
            second = (foot, on_end[0], on_end[1], crest)
            if sign * inward > 0:
                first, second = first[1::-1] + first[:1:-1], second[1::-1] + second[:1:-1]
            facets.quad(key, shade, *first)
            facets.quad(key, shade, *second)


def _seams(facets, key, tint, slopes, spacing_m=0.6) -> None:
    """Standing seams: triangular ribs 5 cm high up each slope."""
    for a, b, _, d in np.asarray(slopes):
        length = np.linalg.norm(b - a)
        u, n = (b - a) / length, cross(b - a, d - a)
        n /= np.linalg.norm(n)
        s = np.arange(spacing_m / 2, length - 0.1, spacing_m)[:, None] * u
        foot, head = a + s, d + s
        low, high = foot + 0.05 * n, head + 0.05 * n
        w = 0.025 * u
        # The first edge runs up the slope here: seams are plain.
        left = np.stack([foot - w, low, high, head - w], 1)
        right = np.stack([low, foot + w, head + w, high], 1)
        facets.add(key, tint, np.concatenate([left, right]))
