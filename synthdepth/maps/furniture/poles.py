"""Utility poles and their wires, which hang as catenaries between consecutive poles."""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import Geometry, box, copies, cross, geometry, join, tube, yaw_matrix

Surfaces = dict[tuple[str, str], Geometry]

_CONDUCTOR = ("paint", (0.10, 0.10, 0.105))
_CABLE = ("paint", (0.025, 0.025, 0.026))
STEEL = (0.26, 0.27, 0.28)


def catenary(start: np.ndarray, end: np.ndarray, sag_share, segments: int = 10) -> np.ndarray:
    """Hanging wires: (k, segments + 1, 3) [m] from `start` to `end`, each (k, 3) [m].

    y = C (cosh(x / C) - 1) with C = L^2 / 8 s for a span L and a sag s = `sag_share` * L, hung
    below the chord (exact where both ends are level).
    """
    a = np.asarray(start, np.float64).reshape(-1, 3)
    b = np.asarray(end, np.float64).reshape(-1, 3)
    span = np.linalg.norm(b - a, axis=1)[:, None]
    c = span / (8 * np.broadcast_to(np.asarray(sag_share, np.float64), len(a))[:, None])
    t = np.linspace(0, 1, segments + 1)
    points = a[:, None] + t[:, None] * (b - a)[:, None]
    x = (t - 0.5) * span
    points[..., 2] -= c * (np.cosh(span / 2 / c) - np.cosh(x / c))
    return points


