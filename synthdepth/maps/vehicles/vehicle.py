"""Parked cars, vans, pickups and buses: bodies lofted from a side profile and cross sections.

A vehicle is a lower body (stations along x, a ring of section points at each), two end caps that
continue it, and a glasshouse lofted between a ring at the belt line and a ring at the roof. Panes,
lamps and grilles are cells of those grids, so they lie flush in the body.
"""

import dataclasses
import itertools

import numpy as np

from synthdepth.maps.geometry import Geometry, Model, box, copies, cross, geometry, join, yaw_matrix
from synthdepth.maps.vehicles.bodies import BODIES, Body

__all__ = ["BODIES", "Vehicle", "draw_vehicle", "park", "vehicle"]

# Linear reflectances of car paint: mostly achromatic, as on real streets.
_ACHROMATIC = np.array(
    [
        [0.78, 0.78, 0.76],
        [0.70, 0.70, 0.68],
        [0.42, 0.43, 0.44],
        [0.30, 0.31, 0.32],
        [0.12, 0.125, 0.13],
        [0.06, 0.062, 0.066],
        [0.016, 0.016, 0.017],
        [0.02, 0.02, 0.022],
    ]
)
_COLOURED = np.array(
    [
        [0.20, 0.016, 0.016],
        [0.10, 0.012, 0.016],
        [0.02, 0.04, 0.12],
        [0.05, 0.12, 0.24],
        [0.016, 0.03, 0.06],
        [0.02, 0.05, 0.035],
        [0.07, 0.08, 0.055],
        [0.28, 0.22, 0.14],
        [0.14, 0.09, 0.06],
        [0.30, 0.10, 0.02],
    ]
)
_COMMERCIAL = ("van", "bus")

# Material and tint of each kind of cell; the tint of "body" is the vehicle's colour.
_LOOKS = {
    "body": ("car_paint", (1.0, 1.0, 1.0)),
    "glass": ("glass", (1.0, 1.0, 1.0)),
    "pillar": ("paint", (0.015, 0.015, 0.016)),
    "dark": ("paint", (0.022, 0.022, 0.023)),
    "front_lamp": ("paint", (0.24, 0.25, 0.26)),
    "rear_lamp": ("paint", (0.22, 0.012, 0.012)),
    "rim": ("metal", (0.9, 0.9, 0.92)),
    "hub": ("paint", (0.15, 0.15, 0.155)),  # rim and tyre wall together, from afar
    "tyre": ("rubber", (1.0, 1.0, 1.0)),
    "unit": ("paint", (0.5, 0.5, 0.5)),
    "plate": ("paint", (0.62, 0.62, 0.55)),
}
# Half width by height share between sill and shoulder: tucked sills, widest at the middle.
_SECTION_H = (0.0, 0.14, 0.4, 0.6, 0.85, 1.0)
_SECTION_W = (0.93, 0.97, 0.995, 1.0, 0.985, 0.935)
# Setback [m] of the nose and tail over the same heights.
_END_SETBACK = (0.09, 0.02, 0.0, 0.01, 0.04, 0.1)
_CROWN_M = 0.05


@dataclasses.dataclass(frozen=True, kw_only=True)
class Vehicle:
    """One vehicle: a body, stretched a little, in a colour.

    Attributes:
        body: key of `BODIES`.
        scale: (length, width, height) factors on the body's dimensions.
        colour: linear RGB reflectance of the paint.
        spokes: spokes of the rims.
        dirt: share of dust on the lowest paint, 0 to 1.
        detail: 1 for a vehicle seen from near, 0 for a far one.
    """

    body: str
    scale: tuple[float, float, float]
    colour: tuple[float, float, float]
    spokes: int
    dirt: float
    detail: int


def _draw_colours(rng: np.random.Generator, count: int, commercial: np.ndarray) -> np.ndarray:
    """Paint colours (count, 3): 75 % white, silver, grey or black; vans and buses mostly white."""
    grey = _ACHROMATIC[rng.integers(len(_ACHROMATIC), size=count)]
    colour = np.where(rng.random((count, 1)) < 0.25, _COLOURED[rng.integers(10, size=count)], grey)
    white = commercial & (rng.random(count) < 0.7)
    colour = np.where(white[:, None], _ACHROMATIC[0], colour)
    return colour * rng.uniform(0.88, 1.1, (count, 1))


