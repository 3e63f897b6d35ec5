"""Body types of vehicles: side profiles, glasshouses and dimensions in metres."""

import dataclasses

import numpy as np

Profile = tuple[tuple[float, float], ...]
Posts = tuple[tuple[float, float, str], ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Body:
    """A body type, in its own frame: x forward, 0 at mid-length; z up from the ground.

    Attributes:
        length_m: bumper to bumper.
        width_m: without mirrors.
        height_m: top of the roof.
        axle_x_m: front and rear axle.
        wheel_radius_m: of the tyre.
        sill_m: underside of the body.
        deck_m: (x, z) keypoints of bonnet, belt and boot line, nose to tail.
        windscreen_x_m: its base and its top.
        rear_x_m: base and top of the rear end of the glasshouse.
        posts: (x at the belt, x at the roof, kind of the panel behind it) along the glasshouse's
            side, front to rear; kinds "glass", "pillar" (black) and "body".
        glasshouse_width: shares of the width at the belt and at the roof.
        nose_bulge_m: how far the middle of the nose is ahead of its corners.
        end_taper: share of the width lost towards the ends.
        cladding: sills and arches are black plastic.
        rails: has roof rails.
        bed_m: front, rear and floor height of an open load bed, or none.
    """

    length_m: float
    width_m: float
    height_m: float
    axle_x_m: tuple[float, float]
    wheel_radius_m: float
    sill_m: float
    deck_m: Profile
    windscreen_x_m: tuple[float, float]
    rear_x_m: tuple[float, float]
    posts: Posts
    glasshouse_width: tuple[float, float] = (0.93, 0.72)
    nose_bulge_m: float = 0.16
    end_taper: float = 0.1
    cladding: bool = False
    rails: bool = False
    bed_m: tuple[float, float, float] | None = None


_BUS_POSTS = tuple(
    (x - dx, x - dx, kind)
    for x in np.linspace(5.4, -4.2, 8)
    for dx, kind in ((0.0, "glass"), (1.26, "pillar"))
) + ((-5.75, -5.72, "body"),)

# Proportions after common European and American models; lengths and heights in metres.
BODIES = {
    "hatchback": Body(
        length_m=4.05,
        width_m=1.76,
        height_m=1.47,
        axle_x_m=(1.24, -1.31),
        wheel_radius_m=0.31,
        sill_m=0.2,
        deck_m=((2.03, 0.70), (1.8, 0.80), (1.0, 0.96), (-0.4, 0.98), (-1.6, 1.02), (-2.03, 1.0)),
        windscreen_x_m=(1.08, 0.28),
        rear_x_m=(-1.93, -1.55),
        posts=(
            (0.74, 0.12, "glass"),
            (-0.3, -0.34, "pillar"),
            (-0.4, -0.43, "glass"),
            (-1.22, -1.1, "body"),
        ),
    ),
    "sedan": Body(
        length_m=4.8,
        width_m=1.82,
        height_m=1.45,
        axle_x_m=(1.45, -1.38),
        wheel_radius_m=0.33,
        sill_m=0.2,
        deck_m=(
            (2.4, 0.68),
            (2.1, 0.79),
            (1.05, 0.94),
            (-0.4, 0.96),
            (-1.6, 1.0),
            (-2.25, 1.02),
            (-2.4, 0.99),
        ),
        windscreen_x_m=(1.12, 0.3),
        rear_x_m=(-1.84, -1.0),
        posts=(
            (0.76, 0.14, "glass"),
            (-0.28, -0.33, "pillar"),
            (-0.38, -0.41, "glass"),
            (-1.28, -0.86, "body"),
        ),
    ),
    "estate": Body(
        length_m=4.76,
        width_m=1.82,
        height_m=1.48,
        axle_x_m=(1.42, -1.36),
        wheel_radius_m=0.33,
        sill_m=0.2,
        deck_m=((2.38, 0.69), (2.1, 0.80), (1.05, 0.95), (-0.4, 0.97), (-1.6, 1.0), (-2.38, 1.0)),
        windscreen_x_m=(1.12, 0.32),
        rear_x_m=(-2.26, -1.86),
        posts=(
            (0.76, 0.16, "glass"),
            (-0.28, -0.33, "pillar"),
            (-0.38, -0.41, "glass"),
            (-1.2, -1.16, "pillar"),
            (-1.3, -1.25, "glass"),
            (-1.96, -1.74, "body"),
        ),
        rails=True,
    ),
    "suv": Body(
        length_m=4.68,
        width_m=1.92,
        height_m=1.72,
        axle_x_m=(1.4, -1.36),
        wheel_radius_m=0.37,
        sill_m=0.27,
        deck_m=((2.34, 0.88), (2.1, 0.99), (1.1, 1.11), (-0.4, 1.13), (-1.6, 1.17), (-2.34, 1.16)),
        windscreen_x_m=(1.14, 0.46),
        rear_x_m=(-2.2, -1.8),
        posts=(
            (0.82, 0.32, "glass"),
            (-0.22, -0.26, "pillar"),
            (-0.32, -0.35, "glass"),
            (-1.12, -1.08, "pillar"),
            (-1.22, -1.17, "glass"),
            (-1.88, -1.66, "body"),
        ),
        glasshouse_width=(0.93, 0.76),
        cladding=True,
        rails=True,
    ),
    "pickup": Body(
        length_m=5.5,
        width_m=1.96,
        height_m=1.86,
        axle_x_m=(1.78, -1.6),
        wheel_radius_m=0.39,
        sill_m=0.36,
        deck_m=((2.75, 1.0), (2.5, 1.09), (1.4, 1.17), (-0.8, 1.2), (-2.75, 1.2)),
        windscreen_x_m=(1.42, 0.76),
        rear_x_m=(-0.86, -0.7),
        posts=(
            (1.08, 0.6, "glass"),
            (0.16, 0.12, "pillar"),
            (0.06, 0.03, "glass"),
            (-0.62, -0.54, "body"),
        ),
        glasshouse_width=(0.93, 0.78),
        end_taper=0.06,
        nose_bulge_m=0.1,
        cladding=True,
        bed_m=(-0.98, -2.46, 0.74),
    ),
    "van": Body(
        length_m=5.5,
        width_m=2.02,
        height_m=2.4,
        axle_x_m=(1.78, -1.6),
        wheel_radius_m=0.35,
        sill_m=0.25,
        deck_m=((2.75, 0.9), (2.55, 1.03), (2.0, 1.18), (1.0, 1.18), (-2.75, 1.18)),
        windscreen_x_m=(2.1, 1.2),
        rear_x_m=(-2.66, -2.58),
        posts=((1.72, 1.02, "glass"), (0.78, 0.74, "body"), (-1.0, -1.0, "body")),
        glasshouse_width=(0.95, 0.86),
        end_taper=0.06,
        nose_bulge_m=0.1,
    ),
    "bus": Body(
        length_m=12.0,
        width_m=2.55,
        height_m=3.1,
        axle_x_m=(3.3, -2.6),
        wheel_radius_m=0.48,
        sill_m=0.3,
        deck_m=((6.0, 1.16), (-6.0, 1.16)),
        windscreen_x_m=(5.97, 5.8),
        rear_x_m=(-5.95, -5.85),
        posts=_BUS_POSTS,
        glasshouse_width=(0.96, 0.92),
        end_taper=0.02,
        nose_bulge_m=0.08,
    ),
}
