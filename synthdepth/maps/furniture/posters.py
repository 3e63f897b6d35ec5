"""Lettering and advertisements, laid on plates and columns as thin coloured rectangles."""

import functools

import numpy as np

from synthdepth.maps.geometry import Geometry, quads

# Five rows of three cells a letter, top first, each row one octal digit.
_FONT = {
    "A": "25755", "B": "65656", "C": "34443", "D": "65556", "E": "74647", "F": "74644",
    "G": "34553", "H": "55755", "I": "72227", "J": "11152", "K": "55655", "L": "44447",
    "M": "57755", "N": "65555", "O": "25552", "P": "65644", "Q": "25573", "R": "65655",
    "S": "34216", "T": "72222", "U": "55557", "V": "55522", "W": "55775", "X": "55255",
    "Y": "55222", "Z": "71247", "0": "75557", "1": "26227", "2": "61247", "3": "71317",
    "4": "55711", "5": "74617", "6": "34757", "7": "71222", "8": "75757", "9": "75716",
    "-": "00700", "%": "51245", " ": "00000",
}  # fmt: skip
WORDS = (
    "SUMMER", "FRESH", "COFFEE", "CINEMA", "HOTEL", "MUSIC", "OPERA", "TRAVEL", "SALE 50%", "NOVA",
    "BANK", "CITY", "LIVE", "MUSEUM", "FASHION", "GARDEN", "ENERGY", "RADIO 98", "MARKET", "SPORT",
)  # fmt: skip
# Half widths of silhouettes over their height, from the foot up.
_SHAPES = (
    (0.11, 0.12, 0.12, 0.12, 0.12, 0.12, 0.10, 0.06, 0.035, 0.035, 0.04),
    (0.30, 0.30, 0.29, 0.26, 0.12, 0.10, 0.14, 0.155, 0.15, 0.12, 0.06),
    (0.42, 0.40, 0.36, 0.31, 0.27, 0.22, 0.17, 0.13, 0.09, 0.05, 0.02),
    (0.06, 0.14, 0.19, 0.22, 0.235, 0.24, 0.235, 0.22, 0.19, 0.14, 0.06),
)
_GROUNDS = (
    (0.50, 0.48, 0.44), (0.42, 0.045, 0.035), (0.03, 0.10, 0.26), (0.50, 0.36, 0.06),
    (0.035, 0.037, 0.04), (0.08, 0.26, 0.24), (0.36, 0.14, 0.16), (0.14, 0.25, 0.42),
    (0.58, 0.57, 0.54), (0.08, 0.16, 0.07),
)  # fmt: skip
_LAYER_M = 0.005


@functools.cache
def _glyph(letter: str) -> tuple[tuple[int, int, int, int], ...]:
    """Rectangles (column, row, columns, rows) of a letter; row 0 is the lowest."""
    cells = {(c, r) for r in range(5) for c in range(3) if int(_FONT[letter][4 - r]) >> (2 - c) & 1}
    rectangles = []
    for c in range(3):
        r = 0
        while r < 5:
            run = 0
            while (c, r + run) in cells:
                run += 1
            if run >= 3:
                rectangles.append((c, r, 1, run))
                cells -= {(c, r + i) for i in range(run)}
            r += max(run, 1)
    for r in range(5):
        c = 0
        while c < 3:
            run = 0
            while (c + run, r) in cells:
                run += 1
            if run:
                rectangles.append((c, r, run, 1))
            c += max(run, 1)
    return tuple(rectangles)


def lettering(text: str, height_m: float) -> np.ndarray:
    """Rectangles (k, 4) of lower left and upper right corners [m], the text centred on the origin.

    `text` is of capitals, digits, spaces, "-" and "%".
    """
    cell = height_m / 5
    found = [
        (4 * i + c, r, 4 * i + c + w, r + h)
        for i, letter in enumerate(text)
        for c, r, w, h in _glyph(letter)
    ]
    rectangles = np.array(found, float).reshape(-1, 4) * cell * [0.85, 1, 0.85, 1]
    middle = np.array([(4 * len(text) - 1) * 0.85, 5.0]) * cell / 2
    return rectangles - np.tile(middle, 2)


