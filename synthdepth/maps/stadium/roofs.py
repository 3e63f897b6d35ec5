"""Roofs of stands: sheets on trusses that stand on columns, or reach out from behind.

Frame of the stand: x along it, the pitch towards -y, its front wall at y = 0.
"""

import dataclasses
import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import Model, box, copies, join, quads

_SHEET_M = 0.12


@dataclasses.dataclass(frozen=True, kw_only=True)
class Roof:
    """The roof of a stand [m].

    Attributes:
        kind: "cantilever", "posts" (columns at the front) or "goalpost" (a girder on two towers).
        length_m: along the stand.
        front_y_m, back_y_m: of its edges.
        front_m, back_m: heights of its edges, of the sheets' underside.
        depth_m: of the trusses at the columns.
        bays: between trusses.
        tint: (3,) of the sheets.
        steel: (3,) of the structure.
        lights: lamps along the front edge.
    """

    kind: str
    length_m: float
    front_y_m: float
    back_y_m: float
    front_m: float
    back_m: float
    depth_m: float
    bays: int
    tint: np.ndarray
    steel: np.ndarray
    lights: int


def draw_roof(
    rng: np.random.Generator, length_m: float, depth_m: float, top_m: float, large: bool
) -> Roof:
    """A roof for a stand of a length, depth and height of its last step."""
    if large:
        kind = str(rng.choice(["cantilever", "posts", "goalpost"], p=[0.6, 0.2, 0.2]))
    else:
        kind = str(rng.choice(["cantilever", "posts"], p=[0.25, 0.75]))
    back = top_m + rng.uniform(3.4, 5.0) if large else top_m + rng.uniform(2.5, 3.0)
    slope = {"cantilever": rng.uniform(0.05, 0.16), "posts": -rng.uniform(0.02, 0.1)}
    overhang = rng.uniform(0.3, 2.0)
    run = depth_m + overhang
    steel = [(0.5, 0.5, 0.49), (0.05, 0.055, 0.06), (0.1, 0.16, 0.3), (0.26, 0.27, 0.28)]
    tints = [(0.45, 0.46, 0.47), (0.6, 0.6, 0.59), (0.3, 0.32, 0.34), (0.22, 0.1, 0.08)]
    return Roof(
        kind=kind,
        length_m=length_m + rng.uniform(0.5, 2.0),
        front_y_m=-overhang,
        back_y_m=depth_m + 0.5,
        front_m=back + slope.get(kind, 0.03) * run,
        back_m=back,
        depth_m=float(np.clip(0.09 * run, 0.5, 2.2)),
        bays=max(round(length_m / (6.0 if large else 4.0)), 1),
        tint=np.array(tints[rng.integers(4)]) * rng.uniform(0.85, 1.1),
        steel=np.array(steel[rng.integers(4)]),
        lights=int(length_m // 9) if large and rng.random() < 0.35 else 0,
    )


def _z(roof: Roof, y) -> np.ndarray:
    """Height of the sheets' underside at y."""
    t = (np.asarray(y, float) - roof.front_y_m) / (roof.back_y_m - roof.front_y_m)
    return roof.front_m + t * (roof.back_m - roof.front_m)


def _sheets(roof: Roof) -> np.ndarray:
    half = roof.length_m / 2
    n = max(round(roof.length_m / 12), 1)
    x = np.linspace(-half, half, n + 1)
    y0, y1, z0, z1 = roof.front_y_m, roof.back_y_m, roof.front_m, roof.back_m
    h = _SHEET_M
    corners = []
    for a, b in itertools.pairwise(x):
        corners += [
            [[a, y0, z0 + h], [b, y0, z0 + h], [b, y1, z1 + h], [a, y1, z1 + h]],
            [[b, y0, z0], [a, y0, z0], [a, y1, z1], [b, y1, z1]],
            [[b, y1, z1], [a, y1, z1], [a, y1, z1 + h], [b, y1, z1 + h]],
        ]
    for x in (-half, half):
        corners.append([[x, y0, z0], [x, y1, z1], [x, y1, z1 + h], [x, y0, z0 + h]])
    return np.array(corners)


def _trusses(roof: Roof, x: np.ndarray) -> list:
    """Chords and webs under the sheets: deepest where the columns stand."""
    n = max(round((roof.back_y_m - roof.front_y_m) / 1.8), 3)
    y = np.linspace(roof.front_y_m + 0.15, roof.back_y_m - 0.35, n + 1)
    top = _z(roof, y) - 0.16
    share = np.linspace(0.25, 1, n + 1) if roof.kind == "cantilever" else np.full(n + 1, 0.6)
    low = top - roof.depth_m * share
    upper = np.column_stack([y, top])
    lower = np.column_stack([y, low])
    start = [upper[:-1], lower[:-1], upper, lower[:-1]]
    end = [upper[1:], lower[1:], lower, upper[1:]]
    a, b = np.concatenate(start), np.concatenate(end)
    chords = 2 * n

    def spread(points):
        whole = np.empty((len(x), len(points), 3))
        whole[..., 0], whole[..., 1:] = x[:, None], points
        return whole.reshape(-1, 3)

    return [
        beams(spread(a[:chords]), spread(b[:chords]), 0.12, 0.14),
        round_bars(spread(a[chords:]), spread(b[chords:]), 0.045, sides=5),
    ]


def stand_roof(roof: Roof, colour) -> Model:
    """Build a roof, with its fascia in a club's `colour` (3,)."""
    half = roof.length_m / 2
    x = np.linspace(-half + 0.4, half - 0.4, roof.bays + 1)
    steel = _trusses(roof, x)
    # Purlins.
    y = np.arange(roof.front_y_m + 0.2, roof.back_y_m - 0.1, 1.7)
    z = _z(roof, y) - 0.08
    a = np.column_stack([np.full(len(y), -half + 0.1), y, z])
    steel.append(beams(a, a * [-1, 1, 1], 0.08, 0.14))
    back_y = roof.back_y_m - 0.35
    columns = [(x, back_y)]
    if roof.kind == "posts":
        columns.append((x[:: max(1, round(6 / (roof.length_m / roof.bays)))], 0.9))
    if roof.kind == "goalpost":
        columns.append((np.array([-half + 0.5, half - 0.5]), roof.front_y_m + 0.8))
    for at, y in columns:
        heavy = 0.18 if roof.kind == "goalpost" and len(at) == 2 else 0.11
        foot = np.column_stack([at, np.full(len(at), y), np.full(len(at), -0.1)])
        head = foot.copy()
        head[:, 2] = _z(roof, y) - 0.15
        steel.append(beams(foot, head, 1.6 * heavy, 2.2 * heavy))
    if roof.kind == "goalpost":
        # A lattice girder over the roof's front edge.
        y, low = roof.front_y_m + 0.8, roof.front_m + 0.2
        n = max(round(roof.length_m / 3.0), 4)
        gx = np.linspace(-half + 0.5, half - 0.5, n + 1)
        deep = 2.6
        a = np.column_stack([gx, np.full(n + 1, y), np.full(n + 1, low)])
        b = a + [0, 0, deep]
        steel.append(beams(a[:-1], a[1:], 0.2, 0.22))
        steel.append(beams(b[:-1], b[1:], 0.2, 0.22))
        odd = np.arange(n) % 2 == 0
        steel.append(
            round_bars(
                np.where(odd[:, None], a[:-1], b[:-1]),
                np.where(odd[:, None], b[1:], a[1:]),
                0.07,
                sides=6,
            )
        )
        steel.append(round_bars(a, b, 0.05, sides=5))
    fascia = box((roof.length_m, 0.06, 0.55), (0, roof.front_y_m - 0.04, roof.front_m - 0.3))
    gutter = beams(
        [[-half, roof.back_y_m + 0.08, roof.back_m - 0.05]],
        [[half, roof.back_y_m + 0.08, roof.back_m - 0.05]],
        0.16,
        0.14,
    )
    model = {
        ("sheeting", "roof"): quads(_sheets(roof), roof.tint),
        ("paint", "roof"): join(
            [join(steel).tinted(roof.steel), fascia.tinted(colour), gutter.tinted((0.3, 0.3, 0.3))]
        ),
    }
    if roof.lights:
        lx = (np.arange(roof.lights) + 0.5) / roof.lights * roof.length_m - half
        at = np.column_stack(
            [lx, np.full(roof.lights, roof.front_y_m - 0.35), np.full(roof.lights, roof.front_m)]
        )
        face = quads(
            [[[0.25, -0.1, -0.36], [-0.25, -0.1, -0.36], [-0.25, -0.3, 0.0], [0.25, -0.3, 0.0]]]
        )
        case = box((0.56, 0.3, 0.42), (0, 0.06, -0.4), (0.06, 0.06, 0.065))
        model["floodlight", "roof"] = copies(face, at).tinted((0.75, 0.76, 0.78))
        model["paint", "roof"] = join([model["paint", "roof"], copies(case, at)])
    return model
