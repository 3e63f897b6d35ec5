"""Radio masts and high-voltage pylons, and the conductors between pylons."""

import dataclasses

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.furniture.cranes import aircraft_lamp
from synthdepth.maps.furniture.lattice import bands, between, lattice, square_rings
from synthdepth.maps.furniture.parts import (
    DARK_STEEL,
    STEEL,
    WHITE,
    Surfaces,
    boxes,
    choice,
    item,
    lathe,
    ringed,
    turned,
)
from synthdepth.maps.furniture.poles import catenary, wires
from synthdepth.maps.geometry import Geometry, box, copies, join, merge, place, yaw_matrix

_WARNING = ((0.40, 0.045, 0.03), (0.60, 0.59, 0.57))


def _triangle(z, radius) -> np.ndarray:
    """Triangular sections (n, 3, 3) about z."""
    z, radius = np.broadcast_arrays(np.asarray(z, float), np.asarray(radius, float))
    turn = 2 * np.pi * np.arange(3) / 3
    xy = radius[:, None, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.concatenate([xy, np.broadcast_to(z[:, None, None], (len(z), 3, 1))], axis=2)


def lattice_mast(rng: np.random.Generator, *, height_m: float) -> Surfaces:
    """A radio mast: slender and guyed, or tapered and standing by itself; aerials, dishes, lamp.

    Args:
        rng: of its make.
        height_m: of the lattice [m]; guys reach out by 0.6 of it.
    """
    guyed = bool(height_m > 25 and rng.random() < 0.5)
    banded = rng.random() < 0.45
    if guyed:
        radius = np.full(max(10, round(height_m / 0.9)), 0.35)
        rings = _triangle(np.linspace(0.3, height_m, len(radius)), radius)
        body = lattice(rings, 0.03, 0.012)
    else:
        n = max(8, round(height_m / 2.2))
        # Panels grow towards the foot as the mast does.
        z = height_m * (1 - (1 - np.linspace(0, 1, n)) ** 1.35)
        z = z[0] - 0.1 + (z - z[0]) * (height_m + 0.1) / (z[-1] - z[0])
        z = height_m - z[::-1] - 0.1
        half = np.interp(z, [0, 0.75 * height_m, height_m], [0.065 * height_m, 0.55, 0.5])
        body = lattice(square_rings(z, half), 0.05, 0.022, crossed=True)
    body = bands(body, height_m + 0.2, _WARNING, 7) if banded else body.tinted(STEEL)
    width = 0.4 if guyed else 0.55
    aerials = _aerials(rng, height_m, width)
    rod = round_bars(
        [[0, 0, height_m - 0.3]], [[0, 0, height_m + rng.uniform(2.5, 5)]], 0.025, WHITE
    )
    z = np.arange(0.6, height_m, 0.45)
    ladder = round_bars(
        np.column_stack([0 * z - 0.18, 0 * z, z]),
        np.column_stack([0 * z + 0.18, 0 * z, z]),
        0.01,
        STEEL,
        3,
    )
    cables = round_bars(
        [[a, 0.1, 0.3] for a in (-0.08, 0.0, 0.08)],
        [[a, 0.1, height_m - 2] for a in (-0.08, 0.0, 0.08)],
        0.02,
        DARK_STEEL,
        4,
    )
    foot = box((1.2, 1.2, 0.6), (0, 0, -0.25))
    if not guyed:
        side = 0.065 * height_m
        foot = boxes(
            (0.9, 0.9, 0.5), [[a * side, b * side, -0.2] for a in (-1, 1) for b in (-1, 1)]
        )
    hut = [
        box(
            (2.4, 3.0, 2.5),
            (3.2 if guyed else 0.065 * height_m + 2.6, 2.2, -0.05),
            (0.4, 0.4, 0.37),
        )
    ]
    hut.append(
        box((2.7, 3.3, 0.12), (3.2 if guyed else 0.065 * height_m + 2.6, 2.2, 2.45), DARK_STEEL)
    )
    parts = [
        {("paint", "pole"): join([body, ladder, cables, rod, *aerials])},
        item("building", paint=hut),
        item(concrete=[foot]),
        aircraft_lamp((0.2, 0, height_m)),
    ]
    if guyed:
        parts.append(_guys(height_m))
    return merge(parts)


def _guys(height_m: float) -> Surfaces:
    """Three guys at three or four levels, to anchors on the ground."""
    levels = height_m * np.linspace(0.3, 0.97, 3 if height_m < 45 else 4)
    turn = 2 * np.pi * np.arange(3) / 3
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(3)])
    near, far = 0.36 * height_m, 0.62 * height_m
    reach = np.where(np.arange(len(levels)) < 2, near, far)
    start = out[:, None] * 0.35 + levels[:, None] * [0, 0, 1.0]
    stop = out[:, None] * reach[:, None] + [0, 0, 0.35]
    stop = np.broadcast_to(stop, start.shape)
    lines = wires(catenary(start.reshape(-1, 3), stop.reshape(-1, 3), 0.008, 8), 0.011, STEEL)
    anchors = np.concatenate([out * near, out * far]) - [0, 0, 0.15]
    rotation = yaw_matrix(np.tile(turn, 2))
    block = copies(box((0.9, 0.5, 0.55)), anchors, rotation=rotation)
    return {("paint", "wire"): lines, ("concrete", "street_furniture"): block}


