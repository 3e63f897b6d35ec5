"""Poses of a skeleton of twelve limb joints; x forward, y to the left, z up.

Lengths of the segments over stature are those of Drillis & Contini 1966 (Winter, "Biomechanics and
Motor Control of Human Movement", 4th ed., figure 4.1).
"""

import dataclasses

import numpy as np

HIP, SHOULDER, CHIN = 0.530, 0.806, 0.870  # heights over stature
SEAT_M = 0.45
_HIP_HALF, _SHOULDER_HALF = 0.050, 0.099
_UPPER_ARM, _FOREARM, _HAND = 0.180, 0.146, 0.100
_THIGH, _SHANK, ANKLE = 0.245, 0.246, 0.039


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pose:
    """Angles [deg] of the joints; pairs are (left, right).

    Attributes:
        lean, twist: of the trunk, forwards and to the left.
        nod, turn: of the head against the trunk, down and to the left.
        arms: each (flexion forwards, abduction outwards, elbow, how far the elbow's bend points
            inwards across the body).
        legs: each (flexion forwards, abduction outwards, knee, toes up).
        seated: thighs rest at `SEAT_M`; otherwise the lower foot stands on the ground.
    """

    lean: float = 1.0
    twist: float = 0.0
    nod: float = 4.0
    turn: float = 0.0
    arms: tuple[tuple[float, float, float, float], ...] = ((-2, 7, 14, 20), (-2, 7, 14, 20))
    legs: tuple[tuple[float, float, float, float], ...] = ((0, 2, 2, 0), (0, 2, 2, 0))
    seated: bool = False


_AT_EASE = ((-4, 6, 10, 20), (2, 8, 18, 30))
POSES: dict[str, tuple[Pose, ...]] = {
    "standing": (
        Pose(arms=_AT_EASE, legs=((0, 4, 3, 0), (2, 6, 8, 4))),
        Pose(lean=2, arms=((12, 14, 62, 50), (12, 14, 66, 55)), legs=((0, 6, 2, 0), (0, 6, 2, 0))),
        Pose(turn=25, arms=((-14, 26, 78, 40), (0, 6, 12, 20)), legs=((3, 9, 5, 0), (-2, 3, 2, 0))),
        Pose(nod=12, arms=((24, 4, 88, 66), (22, 4, 96, 70)), legs=((0, 4, 2, 0), (1, 5, 4, 0))),
    ),
    "walking": (
        Pose(
            lean=4, twist=6, arms=((-24, 5, 14, 10), (22, 5, 26, 15)),
            legs=((25, 1, 5, 17), (-17, 1, 16, -27)),
        ),
        Pose(
            lean=3, arms=((-6, 6, 16, 12), (6, 6, 20, 12)), legs=((2, 1, 6, 0), (17, 1, 52, -16)),
        ),
    ),
    "talking": (
        Pose(
            turn=14, arms=((26, 22, 82, 12), (-3, 7, 14, 20)), legs=((0, 5, 3, 0), (4, 7, 8, 0)),
        ),
        Pose(
            lean=3, twist=-8, arms=((20, 16, 74, 20), (34, 20, 60, 5)),
            legs=((6, 4, 8, 0), (-4, 4, 3, 0)),
        ),
        Pose(arms=((18, 8, 96, 76), (56, 24, 34, 0)), legs=((0, 4, 2, 0), (3, 6, 5, 0))),
    ),
    "sitting": (
        Pose(
            lean=-6, arms=((24, 8, 58, 40), (24, 8, 58, 40)), legs=((86, 6, 86, 0), (84, 7, 80, 0)),
            seated=True,
        ),
        Pose(
            lean=16, nod=14, arms=((52, 4, 52, 45), (50, 4, 58, 45)),
            legs=((87, 8, 98, 0), (85, 9, 78, 0)), seated=True,
        ),
    ),
    "phone": (
        Pose(
            turn=6, nod=7, arms=((-2, 7, 14, 20), (38, 24, 138, 34)),
            legs=((0, 4, 2, 0), (3, 5, 6, 0)),
        ),
        Pose(nod=26, arms=((22, 4, 92, 38), (24, 4, 96, 34)), legs=((0, 4, 2, 0), (2, 5, 6, 0))),
    ),
    "running": (
        Pose(
            lean=12, twist=10, nod=-4, arms=((-46, 10, 92, 20), (34, 8, 96, 30)),
            legs=((46, 1, 66, 4), (-22, 1, 34, -34)),
        ),
        Pose(
            lean=11, twist=-6, nod=-4, arms=((20, 10, 94, 25), (-28, 10, 86, 20)),
            legs=((4, 1, 18, 0), (8, 1, 104, -30)),
        ),
    ),
    "player_kick": (
        Pose(
            lean=-6, twist=18, nod=24, arms=((30, 66, 28, 10), (-34, 48, 24, 10)),
            legs=((-8, 9, 14, 4), (48, 2, 14, -34)),
        ),
        Pose(
            lean=14, twist=-16, nod=20, arms=((36, 44, 40, 20), (-30, 52, 36, 10)),
            legs=((8, 6, 24, 2), (-34, 4, 76, -30)),
        ),
    ),
    "player_ready": (
        Pose(
            lean=20, nod=-10, arms=((18, 24, 58, 20), (18, 24, 62, 20)),
            legs=((34, 13, 42, 4), (32, 13, 40, 4)),
        ),
        Pose(lean=3, arms=((8, 32, 96, 40), (6, 34, 98, 40)), legs=((0, 9, 3, 0), (2, 9, 5, 0))),
    ),
    "arms_up": (
        Pose(lean=-3, nod=-8, arms=((158, 22, 16, 0), (164, 26, 22, 0))),
        Pose(
            lean=2, nod=-6, arms=((142, 34, 46, 20), (150, 30, 60, 20)),
            legs=((2, 6, 6, 0), (4, 6, 8, 0)),
        ),
    ),
}  # fmt: skip


