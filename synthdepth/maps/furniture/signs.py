"""Street lamps and traffic signs: a few templates, copied along the streets."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.furniture.poles import STEEL, Surfaces, lean_matrix
from synthdepth.maps.geometry import Geometry, Model, box, copies, geometry, join, tube, yaw_matrix

# Colour of the light, and of the diffuser by day.
_SODIUM = (0.75, 0.5, 0.22)
_LED = (0.65, 0.65, 0.62)
_WARM_LED = (0.6, 0.5, 0.34)


def _cobra_lamp() -> Model:
    """Tapered steel column, curved arm, flat head: 8.4 m."""
    turn = np.linspace(0, np.pi / 2, 4)[1:]
    path = [[0, 0, -0.1], [0, 0, 0.9], [0, 0, 7.4]]
    path += [[1.0 - np.cos(t), 0, 7.4 + 0.8 * np.sin(t)] for t in turn] + [[1.9, 0, 8.32]]
    column = tube(path, [0.11, 0.1, 0.06, 0.05, 0.045, 0.04, 0.035], 7)
    foot = tube([[0, 0, -0.1], [0, 0, 0.5]], 0.14, 7)
    head = box((0.7, 0.28, 0.11), (2.15, 0, 8.26))
    lens = box((0.45, 0.2, 0.05), (2.2, 0, 8.225), _SODIUM)
    return {
        ("paint", "pole"): join([column, foot, head]).tinted(STEEL),
        ("lamp", "pole"): lens,
    }


def _straight_lamp() -> Model:
    """Concrete-grey column with a straight bracket and a slim LED head: 7 m."""
    column = tube([[0, 0, -0.1], [0, 0, 7.0]], [0.09, 0.055], 8)
    arm = tube([[0, 0, 6.9], [0.9, 0, 7.08]], 0.035, 6)
    head = box((0.62, 0.3, 0.07), (1.15, 0, 7.05))
    lens = box((0.5, 0.22, 0.02), (1.15, 0, 7.035), _LED)
    steel = join([column, arm, head]).tinted((0.42, 0.43, 0.43))
    return {("paint", "pole"): steel, ("lamp", "pole"): lens}


def _lantern() -> Model:
    """Cast post with a four-sided lantern, black or dark green: 3.9 m."""
    levels = [-0.1, 0.0, 0.45, 0.6, 0.7, 3.1, 3.2]
    post = tube([[0, 0, z] for z in levels], [0.17, 0.17, 0.13, 0.11, 0.07, 0.05, 0.09], 8)
    bar = tube([[0, -0.3, 2.9], [0, 0.3, 2.9]], 0.018, 4)
    roof = tube([[0, 0, 3.68], [0, 0, 3.74], [0, 0, 3.92]], [0.27, 0.25, 0.03], 6)
    body = tube([[0, 0, 3.18], [0, 0, 3.69]], [0.13, 0.21], 6, _WARM_LED)
    iron = join([post, bar, roof]).tinted((0.03, 0.035, 0.032))
    return {("paint", "pole"): iron, ("lamp", "pole"): body}


LAMPS: dict[str, Callable[[], Model]] = {
    "cobra": _cobra_lamp,
    "straight": _straight_lamp,
    "lantern": _lantern,
}


def _known(table: dict, kind: str, what: str):
    if kind not in table:
        raise KeyError(f"{what} {kind!r} is not one of {sorted(table)}")
    return table[kind]


def _placed(
    rng: np.random.Generator, model: Model, positions, headings_rad, lean_deg: float
) -> Surfaces:
    """Copies of a model (x forward), each turned to its heading, leaning a little, weathered."""
    at = np.asarray(positions, np.float64).reshape(-1, 3)
    yaw = np.broadcast_to(np.asarray(headings_rad, np.float64), len(at))
    yaw = yaw + np.radians(rng.normal(0, 2, len(at)))
    lean = np.radians(np.clip(rng.normal(0, lean_deg, (len(at), 2)), -3, 3))
    rotation = lean_matrix(lean) @ yaw_matrix(yaw)
    tint = np.repeat(rng.uniform(0.85, 1.08, (len(at), 1)), 3, axis=1)
    return {k: copies(p, at, rotation=rotation, tint=tint) for k, p in model.items()}


def street_lamps(
    rng: np.random.Generator, positions, headings_rad, kind: str | None = None
) -> Surfaces:
    """Street lamps of one kind at `positions` (k, 3), arms pointing along `headings_rad` (k,).

    `kind` is a key of `LAMPS`; drawn when none.
    """
    drawn = str(rng.choice(sorted(LAMPS)))
    return _placed(rng, _known(LAMPS, kind or drawn, "lamp")(), positions, headings_rad, 0.4)


def _plate(corners, z: float, tint, thickness: float = 0.012, front: float = 0.045) -> Geometry:
    """A sign's plate facing +x: `corners` (n, 2) of (y, z) counter-clockwise, grey behind."""
    ring = np.asarray(corners, np.float64)
    n = len(ring)
    face = np.column_stack([np.full(n, front), ring[:, 0], ring[:, 1] + z])
    back = face - [thickness, 0, 0]
    fan = np.stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)], 1).astype(int)
    nxt = np.roll(np.arange(n), -1)
    rim = np.concatenate(
        [
            np.stack([np.arange(n), n + np.arange(n), n + nxt], 1),
            np.stack([np.arange(n), n + nxt, nxt], 1),
        ]
    )
    uv = np.concatenate([ring, ring])
    return join(
        [
            geometry(face, fan, ring, tint),
            geometry(np.concatenate([face, back]), rim, uv, STEEL),
            geometry(back, fan[:, ::-1], ring, STEEL),
        ]
    )