def wires(points: np.ndarray, radius_m: float, tint, sides: int = 3) -> Geometry:
    """Tubes along k polylines of equal length: `points` (k, n, 3) [m]; open ends."""
    k, n = points.shape[:2]
    along = points[:, -1] - points[:, 0]
    flat = cross(along, [0, 0, 1.0])
    flat = np.where(np.linalg.norm(flat, axis=1, keepdims=True) > 1e-6, flat, [1.0, 0, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    up = cross(flat, along)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.cos(turn)[:, None] * flat[:, None] - np.sin(turn)[:, None] * up[:, None]
    v = points[:, :, None] + radius_m * ring[:, None]  # (k, n, sides + 1, 3)
    uv = np.zeros((k, n, sides + 1, 2))
    uv[..., 0] = turn * radius_m
    uv[..., 1] = np.linspace(0, 1, n)[:, None] * np.linalg.norm(along, axis=1)[:, None, None]
    i = np.arange(k * n * (sides + 1)).reshape(k, n, sides + 1)
    a, b, c, d = i[:, :-1, :-1], i[:, :-1, 1:], i[:, 1:, 1:], i[:, 1:, :-1]
    faces = np.stack([a, c, b, a, d, c], axis=-1).reshape(-1, 3)
    return geometry(v, faces, uv, tint)


@dataclasses.dataclass(frozen=True, kw_only=True)
class UtilityLine:
    """A run of wooden poles and what hangs on them.

    Attributes:
        bases: (k, 3) ground at the poles [m].
        heights_m: (k,) above ground.
        yaws_rad: (k,) of the line's direction at each pole (crossarms stand across it).
        leans_rad: (k, 2) about x and y.
        transformers: (k,) bool.
        conductors: 2 or 3 on the crossarm.
        sag_share: sag over span, one for all wires of the line.
        tint: (3,) of the wood.
        guys: stay wires at both ends.
        houses: (m, 3) points on eaves that get a drop wire from the nearest pole [m].
    """

    bases: np.ndarray
    heights_m: np.ndarray
    yaws_rad: np.ndarray
    leans_rad: np.ndarray
    transformers: np.ndarray
    conductors: int
    sag_share: float
    tint: np.ndarray
    guys: bool
    houses: np.ndarray

    @property
    def drop_points(self) -> np.ndarray:
        """Where drop wires leave the poles, (k, 3) [m]."""
        return _on_poles(self, np.array([[0.0, 0.0, _CABLE_BELOW_TOP_M + 0.3]]))[:, 0]


_CABLE_BELOW_TOP_M = -2.6
_ARM_BELOW_TOP_M = -0.45


def draw_utility_line(
    rng: np.random.Generator, positions: np.ndarray, houses: np.ndarray | None = None
) -> UtilityLine:
    """A line along consecutive pole bases `positions` (k, 3) [m], k >= 2; see `UtilityLine`."""
    bases = np.asarray(positions, np.float64).reshape(-1, 3)
    if len(bases) < 2:
        raise ValueError(f"a utility line needs 2 poles or more, not {len(bases)}")
    k = len(bases)
    along = np.gradient(bases[:, :2], axis=0)
    age = rng.uniform(0, 1)
    tint = (1 - age) * np.array([0.14, 0.095, 0.06]) + age * np.array([0.26, 0.235, 0.205])
    return UtilityLine(
        bases=bases,
        heights_m=rng.uniform(9.3, 10.4) + rng.uniform(-0.3, 0.6, k),
        yaws_rad=np.arctan2(along[:, 1], along[:, 0]),
        leans_rad=np.radians(np.clip(rng.normal(0, 0.7, (k, 2)), -1.8, 1.8)),
        transformers=rng.random(k) < 0.2,
        conductors=int(rng.choice([2, 3])),
        sag_share=float(rng.uniform(0.011, 0.02)),
        tint=tint,
        guys=bool(rng.random() < 0.7),
        houses=np.zeros((0, 3)) if houses is None else np.asarray(houses, float).reshape(-1, 3),
    )


def lean_matrix(leans_rad: np.ndarray) -> np.ndarray:
    """Small rotations about x and y, (k, 3, 3)."""
    x, y = leans_rad.T
    o, i = np.zeros_like(x), np.ones_like(x)
    about_x = np.stack(
        [np.stack([i, o, o], -1), np.stack([o, np.cos(x), -np.sin(x)], -1),
         np.stack([o, np.sin(x), np.cos(x)], -1)], -2
    )  # fmt: skip
    about_y = np.stack(
        [np.stack([np.cos(y), o, np.sin(y)], -1), np.stack([o, i, o], -1),
         np.stack([-np.sin(y), o, np.cos(y)], -1)], -2
    )  # fmt: skip
    return about_x @ about_y


def _rotations(line: UtilityLine) -> np.ndarray:
    return lean_matrix(line.leans_rad) @ yaw_matrix(line.yaws_rad)


def _on_poles(line: UtilityLine, points: np.ndarray) -> np.ndarray:
    """Points (m, 3) in a pole's frame, z from its top, on all poles: (k, m, 3) [m]."""
    local = np.broadcast_to(points, (len(line.bases), *points.shape)).copy()
    local[..., 2] += line.heights_m[:, None]
    return np.einsum("kij,kmj->kmi", _rotations(line), local) + line.bases[:, None]


def _pole_head(tint: np.ndarray, conductors: int) -> Surfaces:
    """Crossarm, braces, insulators and bracket; z from the pole's top, wires along x."""
    arm = _ARM_BELOW_TOP_M
    wood = [box((0.1, 2.4, 0.12), (0.15, 0, arm - 0.12), tint)]
    steel = [tube([[0.16, s * 0.8, arm - 0.06], [0.13, 0, arm - 0.75]], 0.022, 4) for s in (1, -1)]
    steel.append(tube([[0.0, 0, _CABLE_BELOW_TOP_M], [0.22, 0, _CABLE_BELOW_TOP_M]], 0.03, 4))
    profile = np.array([0.0, 0.07, 0.17])
    insulators = [
        tube([[x, y, z + h] for h in profile], [0.028, 0.06, 0.045], 5, (0.16, 0.13, 0.11))
        for x, y, z in _insulators(conductors)
    ]
    return {
        ("wood", "pole"): join(wood),
        ("paint", "pole"): join([*insulators, join(steel).tinted(STEEL)]),
    }


def _insulators(conductors: int) -> np.ndarray:
    """Feet of the insulators in the head's frame, (conductors, 3) [m]."""
    y = np.array([-1.05, 1.05] if conductors == 2 else [-1.05, -0.45, 1.05])
    return np.column_stack([np.full(len(y), 0.15), y, np.full(len(y), _ARM_BELOW_TOP_M - 0.01)])


def _transformer() -> Surfaces:
    """A pole-mounted can; z from the pole's top."""
    z = -2.1
    can = tube([[0.02, -0.46, z + h] for h in (0, 0.03, 0.85, 0.92)], [0.24, 0.27, 0.27, 0.2], 10)
    bush = [tube([[dx, -0.46, z + 0.9], [dx, -0.46, z + 1.15]], 0.04, 5) for dx in (-0.1, 0.14)]
    bracket = [box((0.08, 0.34, 0.08), (0.02, -0.2, z + h)) for h in (0.15, 0.65)]
    return {("paint", "pole"): join([can, *bush, *bracket]).tinted((0.27, 0.28, 0.28))}


def build_utility_line(line: UtilityLine) -> Surfaces:
    """Poles, wires, drop wires and stays of a line; geometry by (material, label)."""
    rotation = _rotations(line)
    # 12 m long with 1.8 m in the ground; here only 0.4 m of that.
    levels = np.array([-0.4, 3.0, 6.5, 10.0])
    shaft = tube(
        np.column_stack([np.zeros((4, 2)), levels]), [0.165, 0.15, 0.13, 0.11], 8, line.tint
    )
    stretch = np.column_stack([np.ones((len(line.bases), 2)), line.heights_m / 10.0])
    tops = _on_poles(line, np.zeros((1, 3)))[:, 0]
    parts: list[tuple[tuple[str, str], Geometry]] = [
        (("wood", "pole"), copies(shaft, line.bases, rotation=rotation, scale=stretch))
    ]
    for key, part in _pole_head(line.tint * 0.9, line.conductors).items():
        parts.append((key, copies(part, tops, rotation=rotation)))
    with_can = line.transformers
    for key, part in _transformer().items():
        parts.append((key, copies(part, tops[with_can], rotation=rotation[with_can])))

    feet = _on_poles(line, _insulators(line.conductors) + [0, 0, 0.16])
    spans = catenary(feet[:-1].reshape(-1, 3), feet[1:].reshape(-1, 3), line.sag_share)
    parts.append(((_CONDUCTOR[0], "wire"), wires(spans, 0.009, _CONDUCTOR[1])))
    hooks = _on_poles(line, np.array([[0.2, 0.0, _CABLE_BELOW_TOP_M + 0.02]]))[:, 0]
    low = catenary(hooks[:-1], hooks[1:], line.sag_share * 0.8)
    parts.append(((_CABLE[0], "wire"), wires(low, 0.017, _CABLE[1])))
    if len(line.houses):
        drops = line.drop_points
        gap = np.linalg.norm(line.houses[:, None, :2] - drops[None, :, :2], axis=2)
        nearest = drops[np.argmin(gap, axis=1)]
        parts += _drop_parts(nearest, line.houses, np.full(len(nearest), 0.02))
    if line.guys:
        ends = _on_poles(line, np.array([[0.0, 0.0, -0.8]]))[[0, -1], 0]
        away = np.column_stack([np.cos(line.yaws_rad), np.sin(line.yaws_rad)])[[0, -1]]
        foot = line.bases[[0, -1]] + np.column_stack([away * [[-3.2], [3.2]], [-0.1, -0.1]])
        parts.append(((_CABLE[0], "wire"), wires(np.stack([ends, foot], 1), 0.009, STEEL)))
    return _by_key(parts)


def _by_key(parts: list[tuple[tuple[str, str], Geometry]]) -> Surfaces:
    grouped: dict[tuple[str, str], list[Geometry]] = {}
    for key, part in parts:
        grouped.setdefault(key, []).append(part)
    return {key: join(group) for key, group in grouped.items()}


def _drop_parts(start, end, sag_share) -> list[tuple[tuple[str, str], Geometry]]:
    spans = catenary(start, end, sag_share, segments=8)
    return [((_CABLE[0], "wire"), wires(spans, 0.01, _CABLE[1]))]


def utility_line(
    rng: np.random.Generator, positions: np.ndarray, houses: np.ndarray | None = None
) -> Surfaces:
    """Poles at consecutive bases `positions` (k, 3), with wires and drops to `houses` (m, 3)."""
    return build_utility_line(draw_utility_line(rng, positions, houses))


def service_drop(
    rng: np.random.Generator, pole_top: np.ndarray, house_point: np.ndarray
) -> Surfaces:
    """Drop wires from `pole_top` to `house_point`, each (3,) or (k, 3) [m]."""
    start = np.asarray(pole_top, np.float64).reshape(-1, 3)
    return _by_key(_drop_parts(start, house_point, rng.uniform(0.015, 0.03, len(start))))