def draw_vehicle(rng: np.random.Generator, body: str, *, detail: int = 1) -> Vehicle:
    """A vehicle of a body type (a key of `BODIES`) in a drawn colour and trim."""
    if body not in BODIES:
        raise KeyError(f"body {body!r} is not one of {sorted(BODIES)}")
    colour = _draw_colours(rng, 1, np.array([body in _COMMERCIAL]))[0]
    return Vehicle(
        body=body,
        scale=tuple(rng.uniform([0.95, 0.98, 0.97], [1.04, 1.02, 1.03]).tolist()),
        colour=tuple(colour.tolist()),
        spokes=int(rng.choice([5, 7])),
        dirt=float(rng.uniform(0.05, 0.35)),
        detail=detail,
    )


def _grid(points: np.ndarray, kinds: np.ndarray, out: dict[str, list[Geometry]]) -> None:
    """Adds the cells of a grid (n, m, 3) to `out` by kind (n - 1, m - 1); "" leaves a hole."""
    n, m = points.shape[:2]
    i = np.arange(n * m).reshape(n, m)
    cells = np.stack([i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]], axis=-1)
    flat = points.reshape(-1, 3)
    for kind in sorted(set(kinds.ravel().tolist()) - {""}):
        quad = cells[kinds == kind]
        faces = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
        corner = flat[faces]
        area = np.linalg.norm(
            cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
        )
        faces = faces[area > 2e-6]
        used, faces = np.unique(faces, return_inverse=True)
        out.setdefault(kind, []).append(
            geometry(flat[used], faces.reshape(-1, 3), flat[used][:, [0, 2]])
        )


