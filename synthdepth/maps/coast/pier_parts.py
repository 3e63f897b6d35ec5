"""What piers and jetties are made of: planks, bents, railings, lamps, ladders, kiosks."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lofts import STEEL, lathe
from synthdepth.maps.coast.staging import Walk, piles
from synthdepth.maps.gardens.parts import DARK, WHITE, draw_colour
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    copies,
    join,
    quads,
    tube,
    yaw_matrix,
)

_BARRIER = "barrier"


def planks(rng, walk: Walk, s0: float, s1: float, half, deck_m: float, tint) -> Geometry:
    """Boards across the deck with gaps, each in its own tone, a few a little proud or short."""
    pitch = 0.155
    k = max(int((s1 - s0) / pitch), 1)
    s = s0 + (np.arange(k) + 0.5) * (s1 - s0) / k
    over = half + rng.normal(0.05, 0.012, k)
    z = deck_m - 0.022 + rng.normal(0, 0.002, k)
    tones = np.clip(rng.normal(1, 0.13, (k, 1)), 0.55, 1.5) * np.asarray(tint)
    new = rng.random(k) < 0.02
    tones[new] = np.array([0.36, 0.27, 0.17])
    return beams(walk.at(s, -over, z), walk.at(s, over, z), 0.143, 0.044, tones)


def bents(rng, walk: Walk, s, half: float, deck_m: float, bed_m, tint, radius: float, rows: int):
    """Piles, caps and crossed braces under the deck at each s (k,)."""
    s = np.asarray(s, np.float64)
    w = np.linspace(-1, 1, rows) * (half - radius - 0.05)
    ss, ww = np.meshgrid(s, w, indexing="ij")
    top = walk.at(ss, ww, deck_m - 0.5)
    # The outer piles are raked.
    foot = walk.at(ss, ww * 1.06, 0.0)
    bed = np.asarray(bed_m(foot[..., :2].reshape(-1, 2)), np.float64).reshape(ss.shape)
    foot[..., 2] = np.minimum(bed - 0.5, deck_m - 1.2)
    tones = np.clip(rng.normal(1, 0.12, (ss.size, 1)), 0.6, 1.4) * np.asarray(tint)
    parts = [piles(foot.reshape(-1, 3), top.reshape(-1, 3), radius, tones)]
    caps = beams(
        walk.at(s, -half - 0.1, deck_m - 0.42),
        walk.at(s, half + 0.1, deck_m - 0.42),
        0.26,
        0.26,
        np.asarray(tint) * 0.9,
    )
    clear = deck_m - 0.7 - np.maximum(bed, -0.4).max(axis=1)
    braced = clear > 1.0
    low = np.maximum(bed.max(axis=1) + 0.3, -0.3)[braced]
    sb = s[braced]
    shift = radius + 0.05
    if len(sb):
        for side, dx in ((1, shift), (-1, -shift)):
            a = walk.at(sb + dx, -side * w[-1], low)
            b = walk.at(sb + dx, side * w[-1], deck_m - 0.65)
            parts.append(beams(a, b, 0.07, 0.2, np.asarray(tint) * 0.75))
        # And along the pier, in every second bay.
        pairs = [(sb[i], sb[i + 1], low[i], low[i + 1]) for i in range(0, len(sb) - 1, 2)]
        for side in (1, -1):
            y = side * (w[-1] + shift)
            a = np.array([walk.at(p[0], y, p[2] + 0.2) for p in pairs])
            b = np.array([walk.at(p[1], y, deck_m - 0.7) for p in pairs])
            if len(a):
                parts.append(beams(a, b, 0.07, 0.18, np.asarray(tint) * 0.75))
    return parts, caps


def rail(rng, walk: Walk, s0: float, s1: float, w: float, deck_m: float, style: str, tint, gaps=()):
    """Posts and rails along one edge between s0 and s1, by style; gaps (a, b) stay open."""
    k = max(int((s1 - s0) / 1.9), 1)
    s = np.linspace(s0, s1, k + 1)
    open_bay = np.zeros(k, bool)
    for a, b in gaps:
        open_bay |= (s[:-1] < b) & (s[1:] > a)
    out: dict[tuple[str, str], list[Geometry]] = {}
    foot = walk.at(s, w, deck_m - 0.25)
    # A hair's breadth of lean turns the square posts with the pier.
    head = walk.at(s + 1e-4, w, deck_m + 1.08)
    i = np.flatnonzero(~open_bay)
    keep = np.unique(np.concatenate([i, i + 1]))
    foot, head = foot[keep], head[keep]

    def run(z: float, dw: float = 0.0):
        return walk.at(s[i], w + dw, deck_m + z), walk.at(s[i + 1], w + dw, deck_m + z)

    if style == "timber":
        key = ("wood", _BARRIER)
        out[key] = [
            beams(
                foot,
                head,
                0.11,
                0.11,
                tint * np.clip(rng.normal(1, 0.08, (len(foot), 1)), 0.7, 1.3),
            ),
            beams(*run(1.1), 0.14, 0.045, tint),
        ]
        for z in (0.38, 0.75):
            out[key].append(beams(*run(z, -0.07 * np.sign(w)), 0.04, 0.12, tint))
    elif style == "wire":
        out[("wood", _BARRIER)] = [
            beams(foot, head, 0.1, 0.1, tint),
            beams(*run(1.1), 0.13, 0.045, tint),
        ]
        out[("metal", _BARRIER)] = [
            round_bars(*run(z), 0.005, (0.8, 0.8, 0.8), 4) for z in (0.18, 0.4, 0.62, 0.84)
        ]
    else:  # painted iron with balusters
        key = ("paint", _BARRIER)
        out[key] = [
            round_bars(foot, head, 0.03, tint, 6),
            round_bars(*run(1.08), 0.028, tint, 6),
            round_bars(*run(0.12), 0.018, tint, 5),
        ]
        sb = (s[i][:, None] + (np.arange(11) + 0.5) / 11 * (s[i + 1] - s[i])[:, None]).ravel()
        out[key].append(
            round_bars(walk.at(sb, w, deck_m + 0.12), walk.at(sb, w, deck_m + 1.07), 0.009, tint, 3)
        )
    return {key: join(part) for key, part in out.items()}


def cross_rail(
    walk: Walk, s: float, w0: float, w1: float, deck_m: float, style: str, tint
) -> Model:
    """Railings across the pier: from w0 to w1 on both sides, or whole where w0 is 0."""
    ends = (
        [(-w1 + 0.08, w1 - 0.08)] if w0 == 0 else [(w0 - 0.08, w1 - 0.08), (-w1 + 0.08, -w0 + 0.08)]
    )
    material = "paint" if style == "iron" else "wood"
    parts = []
    for a, b in ends:
        k = max(int((b - a) / 1.8), 1)
        w = np.linspace(a, b, k + 1)
        foot, head = walk.at(s, w, deck_m - 0.1), walk.at(s + 1e-4, w, deck_m + 1.08)
        size = 0.05 if style == "iron" else 0.1
        parts.append(beams(foot, head, size, size, tint))
        for z in (0.36, 0.72, 1.1):
            parts.append(
                beams(
                    walk.at(s, w[:-1], deck_m + z), walk.at(s, w[1:], deck_m + z), 0.05, size, tint
                )
            )
    return {(material, _BARRIER): join(parts)}


def lamps(rng, walk: Walk, s, w, deck_m: float, tint) -> list[Model]:
    """Lamp posts of 4 m at the edge, the lantern towards the middle."""
    post = join(
        [
            lathe([0.1, 0.1, 0.055, 0.045], [-0.3, 0.5, 0.55, 3.9], 8),
            tube([[0, 0, 3.8], [0.12, 0, 4.05], [0.45, 0, 4.1]], 0.028, 6),
        ]
    )
    hood = lathe([0.2, 0.18, 0.05], [4.0, 4.06, 4.16], 8)
    # Counter-clockwise seen from below: it shines down.
    face = quads(
        np.array([[[0.34, 0.11, 0], [0.56, 0.11, 0], [0.56, -0.11, 0], [0.34, -0.11, 0]]])
        + [0, 0, 3.985]
    )
    hood = hood.moved([0.45, 0, 0])
    at = walk.at(s, w, deck_m)
    turn = yaw_matrix(walk.heading(s) + np.where(np.asarray(w) > 0, -np.pi / 2, np.pi / 2))
    colour = np.array([0.75, 0.66, 0.5])
    return [
        {
            ("paint", "pole"): copies(join([post, hood]).tinted(tint), at, rotation=turn),
            ("lamp", "pole"): copies(face.tinted(colour), at, rotation=turn),
        }
    ]


def bollards(walk: Walk, s, w, deck_m: float) -> Geometry:
    """Small cast bollards on the deck."""
    one = lathe(
        [0.16, 0.15, 0.1, 0.1, 0.17, 0.17, 0.08],
        [-0.02, 0.04, 0.08, 0.26, 0.32, 0.36, 0.4],
        9,
        DARK,
    )
    return copies(one, walk.at(s, w, deck_m))


def ladder(walk: Walk, s: float, w: float, deck_m: float, low_m: float) -> Geometry:
    """Two stringers over the edge and rungs down into the water."""
    out = np.sign(w)
    a = walk.at([s - 0.22, s + 0.22], w + out * 0.16, deck_m + 0.9)
    b = walk.at([s - 0.22, s + 0.22], w + out * 0.16, low_m)
    z = np.arange(low_m + 0.1, deck_m + 0.05, 0.3)
    rungs = round_bars(
        walk.at(s - 0.22, w + out * 0.16, z), walk.at(s + 0.22, w + out * 0.16, z), 0.014, STEEL, 5
    )
    return join([round_bars(a, b, 0.022, STEEL, 6), rungs])


def pavilion(rng, size: tuple[float, float], tint) -> Model:
    """A kiosk with a hipped or tented roof, windows and a pole on top; its door towards -x."""
    x, y = np.array(size) / 2
    high = rng.uniform(2.6, 3.1)
    roof_tint = draw_colour(
        rng, [(0.2, 0.06, 0.045), (0.1, 0.16, 0.15), (0.12, 0.12, 0.125), (0.06, 0.1, 0.16)]
    )
    trim = np.asarray(WHITE)
    ring = np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    corner = np.column_stack([ring, np.zeros(4)])
    nxt = [1, 2, 3, 0]
    walls = quads(
        np.stack([corner, corner[nxt], corner[nxt] + [0, 0, high], corner + [0, 0, high]], 1), tint
    )
    glass, frames = [], []
    for i in range(4):
        a, b = corner[i], corner[nxt[i]]
        along = (b - a) / np.linalg.norm(b - a)
        normal = np.array([along[1], -along[0], 0])
        count = int(np.linalg.norm(b - a) / 1.35)
        for j in range(count):
            mid = a + along * (j + 0.5) * np.linalg.norm(b - a) / count
            door = i == 3 and j == count // 2
            half, z0, z1 = (0.45, 0.04, 2.1) if door else (0.42, 0.95, 2.15)
            q = [
                mid - along * half + [0, 0, z0],
                mid + along * half + [0, 0, z0],
                mid + along * half + [0, 0, z1],
                mid - along * half + [0, 0, z1],
            ]
            if door:
                frames.append(quads((np.stack(q) + normal * 0.02)[None], tint * 0.5))
            else:
                glass.append(quads((np.stack(q) + normal * 0.012)[None]))
            ring4 = np.stack(q) + normal * 0.03
            frames.append(beams(ring4, np.roll(ring4, -1, axis=0), 0.06, 0.07, trim))
            if not door:
                frames.append(
                    beams(
                        [(ring4[0] + ring4[1]) / 2], [(ring4[2] + ring4[3]) / 2], 0.04, 0.04, trim
                    )
                )
    eave = 0.55
    rim = np.column_stack([ring * (1 + eave / np.array([x, y])), np.full(4, high - 0.06)])
    rise = rng.uniform(0.45, 0.75) * min(x, y)
    ridge_half = max(x - y, 0.15)
    top = np.array([[-ridge_half, 0, high + rise], [ridge_half, 0, high + rise]])
    if y > x:
        ridge_half = max(y - x, 0.15)
        top = np.array([[0, -ridge_half, high + rise], [0, ridge_half, high + rise]])
        slopes = [
            [rim[0], rim[1], top[0], top[0] + [1e-3, 0, 0]],
            [rim[1], rim[2], top[1], top[0]],
            [rim[2], rim[3], top[1], top[1] + [1e-3, 0, 0]],
            [rim[3], rim[0], top[0], top[1]],
        ]
    else:
        slopes = [
            [rim[0], rim[1], top[1], top[0]],
            [rim[1], rim[2], top[1] + [0, 1e-3, 0], top[1]],
            [rim[2], rim[3], top[0], top[1]],
            [rim[3], rim[0], top[0], top[0] + [0, 1e-3, 0]],
        ]
    roof = quads(np.array(slopes), roof_tint)
    soffit = quads(rim[::-1][None], trim * 0.8)
    fascia = beams(rim, np.roll(rim, -1, axis=0), 0.04, 0.16, trim)
    posts = beams(corner, corner + [0, 0, high], 0.14, 0.14, trim)
    spire = lathe(
        [0.09, 0.12, 0.03, 0.02],
        [high + rise - 0.1, high + rise + 0.25, high + rise + 0.4, high + rise + 2.2],
        7,
        trim,
    )
    return {
        ("siding", "building"): walls,
        ("glass", "building"): join(glass),
        ("paint", "building"): join([*frames, fascia, posts, soffit, spire]),
        ("shingle", "roof"): roof,
    }