def decals(rectangles, tint, layer, radius_m: float | None = None, sides: int = 24) -> Geometry:
    """Rectangles on the plane x = 0 seen from +x, or on a column about z.

    Args:
        rectangles: (k, 4) u and v of the lower left, then of the upper right corner [m]; u runs
            along +y.
        tint: (3,), (k, 3), or (k, 2, 3) of the lower and the upper edge.
        layer: scalar or (k,): how many layers of 5 mm they lie in front.
        radius_m: of the column, whose `sides` facets they are cut at; flat when none.
    """
    r = np.asarray(rectangles, np.float64).reshape(-1, 4)
    k = len(r)
    t = np.asarray(tint, np.float64)
    t = np.broadcast_to(t[:, None] if t.ndim == 2 else t, (k, 2, 3))
    out = _LAYER_M * np.broadcast_to(np.asarray(layer, np.float64), k)
    if radius_m is not None:
        edge = radius_m * 2 * np.pi * (np.arange(sides + 1) / sides - 0.5)
        low, high = np.maximum(r[:, :1], edge[:-1]), np.minimum(r[:, 2:3], edge[1:])
        which, column = np.nonzero(high - low > 1e-3)
        r = np.column_stack([low[which, column], r[which, 1], high[which, column], r[which, 3]])
        t, out = t[which], out[which]
    u, v = r[:, [0, 2, 2, 0]], r[:, [1, 1, 3, 3]]
    x = np.broadcast_to(out[:, None], u.shape)
    if radius_m is None:
        corners = np.stack([x, u, v], axis=-1)
    else:
        # On the chord of its facet, not on the arc.
        step = 2 * np.pi / sides
        turn, middle = u / radius_m, (np.floor(u.mean(1) / radius_m / step) + 0.5) * step
        flat = (radius_m + x) * np.cos(step / 2) / np.cos(turn - middle[:, None])
        corners = np.stack([flat * np.cos(turn), flat * np.sin(turn), v], axis=-1)
    part = quads(corners)
    return part.tinted(t[:, [0, 0, 1, 1]].reshape(-1, 3))


def _silhouette(rng, width: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Strips of a bottle, a bust, a mountain or a fruit, with their colours."""
    shape = np.interp(np.linspace(0, 10, 14), np.arange(11), _SHAPES[rng.integers(len(_SHAPES))])
    tall = height * rng.uniform(0.45, 0.7)
    half = np.minimum(shape * tall * rng.uniform(0.8, 1.2), 0.46 * width)
    at = rng.uniform(-0.15, 0.15) * width
    level = height * rng.uniform(0.06, 0.18) + np.linspace(0, tall, 15)
    left = np.maximum(at - half, -0.47 * width)
    right = np.minimum(at + half, 0.47 * width)
    strips = np.column_stack([left, level[:-1], right, level[1:]])
    colour = np.array(_GROUNDS[rng.integers(len(_GROUNDS))])
    light = np.linspace(rng.uniform(0.5, 0.8), 1.15, 14)[:, None]
    return strips, np.clip(colour * light, 0.012, 0.7)


def poster(
    rng: np.random.Generator,
    width_m: float,
    height_m: float,
    radius_m: float | None = None,
    sides: int = 24,
) -> Geometry:
    """An advertisement of paint: picture, headline, small print.

    Its lower edge is centred on the origin and it is seen from +x; with `radius_m` it wraps round
    a column about z of that radius and `sides` facets.
    """
    ground = np.array(_GROUNDS[rng.integers(len(_GROUNDS))])
    fade = np.clip(ground * rng.uniform(0.4, 1.5), 0.012, 0.7)
    sheet = np.array([[-width_m / 2, 0, width_m / 2, height_m]])
    rectangles, tints, layers = [sheet], [np.stack([fade, ground])[None]], [np.zeros(1)]
    if rng.random() < 0.7:
        # A band, sky over land, a table top.
        level = height_m * rng.uniform(0.2, 0.5)
        other = np.array(_GROUNDS[rng.integers(len(_GROUNDS))])
        rectangles.append(np.array([[-width_m / 2, 0, width_m / 2, level]]))
        tints.append(np.stack([other, np.clip(other * 0.6, 0.012, 1)])[None])
        layers.append(np.ones(1))
    # Wide sheets show several things side by side.
    count = 1 + (int(rng.integers(1, 4)) if width_m > 1.2 * height_m else 0)
    for k in range(count):
        part = width_m / count
        strips, shades = _silhouette(rng, part, height_m)
        middle = (k + 0.5) * part - width_m / 2
        rectangles.append(strips + [middle, 0, middle, 0])
        tints.append(np.repeat(shades[:, None], 2, axis=1))
        layers.append(np.full(len(strips), 2.0))
    ink = np.array([0.66, 0.66, 0.64] if ground.mean() < 0.25 else [0.03, 0.03, 0.035])
    text = WORDS[rng.integers(len(WORDS))]
    size = min(height_m * rng.uniform(0.09, 0.2), 1.35 * 0.85 * width_m / len(text))
    head = lettering(text, size) + [0, height_m * 0.86, 0, height_m * 0.86]
    words = _small_print(rng, width_m, height_m)
    for group in (head, words):
        rectangles.append(group)
        tints.append(np.broadcast_to(ink, (len(group), 2, 3)))
        layers.append(np.full(len(group), 3.0))
    return decals(
        np.concatenate(rectangles), np.concatenate(tints), np.concatenate(layers), radius_m, sides
    )


def _small_print(rng, width: float, height: float) -> np.ndarray:
    """Lines of words too small to read, as bars."""
    size, lines = height * 0.018, int(rng.integers(1, 4))
    v = height * rng.uniform(0.03, 0.06) + size * 1.9 * np.arange(lines)
    length = rng.uniform(2, 6, (lines, 6)) * size
    end = np.cumsum(length + size, axis=1) - 0.46 * width
    start = end - length
    keep = end < 0.46 * width
    low = np.broadcast_to(v[:, None], keep.shape)
    bars = np.stack([start, low, end, low + size], axis=-1)
    return bars[keep]