def _stations(body: Body, detail: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, lower edge z and share of the end's shape, each (n,), from tail to nose."""
    half, bulge = body.length_m / 2, body.nose_bulge_m
    inset = np.array([0.0, 0.09, 0.26, 0.55]) if detail else np.array([0.0, 0.3])
    share = np.array([1.0, 0.7, 0.3, 0.0]) if detail else np.array([1.0, 0.2])
    span = 1.16 * body.wheel_radius_m
    xs, lows, shares = [], [], []
    for end, gap, axle in zip((1, -1), (bulge, bulge / 2), body.axle_x_m, strict=True):
        x = end * (half - gap - inset)
        free = np.abs(x) > abs(axle) + span + 0.05
        xs.append(x[free])
        lows.append(np.full(free.sum(), body.sill_m))
        shares.append(share[free])
    angle = np.linspace(0, np.pi, 11 if detail else 4)
    for axle in body.axle_x_m:
        # Half a superellipse: rounder shoulders than the circle cut off at the sill.
        xs.append(axle + span * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.85)
        top = body.wheel_radius_m + span - body.sill_m
        lows.append(body.sill_m + top * np.sin(angle) ** 0.8)
        shares.append(np.zeros(len(angle)))
    extra = [x for x, _ in body.deck_m[1:-1]] if detail else [body.windscreen_x_m[0]]
    extra += [*_door_x(body), body.rear_x_m[0]] if detail else []
    if body.bed_m:
        front, rear, _ = body.bed_m
        extra += [front + 0.02, front, rear, rear - 0.02]
    taken = np.concatenate(xs)
    for x in extra:
        near_arch = min(abs(x - a) for a in body.axle_x_m) < span + 0.02
        if (body.bed_m and x in extra[-4:]) or (not near_arch and np.abs(taken - x).min() > 0.06):
            xs.append(np.array([x]))
            lows.append(np.array([body.sill_m]))
            shares.append(np.zeros(1))
    order = np.argsort(np.concatenate(xs), kind="stable")
    return np.concatenate(xs)[order], np.concatenate(lows)[order], np.concatenate(shares)[order]


def _door_x(body: Body) -> list[float]:
    """Where the doors' edges cross the flank, front to rear."""
    if body.length_m > 8:
        return []
    doors = [body.posts[0][0] + 0.12, body.posts[1][0] - 0.05]
    doors += [p[0] + 0.04 for p in body.posts[3:4]]
    clear = 1.22 * body.wheel_radius_m
    return [x for x in doors if min(abs(x - a) for a in body.axle_x_m) > clear]


def _half_width(body: Body, x: np.ndarray) -> np.ndarray:
    """Half width of the widest section at x, narrowing towards both ends."""
    end = np.clip((np.abs(x) - (body.length_m / 2 - 1.0)) / 1.0, 0, 1)
    return body.width_m / 2 * (1 - body.end_taper * end**2.2)


def _side_y(body: Body, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """y of the left flank at (x, z)."""
    shoulder = _deck_z(body, x) - _CROWN_M
    share = (z - body.sill_m) / (shoulder - body.sill_m)
    return _half_width(body, x) * np.interp(share, _SECTION_H, _SECTION_W)


def _deck_z(body: Body, x: np.ndarray) -> np.ndarray:
    x_key, z_key = np.array(body.deck_m[::-1]).T
    return np.interp(x, x_key, z_key)


def _lower_body(body: Body, detail: int, out: dict[str, list[Geometry]]) -> None:
    """Flanks, bonnet, boot, wheel wells, floor and both ends."""
    x, low, share = _stations(body, detail)
    rows = np.array(_SECTION_H if detail else (0.0, 0.5, 1.0))
    across = np.array([0.88, 0.62, 0.3, 0.0] if detail else [0.8, 0.0])
    if body.bed_m:
        across = np.array([0.92, 0.9, 0.45, 0.0])
    side, n = len(rows), len(x)

    z = low[:, None] + rows * (_deck_z(body, x) - _CROWN_M - low)[:, None]
    y = _side_y(body, x[:, None], z)
    setback = np.interp((z - body.sill_m) / (z[:, -1:] - body.sill_m), _SECTION_H, _END_SETBACK)
    front = np.sign(x)[:, None]
    bulge = np.where(front > 0, body.nose_bulge_m, body.nose_bulge_m / 2)
    flank = np.stack([x[:, None] - front * share[:, None] * setback, y, z], -1)

    def shaped(t: np.ndarray, edge: np.ndarray, height_share) -> np.ndarray:
        """Points between the left and the right flank, at shares t of the half width."""
        bend = bulge * share[:, None] * (1 - t**2)
        return np.stack(
            [
                edge[:, None, 0] + front * bend,
                edge[:, None, 1] * t,
                edge[:, None, 2] + height_share * _CROWN_M * (1 - np.abs(t) ** 3),
            ],
            -1,
        )

    deck = shaped(across[None], flank[:, -1], 1.0)
    if body.bed_m:
        inside = (x <= body.bed_m[0] + 1e-6) & (x >= body.bed_m[1] - 1e-6)
        deck[np.ix_(inside, across <= 0.9, [2])] = body.bed_m[2]
    inner = np.full(n, body.width_m / 2 - 0.3)
    floor = np.full(n, body.sill_m + 0.012)
    under = np.stack(
        [
            np.stack([x, np.zeros(n), floor], -1),
            np.stack([x, inner, floor], -1),
            np.stack([x, inner, low + 0.012], -1),
        ],
        axis=1,
    )
    half = np.concatenate([under, flank, deck], axis=1)
    mirrored = half[:, -2::-1] * np.array([1, -1, 1])
    ring = np.concatenate([half, mirrored], axis=1)

    kinds = np.full((n - 1, half.shape[1] - 1), "body", dtype="<U10")
    kinds[:, 0] = ""
    kinds[:, 1:3] = "dark" if detail else ""
    if body.cladding or not detail:
        kinds[:, 3] = "dark" if body.cladding else "body"
    covered = (x[:-1] > body.rear_x_m[0] + 0.08) & (x[1:] < body.windscreen_x_m[0] - 0.25)
    kinds[covered, 3 + side :] = ""
    if body.bed_m:
        load = (x[:-1] > body.bed_m[1] - 0.03) & (x[1:] < body.bed_m[0] + 0.03)
        kinds[load, 3 + side :] = "dark"
    lamp_rows = slice(3 + side - 3, 3 + side - 2) if detail else slice(3 + side - 2, 3 + side - 1)
    if detail:
        kinds[:2, lamp_rows] = "rear_lamp"
        kinds[-1:, lamp_rows] = "front_lamp"
    _grid(ring, np.concatenate([kinds, kinds[:, ::-1]], axis=1), out)
    size = (np.ptp(x) - 0.35, 2 * inner[0], 0.02)  # the ends tuck in below the bumpers
    out.setdefault("dark", []).append(box(size, ((x[0] + x[-1]) / 2, 0, floor[0])))

    columns = np.concatenate([[1.0], across, -across[-2::-1], [-1.0]])
    for end, lamp in ((-1, "front_lamp"), (0, "rear_lamp")):
        cap = np.stack(
            [shaped(columns[None], flank[:, r], rows[r])[end] for r in range(side)]
        )  # (rows, columns, 3)
        if end == 0:
            cap = cap[:, ::-1]
        cell = np.full((side - 1, len(columns) - 1), "body", dtype="<U10")
        if detail:
            cell[-2, :2], cell[-2, -2:] = lamp, lamp
            cell[0] = "dark"
            if end == -1:
                cell[-2, 2:-2] = "dark"
                cell[1, 2:-2] = "dark"
        else:
            cell[-1, :1], cell[-1, -1:] = lamp, lamp
        _grid(np.ascontiguousarray(cap[::-1]), cell[::-1], out)


def _glasshouse(body: Body, detail: int, out: dict[str, list[Geometry]]) -> None:
    """Windscreen, side windows, pillars and roof, lofted from the belt to the roof."""
    posts = list(body.posts)
    if not detail:  # one long pane between the body panels
        posts = [p for p in posts if p[2] != "pillar"]
        posts = posts[:1] + [b for a, b in itertools.pairwise(posts) if a[2] != b[2]]
    wide = np.array(body.glasshouse_width) * body.width_m / 2
    screen = np.array([0.0, 0.45, 0.84]) if detail else np.array([0.0, 0.84])
    bow_m = (0.22, 0.09)  # of the screen's middle ahead of its edges, at the belt and the roof
    shape = []  # belt and roof rings, each (half ring, 2)
    for level in (0, 1):
        front, rear = body.windscreen_x_m[level], body.rear_x_m[level]
        nose = np.stack([front - bow_m[level] * (screen / 0.84) ** 2, screen * wide[level]], -1)
        flank = np.array([[p[level], wide[level]] for p in posts])
        # Plan taper: the glasshouse is widest at the B pillar.
        flank[:, 1] *= 1 - 0.035 * np.abs(np.linspace(-1, 1, len(flank))) ** 2
        tail = np.stack([rear + 0.09 * (screen[::-1] / 0.84) ** 2, screen[::-1] * wide[level]], -1)
        shape.append(np.concatenate([nose, flank, tail]))
    belt, roof = shape
    kinds = (
        ["glass"] * (len(screen) - 1)
        + ["body"]
        + [p[2] for p in posts]
        + ["glass"] * (len(screen) - 1)
    )
    # (height share, share of the way to the roof ring, inset [m]); panes between rows 1 and 3.
    levels = (
        ((-0.06, 0.0, 0), (0.05, 0.03, 0), (0.5, 0.44, 0), (0.86, 0.85, 0), (0.95, 0.97, 0.03),
         (1.0, 1.0, 0.15))
        if detail
        else ((-0.06, 0.0, 0), (0.9, 0.9, 0), (1.0, 1.0, 0.1))
    )  # fmt: skip
    rows = []
    middle = np.array([roof[:, 0].mean(), 0.0])
    for height, way, inset in levels:
        plan = belt + way * (roof - belt)
        away = plan - middle
        plan = plan - np.sign(away) * np.minimum(inset, np.abs(away))
        crown = 0.03 * ((plan[:, 0] - middle[0]) / (np.ptp(roof[:, 0]) / 2)) ** 2
        base = _deck_z(body, belt[:, 0]) - _CROWN_M / 2
        z = base + height * (body.height_m - crown - base)
        rows.append(np.column_stack([plan, z]))
    half = np.stack(rows)  # (levels, half ring, 3)
    ring = np.concatenate([half, half[:, -2::-1] * np.array([1, -1, 1])], axis=1)
    one = np.array(kinds, dtype="<U10")
    panes = np.concatenate([one, one[::-1]])
    glazed = [1, 2] if detail else [0]
    cells = np.full((len(levels) - 1, len(panes)), "body", dtype="<U10")
    cells[glazed] = panes
    _grid(ring, cells, out)
    top = half[-1]
    spine = top * np.array([1, 0, 1]) + np.array([0, 0, 0.02])
    spine[[0, -1], 2] -= 0.02
    roof_grid = np.stack([top, spine, top * np.array([1, -1, 1])], axis=1)
    _grid(roof_grid[::-1], np.full((len(top) - 1, 2), "body", dtype="<U10"), out)


def _wheel(radius: float, width: float, spokes: int, detail: int) -> dict[str, list[Geometry]]:
    """A wheel about the y axis, its outer face towards +y at y = 0."""
    out: dict[str, list[Geometry]] = {}
    sides = 2 * spokes if detail else 8
    if detail and spokes == 5:
        sides = 15
    turn = np.linspace(0, 2 * np.pi, sides + 1)
    circle = np.stack([np.cos(turn), np.zeros(sides + 1), np.sin(turn)], -1)

    def ring(r: float, y: float) -> np.ndarray:
        return r * circle + np.array([0, y, 0])

    if not detail:
        grid = np.stack([ring(radius, -width), ring(radius, 0), ring(0, 0)])
        kinds = np.full((2, sides), "tyre", dtype="<U10")
        kinds[1] = "hub"
        _grid(grid, kinds, out)
        return out
    r = radius * 0.66
    grid = np.stack(
        [ring(radius * 0.6, -width), ring(radius, -0.93 * width), ring(radius, -0.025),
         ring(r * 1.02, 0.0), ring(r, -0.035), ring(0.09, -0.02), ring(0.005, -0.015)]
    )  # fmt: skip
    kinds = np.full((6, sides), "tyre", dtype="<U10")
    kinds[3], kinds[5] = "rim", "rim"
    step = sides // spokes
    kinds[4] = np.where(np.arange(sides) % step == step - 1, "dark", "rim")
    _grid(grid, kinds, out)
    return out


def _trim(body: Body, out: dict[str, list[Geometry]]) -> None:
    """Mirrors, plates, door seams, handles and roof rails."""
    half = body.length_m / 2
    post = body.posts[0][0]
    z = float(_deck_z(body, np.array(post)))
    y = float(_half_width(body, np.array(post)))
    for side in (1, -1):
        at = (post - 0.02, side * (y * 0.93 + 0.07), z - 0.03)
        out.setdefault("body", []).append(box((0.09, 0.22, 0.14), at))
        out.setdefault("glass", []).append(
            box((0.01, 0.16, 0.11), (at[0] - 0.045, at[1] + side * 0.01, z - 0.015))
        )
    plate_z = body.sill_m + 0.42 * (_deck_z(body, np.array([half, -half])) - body.sill_m)
    out.setdefault("plate", []).append(box((0.03, 0.5, 0.11), (half - 0.004, 0, plate_z[0] - 0.1)))
    out["plate"].append(box((0.03, 0.5, 0.11), (-half + 0.004, 0, plate_z[1])))
    if body.length_m > 8:
        out.setdefault("unit", []).append(box((2.6, 1.7, 0.28), (-1.5, 0, body.height_m - 0.03)))
        return
    doors = _door_x(body)
    # At the stations' own points, or the seam would dive into the flat cells between them.
    rows = body.sill_m + np.array(_SECTION_H) * (0.98 * (z - _CROWN_M) - body.sill_m)
    for x in doors:
        edge = _side_y(body, np.full(6, x), rows) + 0.005
        strip = np.stack(
            [np.column_stack([np.full(6, x + d), edge, rows]) for d in (-0.006, 0.006)]
        )
        for side in (1, -1):
            mirrored = strip[::side] * np.array([1, side, 1])
            _grid(mirrored, np.full((1, 5), "dark", dtype="<U10"), out)
    for x in doors[1:]:
        handle_z = z - 0.17
        y = float(_side_y(body, np.array(x + 0.18), np.array(handle_z)))
        for side in (1, -1):
            out["body"].append(box((0.2, 0.05, 0.035), (x + 0.18, side * y, handle_z)))
    if body.rails:
        x0, x1 = body.windscreen_x_m[1] - 0.35, body.rear_x_m[1] + 0.15
        y = body.glasshouse_width[1] * body.width_m / 2 - 0.08
        for side in (1, -1):
            size = (x0 - x1, 0.035, 0.06)
            out.setdefault("pillar", []).append(
                box(size, ((x0 + x1) / 2, side * y, body.height_m - 0.05))
            )


def _welded(part: Geometry) -> Geometry:
    """The same surface with vertices at the same place (0.1 mm) shared, for smooth normals."""
    key = np.round(part.vertices * 1e4).astype(np.int64)
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[part.faces]
    keep = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    return geometry(part.vertices[first], faces[keep], part.uv[first], part.tint[first])


def vehicle(params: Vehicle) -> Model:
    """The vehicle standing on z = 0, x forward, origin below its middle."""
    body, detail = BODIES[params.body], params.detail
    out: dict[str, list[Geometry]] = {}
    _lower_body(body, detail, out)
    _glasshouse(body, detail, out)
    if detail:
        _trim(body, out)
    radius = body.wheel_radius_m
    width = 0.62 * radius
    axles = np.array([[x, side, radius] for x in body.axle_x_m for side in (1, -1)])
    axles[:, 1] *= _half_width(body, axles[:, 0]) * 0.975
    rotation = yaw_matrix(np.where(axles[:, 1] > 0, 0.0, np.pi))
    for kind, parts in _wheel(radius, width, params.spokes, detail).items():
        out.setdefault(kind, []).append(copies(join(parts), axles, rotation=rotation))

    model: dict[tuple[str, str], list[Geometry]] = {}
    for kind, parts in out.items():
        material, tint = _LOOKS[kind]
        part = join(parts)
        if kind == "body":
            part = _welded(part)
            height = np.maximum(part.vertices[:, 2] - body.sill_m, 0)
            dust = (params.dirt * np.exp(-height / 0.2))[:, None]
            tint = np.array(params.colour) * (1 - dust) + 0.12 * dust * np.array([1.0, 0.9, 0.75])
        model.setdefault((material, "vehicle"), []).append(part.tinted(tint))
    scale = np.array([params.scale])
    # Wheels stay on the ground: everything is scaled about it.
    return {key: copies(join(parts), np.zeros((1, 3)), scale=scale) for key, parts in model.items()}


def park(
    rng: np.random.Generator, positions: np.ndarray, headings_rad: np.ndarray, near_m: np.ndarray
) -> dict[tuple[str, str], Geometry]:
    """Cars and vans standing about, from a few templates in many colours.

    Args:
        rng: the lane of the parked vehicles.
        positions: (k, 3) ground below each vehicle's middle [m].
        headings_rad: (k,) of the noses, from +X, counter-clockwise.
        near_m: (k,) distance to the nearest place a camera may be; beyond 80 m a coarse model.

    Returns:
        Geometry by (material, label).
    """
    bodies = ("hatchback",) * 3 + ("sedan",) * 4 + ("estate",) * 2 + ("suv",) * 3
    bodies += ("pickup", "van")
    positions = np.asarray(positions, np.float64).reshape(-1, 3)
    count = len(positions)
    trims = [draw_vehicle(rng, body) for body in bodies]
    pick = rng.integers(len(bodies), size=count)
    commercial = np.array([body in _COMMERCIAL for body in bodies])[pick]
    colours = _draw_colours(rng, count, commercial)
    rotation = yaw_matrix(np.asarray(headings_rad, np.float64))
    near = np.asarray(near_m) <= 80.0
    parts: dict[tuple[str, str], list[Geometry]] = {}
    for index, trim in enumerate(trims):
        for detail in (0, 1):
            chosen = (pick == index) & (near == bool(detail))
            if not chosen.any():
                continue
            white = dataclasses.replace(trim, colour=(1.0, 1.0, 1.0), detail=detail)
            for key, part in vehicle(white).items():
                tint = colours[chosen] if key[0] == "car_paint" else None
                parts.setdefault(key, []).append(
                    copies(part, positions[chosen], rotation=rotation[chosen], tint=tint)
                )
    return {key: join(part) for key, part in parts.items()}
