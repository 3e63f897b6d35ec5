"""Façade families: what walls, windows and fittings of a kind of city building look like.

Dimensions after CTBUH (storeys of 3.1 m in flats, 3.9 m in offices) and common practice;
reflectances are linear.
"""

from typing import NamedTuple

Tint = tuple[float, float, float]

BRICKS: tuple[Tint, ...] = (
    (0.21, 0.095, 0.062), (0.17, 0.082, 0.06), (0.25, 0.15, 0.105), (0.29, 0.22, 0.15),
    (0.32, 0.27, 0.2), (0.12, 0.075, 0.06), (0.23, 0.12, 0.1), (0.34, 0.32, 0.29),
)  # fmt: skip
PLASTERS: tuple[Tint, ...] = (
    (0.56, 0.52, 0.44), (0.62, 0.6, 0.56), (0.52, 0.43, 0.3), (0.42, 0.42, 0.41),
    (0.55, 0.43, 0.35), (0.47, 0.49, 0.46), (0.5, 0.36, 0.28), (0.36, 0.4, 0.44),
)  # fmt: skip
STONES: tuple[Tint, ...] = (
    (0.42, 0.38, 0.31), (0.36, 0.33, 0.28), (0.46, 0.44, 0.4), (0.3, 0.27, 0.24),
    (0.27, 0.19, 0.15), (0.4, 0.34, 0.25),
)  # fmt: skip
# Multipliers of the concrete texture.
CONCRETES: tuple[Tint, ...] = (
    (1.0, 1.0, 1.0), (1.12, 1.1, 1.05), (0.85, 0.85, 0.86), (1.05, 0.98, 0.9), (0.75, 0.74, 0.72),
)  # fmt: skip
CLADDINGS: tuple[Tint, ...] = (
    (0.5, 0.51, 0.52), (0.62, 0.62, 0.6), (0.11, 0.12, 0.13), (0.34, 0.32, 0.29),
    (0.15, 0.18, 0.21), (0.42, 0.36, 0.28), (0.24, 0.25, 0.25), (0.26, 0.14, 0.09),
)  # fmt: skip
FRAMES: tuple[Tint, ...] = (
    (0.6, 0.6, 0.58), (0.06, 0.06, 0.065), (0.1, 0.085, 0.07), (0.3, 0.3, 0.3), (0.05, 0.07, 0.06),
)  # fmt: skip
# Multipliers of the coated glass: neutral, green, blue, bronze, silver.
GLASSES: tuple[Tint, ...] = (
    (1.0, 1.0, 1.0), (0.85, 1.05, 0.95), (0.8, 0.98, 1.2), (1.15, 0.95, 0.75), (1.25, 1.25, 1.25),
)  # fmt: skip


class Window(NamedTuple):
    """The windows of a family; ranges are drawn once a building.

    Attributes:
        width: share of the bay.
        sill: height of the sill above the floor [m].
        head: from the head of the window to the floor above [m].
        reveal_m: depth of the pane behind the wall.
        frame_m: width of the frame.
        columns, rows: choices of how many panes; bars between them.
        sill_out_m: how far the sill stands out; 0 for none.
        lintel: "none", "stone" (a proud band), or "surround" (all round).
        air_conditioners: share of windows with a unit below or in them.
    """

    width: tuple[float, float]
    sill: tuple[float, float]
    head: tuple[float, float]
    reveal_m: tuple[float, float]
    frame_m: float
    columns: tuple[int, ...]
    rows: tuple[int, ...]
    sill_out_m: float
    lintel: tuple[str, ...] = ("none",)
    air_conditioners: float = 0.0


class Style(NamedTuple):
    """A family of façades.

    Attributes:
        skin: "punched" (holes in a wall), "curtain" (glass on mullions) or "ribbon" (bands).
        wall: material of the walls.
        palette: their tints.
        storeys: lowest and highest fit.
        weight: how common it is.
        bay_m: range of bay widths.
        flats: homes (3.1 m storeys) or offices (3.9 m).
        window: its windows.
        balconies: share of the bays of a street side with a balcony.
        cornice: "stone", "brick", "thin" or "none".
        pilasters: depth of piers between bays [m]; 0 for none.
        escape: has fire escapes.
        ground: choices for the ground floor: "shops", "lobby", "flats", "dock".
        roof: choices of the roof's surface.
    """

    skin: str
    wall: str
    palette: tuple[Tint, ...]
    storeys: tuple[int, int]
    weight: float
    bay_m: tuple[float, float]
    flats: bool
    window: Window
    balconies: float = 0.0
    cornice: tuple[str, ...] = ("none",)
    pilasters: tuple[float, float] = (0.0, 0.0)
    escape: bool = False
    ground: tuple[str, ...] = ("shops",)
    roof: tuple[str, ...] = ("roof_felt", "gravel")