def _aerials(rng: np.random.Generator, height_m: float, width: float) -> list[Geometry]:
    """Sector panels in threes, drum dishes, whips."""
    parts = []
    panel = join(
        [
            box((0.14, 0.30, 1.9), (0.32, 0, 0), (0.5, 0.5, 0.49)),
            box((0.3, 0.06, 0.05), (0.14, 0, 0.3), STEEL),
            box((0.3, 0.06, 0.05), (0.14, 0, 1.5), STEEL),
            round_bars([[0.22, 0, -0.2]], [[0.22, 0, 2.1]], 0.03, STEEL),
        ]
    )
    for level in range(int(rng.integers(1, 4))):
        z = height_m - 2.2 - 2.9 * level
        if z < 0.4 * height_m:
            break
        trio = ringed(panel, 3, width + 0.5)
        arms = ringed(round_bars([[0, 0, 0.9]], [[0.75, 0, 0.9]], 0.03, STEEL), 3, width * 0.6)
        parts.append(turned(join([trio, arms]), rng.uniform(0, 2), (0, 0, z)))
    for _ in range(int(rng.integers(1, 5))):
        r, z = rng.uniform(0.3, 0.9), rng.uniform(0.5, 0.85) * height_m
        dish = lathe(
            [(0.3 * r, -0.25), (r, 0.0), (r, 0.28 * r + 0.1), (0.96 * r, 0.3 * r + 0.12)],
            14,
            (0.5, 0.5, 0.49),
        )
        spin = rng.uniform(0, 2 * np.pi)
        out = np.interp(z, [0, height_m], [width + 0.04 * height_m, width]) + 0.45
        at = (out * np.cos(spin), out * np.sin(spin), z)
        bracket = round_bars([[-0.6, 0, 0]], [[0, 0, 0]], 0.04, STEEL)
        parts += [turned(dish, spin, at, np.pi / 2), turned(bracket, spin, at)]
    return parts


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pylon:
    """A lattice tower of a high-voltage line; the line runs along x, crossarms lie along y.

    Attributes:
        height_m: of its peak.
        foot_m: half width at the ground.
        arms: (height, reach) [m] of each pair of crossarms, lowest first.
        insulator_m: length of the strings that hang from the arms' ends.
        tint: of the steel.
    """

    height_m: float
    foot_m: float
    arms: tuple[tuple[float, float], ...]
    insulator_m: float
    tint: tuple[float, float, float]

    @property
    def clamps(self) -> np.ndarray:
        """Where conductors hang, (2 * arms, 3) [m], in the pylon's frame."""
        ends = [[0.0, s * reach, z - self.insulator_m] for z, reach in self.arms for s in (-1, 1)]
        return np.array(ends)

    @property
    def peak(self) -> np.ndarray:
        """Where the earth wire is held, (1, 3) [m]."""
        return np.array([[0.0, 0.0, self.height_m]])


def draw_pylon(rng: np.random.Generator) -> Pylon:
    """A pylon of 24-46 m with one to three pairs of crossarms."""
    high = rng.uniform(26, 44)
    kinds = (
        ((0.72, 0.24),),
        ((0.62, 0.25), (0.80, 0.17)),
        ((0.58, 0.17), (0.71, 0.22), (0.84, 0.16)),
    )
    arms = kinds[rng.integers(3)]
    return Pylon(
        height_m=high,
        foot_m=high * rng.uniform(0.085, 0.11),
        arms=tuple((z * high, y * high) for z, y in arms),
        insulator_m=float(rng.uniform(1.4, 2.6)),
        tint=choice(rng, (STEEL, (0.36, 0.37, 0.37), (0.12, 0.16, 0.13))),
    )