@dataclasses.dataclass(frozen=True, kw_only=True)
class Skeleton:
    """Joints of a posed body; [0] is left, [1] is right.

    Attributes:
        body_m: the stature of an adult with this body: lengths are shares of it.
        pelvis: (3,) between the hips [m].
        pose: what it was posed by.
        skull: (3, 3) rotation of the head.
        neck: (3,) where the head sits, at the chin's height [m].
        arms: (2, 4, 3) shoulder, elbow, wrist, fingertips [m].
        legs: (2, 3, 3) hip, knee, ankle [m].
        feet: (2, 3, 3) rotations of the feet; x along the sole.
    """

    body_m: float
    pelvis: np.ndarray
    pose: Pose
    skull: np.ndarray
    neck: np.ndarray
    arms: np.ndarray
    legs: np.ndarray
    feet: np.ndarray

    def trunk(self, height) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 3) on the spine and rotations (n, 3, 3) at heights (n,) over stature."""
        return _trunk(self.pose, self.body_m, self.pelvis, np.asarray(height, np.float64))


def _about_y(angle_deg) -> np.ndarray:
    """Rotations that tip +z towards +x, (..., 3, 3)."""
    a = np.radians(np.asarray(angle_deg, np.float64))
    c, s, o, i = np.cos(a), np.sin(a), np.zeros_like(a), np.ones_like(a)
    rows = [np.stack([c, o, s], -1), np.stack([o, i, o], -1), np.stack([-s, o, c], -1)]
    return np.stack(rows, -2)


def _about_z(angle_deg) -> np.ndarray:
    a = np.radians(np.asarray(angle_deg, np.float64))
    c, s, o, i = np.cos(a), np.sin(a), np.zeros_like(a), np.ones_like(a)
    rows = [np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, i], -1)]
    return np.stack(rows, -2)


def _trunk(pose: Pose, body_m: float, pelvis: np.ndarray, height: np.ndarray):
    # The trunk bends just above the hips and twists along its length.
    bent = np.clip((height - 0.50) / 0.08, 0, 1)
    twisted = np.clip((height - 0.54) / 0.24, 0, 1)
    rotation = _about_y(pose.lean * bent) @ _about_z(pose.twist * twisted)
    up = ((height - HIP) * body_m)[:, None] * _about_y(pose.lean * bent)[:, :, 2]
    return pelvis + up, rotation


def _arm(shoulder, frame, side: float, angles, body_m: float) -> np.ndarray:
    flexion, abduction, elbow, inward = np.radians(angles)
    upper = np.array(
        [np.sin(flexion) * np.cos(abduction), side * np.sin(abduction),
         -np.cos(flexion) * np.cos(abduction)]
    )  # fmt: skip
    bend = np.array([np.cos(inward), -side * np.sin(inward), 0.45])
    bend -= (bend @ upper) * upper
    bend /= np.linalg.norm(bend)
    lower = np.cos(elbow) * upper + np.sin(elbow) * bend
    steps = np.stack([_UPPER_ARM * upper, _FOREARM * lower, _HAND * lower]) * body_m
    joints = np.cumsum(np.concatenate([np.zeros((1, 3)), steps]), axis=0)
    return shoulder + joints @ frame.T


def _leg(hip, side: float, angles, body_m: float) -> np.ndarray:
    flexion, abduction, knee, _ = np.radians(angles)
    out = side * np.sin(abduction)
    along = [[np.sin(a), -np.cos(a)] for a in (flexion, flexion - knee)]
    steps = np.array([[x * np.cos(abduction), out, z * np.cos(abduction)] for x, z in along])
    # Shins hang straight down from spread knees.
    steps[1, 1] *= 0.4
    steps[1] /= np.linalg.norm(steps[1])
    steps *= np.array([[_THIGH], [_SHANK]]) * body_m
    return hip + np.cumsum(np.concatenate([np.zeros((1, 3)), steps]), axis=0)


def posed(pose: Pose, body_m: float, shoulders: float = 1.0, hips: float = 1.0) -> Skeleton:
    """A skeleton in a pose, on the ground below its pelvis.

    Args:
        pose: angles of the joints.
        body_m: see `Skeleton`.
        shoulders, hips: widths over the average.
    """
    sides = (1.0, -1.0)
    origin = np.zeros(3)
    legs = np.stack(
        [
            _leg(np.array([0, s * _HIP_HALF * hips * body_m, 0]), s, angles, body_m)
            for s, angles in zip(sides, pose.legs, strict=True)
        ]
    )
    feet = np.stack(
        [_about_z(8 * s) @ _about_y(-angles[3]) for s, angles in zip(sides, pose.legs, strict=True)]
    )
    if pose.seated:
        rise = SEAT_M + 0.046 * body_m
    else:
        # Heel and ball of each sole, seen from the ankle.
        sole = np.array([[-0.045, 0, -ANKLE], [0.09, 0, -ANKLE]]) * body_m
        rise = -(legs[:, None, 2] + np.einsum("fij,kj->fki", feet, sole))[..., 2].min()
    lift = np.array([0, 0, rise])
    (at, neck), (frame, top) = _trunk(pose, body_m, origin, np.array([SHOULDER, CHIN]))
    arms = np.stack(
        [
            _arm(
                at + frame @ [0, s * _SHOULDER_HALF * shoulders * body_m, 0], frame, s, angles,
                body_m,
            )
            for s, angles in zip(sides, pose.arms, strict=True)
        ]
    )  # fmt: skip
    # The head keeps more upright than the trunk.
    skull = _about_z(pose.turn) @ top @ _about_y(pose.nod - 0.7 * pose.lean)
    return Skeleton(
        body_m=body_m, pelvis=origin + lift, pose=pose, skull=skull, neck=neck + lift,
        arms=arms + lift, legs=legs + lift, feet=feet,
    )  # fmt: skip


def varied(rng: np.random.Generator, name: str) -> Pose:
    """A pose of a kind (a key of `POSES`), mirrored or not, its angles shaken by a few degrees."""
    if name not in POSES:
        raise KeyError(f"pose {name!r} is not one of {sorted(POSES)}")
    variants = POSES[name]
    pose = variants[rng.integers(len(variants))]
    arms = np.array(pose.arms, float) + rng.normal(0, (4, 2, 5, 5), (2, 4))
    legs = np.array(pose.legs, float) + rng.normal(0, (1.5, 0.8, 2, 1), (2, 4))
    legs[:, 2] = np.maximum(legs[:, 2], 1)
    lean, twist, nod, turn = rng.normal(0, (1.5, 3, 4, 10))
    flip = bool(rng.random() < 0.5)
    sign = -1.0 if flip else 1.0
    return Pose(
        lean=pose.lean + lean,
        twist=sign * pose.twist + twist,
        nod=pose.nod + nod,
        turn=sign * pose.turn + turn,
        arms=tuple(map(tuple, arms[::-1] if flip else arms)),
        legs=tuple(map(tuple, legs[::-1] if flip else legs)),
        seated=pose.seated,
    )
