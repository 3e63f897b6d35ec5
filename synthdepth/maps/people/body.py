"""Flesh and clothes on a posed skeleton, sorted by what gets a colour of its own."""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import Geometry, box, copies, geometry, join, tube
from synthdepth.maps.people.skeleton import ANKLE, SEAT_M, Pose, Skeleton, posed

# The parts of a person that are coloured apart, and their materials.
SLOTS = {
    "skin": "paint",
    "hair": "paint",
    "shoes": "paint",
    "top": "fabric",
    "inner": "fabric",
    "bottom": "fabric",
    "extra": "fabric",
}
TOPS = ("tshirt", "shirt", "jacket", "coat", "jersey")
BOTTOMS = ("trousers", "shorts", "skirt")
HAIR = ("short", "long", "tail", "bald", "cap", "beanie", "hat")
BAGS = ("none", "backpack", "shoulder", "shopping")

# Trunk of an average adult: height, half width, half depth and shift forwards, over stature.
_TRUNK = np.array(
    [
        [0.462, 0.050, 0.036, 0.000],
        [0.500, 0.093, 0.064, -0.006],
        [0.540, 0.097, 0.067, -0.008],
        [0.595, 0.086, 0.058, 0.002],
        [0.635, 0.081, 0.057, 0.005],
        [0.700, 0.091, 0.064, 0.007],
        [0.745, 0.101, 0.068, 0.006],
        [0.785, 0.108, 0.061, 0.002],
        [0.812, 0.099, 0.048, -0.003],
        [0.836, 0.060, 0.040, -0.004],
        [0.852, 0.035, 0.036, 0.002],
    ]
)
# Head over its own height from the chin: height, half width, half depth, shift forwards.
_HEAD = np.array(
    [
        [0.00, 0.15, 0.15, 0.12],
        [0.09, 0.24, 0.26, 0.11],
        [0.28, 0.305, 0.36, 0.045],
        [0.60, 0.345, 0.425, -0.005],
        [0.80, 0.315, 0.395, -0.03],
        [0.93, 0.21, 0.27, -0.04],
        [1.00, 0.07, 0.09, -0.04],
    ]
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Person:
    """Who is built, and in what clothes.

    Attributes:
        stature_m: height.
        girth: widths over the average, 0.85 to 1.35.
        shoulders, hips: widths over the average.
        pose: angles of the joints.
        top, bottom, hair, bag: one of `TOPS`, `BOTTOMS`, `HAIR`, `BAGS`.
        open_front: a jacket or coat worn open.
        hem: of a coat or a skirt, height over stature.
        phone: one in the right hand.
    """

    stature_m: float
    girth: float
    shoulders: float
    hips: float
    pose: Pose
    top: str
    bottom: str
    hair: str
    bag: str
    open_front: bool
    hem: float
    phone: bool

    @property
    def head_m(self) -> float:
        """Height of the head: children's are larger for their stature."""
        return 0.130 + 0.057 * self.stature_m

    @property
    def body_m(self) -> float:
        """Stature of the adult whose trunk and limbs these are."""
        return (self.stature_m - self.head_m) / 0.87


def loft(rings, closed: bool = True, capped: bool = True, columns=None) -> Geometry:
    """A skin over cross sections.

    Args:
        rings: (n, m, 3) [m], counter-clockwise seen from the last one.
        closed: join the last corner of a ring to its first.
        capped: close the first and the last ring.
        columns: (m,) bool: which sides to keep.
    """
    rings = np.asarray(rings, np.float64)
    if closed:
        rings = np.concatenate([rings, rings[:, :1]], axis=1)
    n, m = rings.shape[:2]
    u = np.linalg.norm(np.diff(rings, axis=1), axis=2).mean(axis=0).cumsum()
    v = np.linalg.norm(np.diff(rings.mean(axis=1), axis=0), axis=1).cumsum()
    uv = np.zeros((n, m, 2))
    uv[:, 1:, 0], uv[1:, :, 1] = u, v[:, None]
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    if columns is not None:
        a, b, c, d = (x[:, columns] for x in (a, b, c, d))
    faces = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    if capped:
        fan = np.arange(1, m - 2)
        end = (n - 1) * m
        caps = [np.stack([0 * fan, fan + 1, fan], 1), end + np.stack([0 * fan, fan, fan + 1], 1)]
        faces = np.concatenate([faces, *caps])
    return geometry(rings, faces, uv.reshape(-1, 2))


def _ovals(centre, rotation, half_width, half_depth, turn_deg=None, sides: int = 8) -> np.ndarray:
    """Cross sections (n, sides, 3) about `centre` (n, 3), a little squarer than ellipses."""
    if turn_deg is None:
        turn_deg = (np.arange(sides) + 0.5) * 360 / sides
    turn = np.radians(turn_deg)
    c, s = np.cos(turn), np.sin(turn)
    x = np.multiply.outer(half_depth, np.sign(c) * np.abs(c) ** 0.85)
    y = np.multiply.outer(half_width, np.sign(s) * np.abs(s) ** 0.85)
    local = np.stack([x, y, np.zeros_like(x)], axis=-1)
    return centre[:, None] + np.einsum(
        "nij,nmj->nmi", np.broadcast_to(rotation, (len(x), 3, 3)), local
    )


def _hairy(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Where hair grows, by x and z over the head's height."""
    return (z > 0.76) | ((x < 0.12) & (z > 0.5)) | ((x < -0.08) & (z > 0.2))


class _Figure:
    """A person under construction."""

    def __init__(self, person: Person) -> None:
        self.person = person
        self.skeleton: Skeleton = posed(person.pose, person.body_m, person.shoulders, person.hips)
        self.limbs = 1 + 0.6 * (person.girth - 1)
        self.parts: dict[str, list[Geometry]] = {slot: [] for slot in SLOTS}

    def add(self, slot: str, part: Geometry, shade: float = 1.0) -> None:
        self.parts[slot].append(part if shade == 1.0 else part.tinted((shade,) * 3))

    def trunk_rings(self, heights, ease_m=0.0) -> np.ndarray:
        """Cross sections of the trunk at heights over stature, `ease_m` (n,) outside the skin."""
        p, body = self.person, self.skeleton.body_m
        h = np.asarray(heights, np.float64)
        width, depth, shift = (np.interp(h, _TRUNK[:, 0], _TRUNK[:, k]) for k in (1, 2, 3))
        upper = np.clip((h - 0.60) / 0.14, 0, 1)
        width = width * np.where(h < 0.83, p.hips + (p.shoulders - p.hips) * upper, 1.0)
        # Weight goes to the belly first.
        belly = np.exp(-(((h - 0.60) / 0.07) ** 2))
        girth = 1 + (p.girth - 1) * np.where(h < 0.8, 1 + 0.3 * belly, 0.5)
        depth = depth * (1 + (girth - 1) * (1 + 0.8 * belly))
        shift = shift + 0.25 * belly * max(p.girth - 1, 0) * 0.12
        centre, rotation = self.skeleton.trunk(h)
        centre = centre + (shift * body)[:, None] * rotation[:, :, 0]
        return _ovals(centre, rotation, width * girth * body + ease_m, depth * body + ease_m)

    def limb(self, slot: str, path, radii, sides: int = 6, capped=True, shade=1.0) -> None:
        body = self.skeleton.body_m * self.limbs
        self.add(slot, tube(path, np.asarray(radii) * body, sides, capped=capped), shade)

    # Head

    def head(self) -> None:
        p, s, size = self.person, self.skeleton, self.person.head_m
        centre = s.neck + np.column_stack([_HEAD[:, 3], 0 * _HEAD[:, 3], _HEAD[:, 0]]) @ (
            s.skull.T * size
        )
        rings = _ovals(centre, s.skull, _HEAD[:, 1] * size, _HEAD[:, 2] * size)
        face = loft(rings)
        # Eye sockets and the underside of the chin are in shade.
        ring = np.repeat(np.arange(len(_HEAD)), 9)
        ahead = ((face.vertices - s.neck) @ s.skull)[:, 0] > 0.2 * size
        self.add("skin", face.tinted(np.where(ahead & (ring == 3), 0.62, 1.0)[:, None]))
        nose = np.array(
            [[0.40, 0, 0.60], [0.38, 0.055, 0.40], [0.38, -0.055, 0.40], [0.50, 0, 0.43]]
        )
        self.add(
            "skin", geometry(s.neck + nose * size @ s.skull.T, [[0, 1, 3], [0, 3, 2], [1, 2, 3]])
        )
        back, _ = s.trunk(np.array([0.835]))
        top = s.neck + s.skull @ (np.array([-0.05, 0, 0.2]) * size)
        self.limb(
            "skin",
            np.stack([back[0], s.neck + s.skull @ [-0.03 * size, 0, 0], top]),
            [0.034, 0.032, 0.032],
            8,
            capped=False,
        )
        self._hair(p.hair, rings)

    def _shell(self, rings, grow: float, keep) -> Geometry:
        """The part of the head's skin where keep(x, z) of its own height, blown up by `grow`."""
        s, size = self.skeleton, self.person.head_m
        skin = loft(rings)
        local = (skin.vertices - s.neck) @ s.skull / size
        middle = np.array([-0.02, 0, 0.55])
        out = s.neck + ((local - middle) * grow + middle) * size @ s.skull.T
        centroid = local[skin.faces].mean(axis=1)
        faces = skin.faces[keep(centroid[:, 0], centroid[:, 2])]
        return geometry(out, faces, skin.uv)

    def _hair(self, kind: str, rings) -> None:
        s, size = self.skeleton, self.person.head_m
        if kind != "bald":
            self.add("hair", self._shell(rings, 1.085, _hairy))
        if kind in ("long", "hat"):
            # Falls behind the ears onto the shoulders.
            z = np.array([0.80, 0.45, 0.05, -0.32])
            centre = s.neck + np.column_stack([[-0.05, -0.05, -0.10, -0.13], 0 * z, z]) * size @ (
                s.skull.T
            )
            fall = _ovals(
                centre,
                s.skull,
                np.array([0.36, 0.41, 0.40, 0.34]) * size,
                np.array([0.43, 0.44, 0.36, 0.24]) * size,
                np.linspace(72, 288, 7),
            )
            self.add("hair", loft(fall, closed=False, capped=False), 0.9)
        elif kind == "tail":
            path = np.array([[-0.42, 0, 0.72], [-0.56, 0, 0.62], [-0.56, 0, 0.2], [-0.5, 0, -0.15]])
            self.add(
                "hair",
                tube(
                    s.neck + path * size @ s.skull.T, np.array([0.07, 0.10, 0.10, 0.03]) * size, 6
                ),
            )
        if kind in ("cap", "beanie", "hat"):
            low = 0.62 if kind == "beanie" else 0.7
            self.add("extra", self._shell(rings, 1.15, lambda x, z: z > low))
        if kind in ("cap", "hat"):
            turn = np.linspace(-62, 62, 6) if kind == "cap" else np.linspace(0, 360, 13)
            reach = np.array([[0.38, 0.34], [0.72, 0.42]])
            if kind == "hat":
                reach = np.array([[0.36, 0.30], [0.72, 0.66]])
            z = np.array([0.70, 0.66])
            centre = s.neck + np.column_stack([0 * z, 0 * z, z]) * size @ s.skull.T
            brim = _ovals(centre, s.skull, reach[:, 1] * size, reach[:, 0] * size, turn)
            self.add("extra", loft(brim[::-1], closed=False, capped=False), 0.85)

    # Limbs

    def arms(self) -> None:
        p = self.person
        ease = {"tshirt": 0.005, "jersey": 0.006, "shirt": 0.004}.get(p.top, 0.011)
        for shoulder, elbow, wrist, tip in self.skeleton.arms:
            inside = shoulder + 0.16 * (shoulder - elbow) + [0, 0, 0.0]
            neck = self.skeleton.trunk(np.array([0.82]))[0][0]
            inside = inside + 0.14 * (neck - shoulder)
            cuff = wrist + 0.04 * (elbow - wrist)
            if p.top in ("tshirt", "jersey"):
                end = shoulder + 0.78 * (elbow - shoulder)
                middle = shoulder + 0.4 * (elbow - shoulder)
                radii = np.array([0.018, 0.033, 0.031, 0.032]) + ease
                self.limb("top", [inside, shoulder, middle, end], radii, capped=False)
                bare = shoulder + 0.6 * (elbow - shoulder)
                bulge = elbow + 0.25 * (wrist - elbow)
                self.limb(
                    "skin", [bare, elbow, bulge, wrist], [0.026, 0.024, 0.025, 0.016], capped=False
                )
            else:
                bulge = elbow + 0.35 * (wrist - elbow)
                radii = np.array([0.018, 0.034, 0.026, 0.025, 0.020]) + ease
                self.limb("top", [inside, shoulder, elbow, bulge, cuff], radii, capped=False)
            self._hand(wrist, tip)

    def _hand(self, wrist, tip) -> None:
        along = tip - wrist
        path = [wrist - 0.1 * along, wrist + 0.4 * along, wrist + along]
        self.limb("skin", path, [0.015, 0.023, 0.010], 5)

    def legs(self) -> None:
        p, body = self.person, self.skeleton.body_m
        joints = self.skeleton.legs
        for (hip, knee, ankle), foot in zip(joints, self.skeleton.feet, strict=True):
            start = hip + 0.06 * (hip - knee)
            thigh, calf = hip + 0.45 * (knee - hip), knee + 0.3 * (ankle - knee)
            hem = ankle + 0.02 * (ankle - knee)
            if p.bottom == "trousers":
                radii = [0.050, 0.052, 0.040, 0.036, 0.031]
                self.limb("bottom", [start, thigh, knee, calf, hem], radii, 8, capped=False)
            else:
                bare = hip + 0.35 * (knee - hip)
                slot = "top" if p.top == "jersey" else "skin"
                self.limb("skin", [bare, thigh, knee], [0.047, 0.044, 0.032], 8, capped=False)
                self.limb(slot, [knee, calf, hem], [0.032, 0.034, 0.021], 8, capped=False)
            if p.bottom == "shorts":
                end = hip + 0.86 * (knee - hip)
                self.limb("bottom", [start, thigh, end], [0.050, 0.056, 0.053], 8, capped=False)
            self._shoe(ankle, foot, body)

    def _shoe(self, ankle, foot, body: float) -> None:
        x = np.array([-0.050, 0.004, 0.062, 0.106]) * body
        high = np.array([0.044, 0.052, 0.032, 0.014]) * body
        half = np.array([0.019, 0.023, 0.028, 0.016]) * body
        section = np.array([[1, 0], [1, 0.5], [0.5, 1], [-0.5, 1], [-1, 0.5], [-1, 0]])
        rings = np.zeros((4, 6, 3))
        rings[..., 0] = x[:, None]
        rings[..., 1] = half[:, None] * section[:, 0]
        rings[..., 2] = high[:, None] * section[:, 1] - ANKLE * body - 0.004
        self.add("shoes", loft(ankle + rings @ foot.T))

    # Clothes

    def trunk(self) -> None:
        p = self.person
        heavy = p.top in ("jacket", "coat")
        ease = 0.022 if heavy else 0.008
        hem = 0.478 if heavy else 0.51
        heights = np.array([hem, 0.55, 0.62, 0.69, 0.745, 0.785, 0.812, 0.836, 0.852])
        loose = np.full(len(heights), ease)
        loose[:2] += [0.018, 0.008]
        rings = self.trunk_rings(heights, loose)
        front = np.zeros(8, bool)
        if heavy and p.open_front:
            front[7] = True
            self.add(
                "inner", loft(self.trunk_rings(heights, loose - 0.006), columns=front, capped=False)
            )
        self.add("top", loft(rings, columns=~front, capped=not p.open_front))
        if p.top == "coat":
            self._skirt("top", 0.53, p.hem, 0.030)
        if p.bottom == "skirt":
            self._skirt("bottom", 0.60, p.hem, 0.014)
        else:
            waist = np.array([0.462, 0.50, 0.56])
            self.add("bottom", loft(self.trunk_rings(waist, 0.005)))

    def _skirt(self, slot: str, top: float, hem: float, ease: float) -> None:
        """Cloth from the waist round both legs, as wide as their stride."""
        s, body = self.skeleton, self.skeleton.body_m
        z = np.linspace(s.pelvis[2] - 0.04 * body, s.pelvis[2] - (0.53 - hem) * body, 4)
        x = np.stack([np.interp(-z, -leg[:, 2], leg[:, 0]) for leg in s.legs])
        y = np.stack([np.interp(-z, -leg[:, 2], leg[:, 1]) for leg in s.legs])
        thick = np.interp(z, [s.pelvis[2] - 0.25 * body, s.pelvis[2]], [0.036, 0.052]) * body
        centre = np.column_stack([x.mean(axis=0), y.mean(axis=0), z])
        depth = np.ptp(x, axis=0) / 2 + thick * self.limbs + ease
        width = np.ptp(y, axis=0) / 2 + thick * self.limbs + ease + np.linspace(0, 0.015, 4)
        lower = _ovals(centre, np.eye(3), width, depth)
        upper = self.trunk_rings(np.linspace(0.53, top, 2 if top > 0.53 else 1), ease)
        self.add(slot, loft(np.concatenate([lower[::-1], upper]), capped=False))

    # Things

    def bag(self) -> None:
        p, s, body = self.person, self.skeleton, self.skeleton.body_m
        if p.bag == "backpack":
            h = np.array([0.60, 0.63, 0.74, 0.79, 0.805])
            centre, rotation = s.trunk(h)
            deep = np.array([0.05, 0.085, 0.08, 0.055, 0.02])
            wide = np.array([0.11, 0.14, 0.14, 0.13, 0.08])
            behind = 0.066 * p.girth * body + 0.02 + 0.7 * deep
            self.add(
                "extra",
                loft(_ovals(centre - behind[:, None] * rotation[:, :, 0], rotation, wide, deep)),
            )
            for y in (0.055, -0.055):
                h = np.array([0.68, 0.77, 0.825, 0.80, 0.69])
                centre, rotation = s.trunk(h)
                ahead = np.array([-0.05, -0.05, 0.0, 0.066, 0.079]) * body * p.girth + 0.01
                strap = centre + ahead[:, None] * rotation[:, :, 0] + y * body * rotation[:, :, 1]
                self.add("extra", tube(strap, 0.017, 4), 0.8)
        elif p.bag == "shoulder":
            centre, rotation = s.trunk(np.array([0.80, 0.53]))
            side = 0.135 * p.girth * body
            hang = centre[1] + rotation[1] @ [0.0, side + 0.05, -0.02]
            bag = box((0.3, 0.11, 0.24), (0, 0, -0.12))
            self.add("extra", copies(bag, hang[None], rotation=rotation[1][None]))
            over = centre[0] + rotation[0] @ [0, 0.085 * body, 0.055 * body]
            for x in (0.12, -0.12):
                self.add("extra", tube(np.stack([hang + [x, 0, 0.1], over]), 0.009, 4), 0.8)
        elif p.bag == "shopping":
            tip = s.arms[0, 3]
            bag = box((0.3, 0.12, 0.34), (0, 0, 0)).moved(tip - [0, 0, 0.52])
            handle = tube(
                tip + np.array([[0.1, 0, -0.19], [0.0, 0, 0.0], [-0.1, 0, -0.19]]), 0.006, 3
            )
            self.add("extra", join([bag, handle]))
        if p.phone:
            tip = s.arms[1, 3]
            self.add("shoes", box((0.075, 0.012, 0.15)).moved(tip - [0, 0, 0.06]), 0.2)


def person(params: Person) -> dict[str, Geometry]:
    """Geometry by slot (see `SLOTS`), tints near 1, to be multiplied by each slot's colour.

    Stands on the ground at its origin, or sits on a seat of `skeleton.SEAT_M`, and looks along x.
    """
    figure = _Figure(params)
    figure.head()
    figure.trunk()
    figure.arms()
    figure.legs()
    figure.bag()
    return {slot: join(parts) for slot, parts in figure.parts.items()}


__all__ = ["BAGS", "BOTTOMS", "HAIR", "SEAT_M", "SLOTS", "TOPS", "Person", "loft", "person"]