def build_pylon(params: Pylon) -> Surfaces:
    """The tower with its crossarms, insulators and footings."""
    high, foot = params.height_m, params.foot_m
    waist = params.arms[0][0] - 0.06 * high
    neck = 0.028 * high
    n = 7
    # Panels shorten upwards with the width.
    z = waist * (1 - (1 - np.linspace(0, 1, n)) ** 1.5)
    half = np.interp(z, [0, waist], [foot, neck])
    legs = lattice(square_rings(z - 0.1, half), 0.09, 0.04, crossed=True)
    top = params.arms[-1][0]
    upper = np.linspace(waist - 0.1, top, max(2, round((top - waist) / (2.2 * neck))) + 1)
    body = lattice(square_rings(upper, neck), 0.07, 0.035, crossed=True)
    cap = lattice(
        between(square_rings([upper[-1]], [neck])[0], square_rings([high], [0.08])[0], 4),
        0.05,
        0.03,
    )
    arms, strings = [], []
    for level, reach in params.arms:
        deep = 0.035 * high
        for s in (-1, 1):
            root = np.array(
                [
                    [neck, s * neck, level],
                    [-neck, s * neck, level],
                    [-neck, s * neck, level + deep],
                    [neck, s * neck, level + deep],
                ]
            )
            end = np.array([0.0, s * reach, level]) + [
                [0.08, 0, 0],
                [-0.08, 0, 0],
                [-0.08, 0, 0.16],
                [0.08, 0, 0.16],
            ]
            arms.append(lattice(between(root, end, 5), 0.05, 0.025))
            strings.append(_insulator(params.insulator_m).moved([0, s * reach, level]))
    steel = join([legs, body, cap, *arms]).tinted(params.tint)
    feet = boxes((1.1, 1.1, 0.6), [[a * foot, b * foot, -0.3] for a in (-1, 1) for b in (-1, 1)])
    sign = box((0.02, 0.4, 0.3), (foot * 0.93, 0, 2.6), (0.5, 0.36, 0.03))
    return merge([{("paint", "pole"): join([steel, *strings, sign])}, item(concrete=[feet])])


def _insulator(length: float) -> Geometry:
    """A string of glass discs hanging from the origin."""
    discs = round(length / 0.18)
    z = -length + 0.12 + (np.arange(discs) + 0.5) * (length - 0.2) / discs
    one = lathe([(0.03, -0.03), (0.14, -0.02), (0.05, 0.05)], 7, (0.12, 0.16, 0.15))
    rod = round_bars([[0, 0, -length]], [[0, 0, 0.05]], 0.02, DARK_STEEL, 4)
    return join([rod, copies(one, np.column_stack([0 * z, 0 * z, z]))])


def pylon(rng: np.random.Generator) -> Surfaces:
    """One drawn pylon; its line runs along x."""
    return build_pylon(draw_pylon(rng))


def conductors(params: Pylon, start, start_yaw, stop, stop_yaw, sag_share: float) -> Surfaces:
    """The conductors and the earth wire between two pylons of one make.

    Args:
        params: of both pylons.
        start, stop: (3,) their feet [m].
        start_yaw, stop_yaw: where their x axes point [rad].
        sag_share: sag over span.
    """
    ends = []
    for foot, yaw in ((start, start_yaw), (stop, stop_yaw)):
        local = np.concatenate([params.clamps, params.peak])
        ends.append(local @ yaw_matrix(yaw).T + np.asarray(foot, np.float64))
    share = np.full(len(ends[0]), sag_share)
    # The earth wire is the tightest.
    share[-1] *= 0.75
    lines = catenary(ends[0], ends[1], share, 14)
    return {("paint", "wire"): wires(lines, 0.018, (0.16, 0.16, 0.165))}


def power_line(rng: np.random.Generator, positions) -> Surfaces:
    """Pylons of one make at consecutive feet (k, 3) [m], k >= 2, and their conductors."""
    feet = np.asarray(positions, np.float64).reshape(-1, 3)
    params = draw_pylon(rng)
    along = np.gradient(feet[:, :2], axis=0)
    yaw = np.arctan2(along[:, 1], along[:, 0])
    model = build_pylon(params)
    towers = [place(model, foot, turn) for foot, turn in zip(feet, yaw, strict=True)]
    share = float(rng.uniform(0.02, 0.035))
    spans = [
        conductors(params, feet[i], yaw[i], feet[i + 1], yaw[i + 1], share)
        for i in range(len(feet) - 1)
    ]
    return merge([*towers, *spans])