def _decal(corners, z: float, tint, layer: int = 1) -> Geometry:
    """Paint on a plate: only a face, 5 mm a layer in front of it."""
    ring = np.asarray(corners, np.float64)
    n = len(ring)
    face = np.column_stack([np.full(n, 0.045 + 0.005 * layer), ring[:, 0], ring[:, 1] + z])
    fan = np.stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)], 1).astype(int)
    return geometry(face, fan, ring, tint)


def _polygon(sides: int, radius: float, turn_deg: float = 0.0) -> np.ndarray:
    angle = np.radians(turn_deg) + 2 * np.pi * np.arange(sides) / sides
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _rectangle(width: float, height: float, centre=(0.0, 0.0)) -> np.ndarray:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, height / 2]
    return corners + np.asarray(centre)


def _letters(text: str, size: float, z: float, tint) -> list[Geometry]:
    """Block letters as bars of a seven-segment cell: enough to read as lettering from 10 m."""
    bars = {
        "top": (0, 0.5, 1, 0.18), "mid": (0, 0, 1, 0.18), "low": (0, -0.5, 1, 0.18),
        "ul": (-0.41, 0.25, 0.2, 0.5), "ur": (0.41, 0.25, 0.2, 0.5),
        "ll": (-0.41, -0.25, 0.2, 0.5), "lr": (0.41, -0.25, 0.2, 0.5), "stem": (0, 0, 0.2, 1.0),
    }  # fmt: skip
    glyphs = {
        "S": ("top", "ul", "mid", "lr", "low"), "T": ("top", "stem"),
        "P": ("top", "ul", "ll", "ur", "mid"),
        "O": ("top", "low", "ul", "ll", "ur", "lr"), "3": ("top", "ur", "mid", "lr", "low"),
        "5": ("top", "ul", "mid", "lr", "low"), "0": ("top", "low", "ul", "ll", "ur", "lr"),
    }  # fmt: skip
    parts = []
    for i, letter in enumerate(text):
        y0 = (i - (len(text) - 1) / 2) * size * 0.72
        for bar in glyphs[letter]:
            y, up, w, h = bars[bar]
            cell = _rectangle(w * size * 0.55, h * size, (y0 + y * size * 0.55, up * size))
            parts.append(_decal(cell, z, tint, 2))
    return parts


_WHITE, _RED, _BLACK = (0.62, 0.62, 0.6), (0.34, 0.016, 0.02), (0.02, 0.02, 0.02)
_GREEN, _BLUE, _YELLOW = (0.01, 0.11, 0.05), (0.015, 0.05, 0.22), (0.55, 0.33, 0.015)


def _sign(faces: list[Geometry], top_m: float) -> Model:
    post = tube([[0, 0, -0.1], [0, 0, top_m]], 0.03, 6, STEEL)
    return {("paint", "street_furniture"): join([post, *faces])}


def _stop() -> Model:
    z = 2.1 + 0.375
    faces = [
        _plate(_polygon(8, 0.406, 22.5), z, _WHITE),
        _decal(_polygon(8, 0.375, 22.5), z, _RED),
        *_letters("STOP", 0.2, z, _WHITE),
    ]
    return _sign(faces, 2.85)


def _speed_limit() -> Model:
    z = 2.1 + 0.3
    faces = [
        _plate(_polygon(16, 0.3), z, _RED),
        _decal(_polygon(16, 0.23), z, _WHITE),
        *_letters("30", 0.19, z, _BLACK),
    ]
    return _sign(faces, 2.72)


def _give_way() -> Model:
    z = 2.1 + 0.26
    faces = [
        _plate(_polygon(3, 0.52, -90), z, _RED),
        _decal(_polygon(3, 0.33, -90), z, _WHITE),
    ]
    return _sign(faces, 2.6)


def _warning() -> Model:
    z = 2.1 + 0.53
    faces = [
        _plate(_polygon(4, 0.53), z, _YELLOW),
        _decal(_rectangle(0.07, 0.4, (0, 0.02)), z, _BLACK),
        _decal(_rectangle(0.3, 0.07, (0, 0.06)), z, _BLACK, 2),
    ]
    return _sign(faces, 3.1)


def _parking() -> Model:
    z = 2.1 + 0.3
    faces = [
        _plate(_rectangle(0.45, 0.6), z, _BLUE),
        *_letters("P", 0.32, z, _WHITE),
    ]
    return _sign(faces, 2.68)


def _street_name() -> Model:
    """Two blades crossing on one post."""
    blade = [
        box((0.02, 0.75, 0.2), (0, 0.02, 2.72), _GREEN),
        box((0.02, 0.75, 0.2), (0, 0.0, 2.95), _GREEN),
    ]
    stripes = [
        box((0.032, 0.5, 0.09), (0, 0.0, 2.775), _WHITE),
        box((0.032, 0.55, 0.09), (0, 0.0, 3.005), _WHITE),
    ]
    quarter = yaw_matrix(np.array([np.pi / 2]))
    upper = copies(join([blade[1], stripes[1]]), np.zeros((1, 3)), rotation=quarter)
    return _sign([blade[0], stripes[0], upper], 3.2)


SIGNS: dict[str, Callable[[], Model]] = {
    "stop": _stop,
    "speed_limit": _speed_limit,
    "give_way": _give_way,
    "warning": _warning,
    "parking": _parking,
    "street_name": _street_name,
}


def signs(rng: np.random.Generator, positions, headings_rad, kind: str) -> Surfaces:
    """Signs of one kind (a key of `SIGNS`) at `positions` (k, 3), facing `headings_rad` (k,)."""
    return _placed(rng, _known(SIGNS, kind, "sign")(), positions, headings_rad, 1.2)