STYLES: dict[str, Style] = {
    "punched_brick": Style(
        "punched", "brick", BRICKS, (3, 22), 1.3, (2.4, 3.3), True,
        Window((0.4, 0.56), (0.75, 0.95), (0.4, 0.55), (0.1, 0.18), 0.06, (1, 2), (1, 2), 0.07,
               ("none", "stone", "stone"), 0.12),
        cornice=("brick", "stone", "thin"), ground=("shops", "shops", "flats"),
    ),
    "punched_plaster": Style(
        "punched", "plaster", PLASTERS, (3, 14), 1.2, (2.5, 3.5), True,
        Window((0.36, 0.5), (0.55, 0.95), (0.35, 0.5), (0.12, 0.2), 0.06, (2,), (1, 1, 2), 0.06,
               ("none", "surround", "surround"), 0.06),
        balconies=0.12, cornice=("stone", "thin"), ground=("shops", "flats"),
    ),
    "punched_concrete": Style(
        "punched", "concrete", CONCRETES, (4, 40), 1.0, (2.6, 3.8), False,
        Window((0.55, 0.72), (0.7, 0.95), (0.6, 0.9), (0.18, 0.25), 0.06, (1, 2), (1,), 0.05),
        cornice=("thin", "none"), pilasters=(0.0, 0.3), ground=("shops", "lobby"),
    ),
    "deep_grid": Style(
        "punched", "concrete", CONCRETES, (6, 40), 0.7, (3.0, 4.2), False,
        Window((0.8, 0.86), (0.12, 0.75), (0.4, 0.55), (0.35, 0.55), 0.05, (2, 3), (1, 2), 0.0),
        cornice=("thin",), ground=("lobby", "shops"),
    ),
    "curtain_wall": Style(
        "curtain", "cladding", CLADDINGS, (8, 60), 1.5, (1.2, 1.5), False,
        Window((1, 1), (0.7, 0.9), (0.3, 0.5), (0.0, 0.0), 0.06, (1,), (1, 2), 0.0),
        ground=("lobby", "lobby", "shops"),
    ),
    "ribbon_windows": Style(
        "ribbon", "concrete", CONCRETES, (4, 30), 0.9, (1.3, 1.9), False,
        Window((1, 1), (0.85, 1.1), (0.6, 0.9), (0.12, 0.2), 0.05, (1,), (1, 2), 0.05),
        cornice=("thin", "none"), ground=("shops", "lobby"),
    ),
    "ribbon_panels": Style(
        "ribbon", "cladding", CLADDINGS, (5, 34), 0.7, (1.3, 1.9), False,
        Window((1, 1), (0.8, 1.05), (0.5, 0.8), (0.06, 0.14), 0.05, (1,), (1, 2), 0.0),
        cornice=("thin", "none"), ground=("lobby", "shops"),
    ),
    "stone_classical": Style(
        "punched", "stone", STONES, (4, 28), 1.2, (2.9, 3.9), False,
        Window((0.38, 0.48), (0.7, 0.9), (0.6, 0.8), (0.18, 0.25), 0.07, (2,), (2, 3), 0.12,
               ("surround", "stone")),
        cornice=("stone",), pilasters=(0.12, 0.25), ground=("shops", "lobby"),
        roof=("roof_felt",),
    ),
    "balcony_flats": Style(
        "punched", "plaster", PLASTERS, (4, 30), 1.1, (3.3, 4.4), True,
        Window((0.5, 0.68), (0.1, 0.75), (0.3, 0.45), (0.1, 0.15), 0.06, (2, 3), (1,), 0.05,
               ("none",), 0.1),
        balconies=0.65, cornice=("thin", "none"), ground=("flats", "shops"),
    ),
    "loft_warehouse": Style(
        "punched", "brick", BRICKS, (3, 10), 0.8, (3.8, 5.2), False,
        Window((0.66, 0.78), (0.8, 1.0), (0.45, 0.6), (0.15, 0.25), 0.05, (4, 5), (3, 4), 0.09,
               ("stone", "none")),
        cornice=("brick", "brick", "stone"), pilasters=(0.12, 0.25), ground=("dock", "shops"),
    ),
    "metal_panel": Style(
        "punched", "cladding", CLADDINGS, (4, 32), 1.0, (2.7, 3.6), False,
        Window((0.45, 0.75), (0.4, 0.95), (0.3, 0.6), (0.08, 0.14), 0.05, (1, 2), (1,), 0.03),
        balconies=0.1, cornice=("thin", "none"), ground=("lobby", "shops"),
    ),
    "fire_escape": Style(
        "punched", "brick", BRICKS, (4, 8), 1.0, (2.2, 2.8), True,
        Window((0.38, 0.46), (0.6, 0.75), (0.5, 0.65), (0.1, 0.15), 0.06, (1,), (2,), 0.08,
               ("stone", "surround"), 0.2),
        cornice=("stone",), escape=True, ground=("shops", "shops", "flats"),
        roof=("roof_felt",),
    ),
}  # fmt: skip
