"""Families of detached houses: what they are built of, in which colours, with which openings.

Colours are linear RGB reflectances as measured off façades and roofs (white paint 0.6-0.75, brick
0.12-0.3, shingle 0.05-0.2, roof tile 0.18-0.33 in red).
"""

import dataclasses

Tint = tuple[float, float, float]

_WHITE, _IVORY, _CREAM = (0.69, 0.68, 0.64), (0.62, 0.58, 0.49), (0.60, 0.52, 0.38)
_BEIGE, _TAN, _TAUPE = (0.47, 0.40, 0.30), (0.37, 0.29, 0.20), (0.30, 0.26, 0.21)
_SAGE, _OLIVE, _FOREST = (0.29, 0.33, 0.24), (0.19, 0.20, 0.12), (0.07, 0.11, 0.08)
_SKY, _BLUE_GREY, _SLATE = (0.39, 0.46, 0.50), (0.23, 0.29, 0.34), (0.13, 0.16, 0.18)
_PALE_GREY, _GREY, _CHARCOAL = (0.52, 0.52, 0.50), (0.30, 0.30, 0.29), (0.07, 0.072, 0.075)
_YELLOW, _BARN_RED, _NAVY = (0.60, 0.47, 0.24), (0.165, 0.06, 0.045), (0.055, 0.08, 0.12)
_BLACK, _BROWN, _OXBLOOD = (0.035, 0.035, 0.036), (0.085, 0.055, 0.036), (0.15, 0.035, 0.03)
_TEAL, _WALNUT, _CEDAR = (0.06, 0.14, 0.15), (0.14, 0.08, 0.045), (0.30, 0.17, 0.09)

_RED_BRICK = ((0.23, 0.095, 0.065), (0.19, 0.08, 0.06), (0.25, 0.12, 0.08))
_BROWN_BRICK = ((0.17, 0.115, 0.085), (0.13, 0.085, 0.065), (0.22, 0.15, 0.11))
_BUFF_BRICK = ((0.34, 0.26, 0.18), (0.30, 0.24, 0.18))
_SHINGLES = (
    (0.060, 0.060, 0.062),
    (0.095, 0.075, 0.058),
    (0.140, 0.128, 0.110),
    (0.085, 0.095, 0.105),
    (0.115, 0.065, 0.050),
    (0.080, 0.090, 0.078),
    (0.175, 0.170, 0.160),
)
_CLAY_TILES = ((0.26, 0.13, 0.085), (0.21, 0.11, 0.08), (0.28, 0.165, 0.11), (0.17, 0.1, 0.072))
_CONCRETE_TILES = ((0.13, 0.125, 0.12), (0.15, 0.10, 0.075), (0.09, 0.085, 0.085))
_SEAM_METALS = ((0.075, 0.08, 0.085), (0.20, 0.21, 0.21), (0.10, 0.13, 0.12), (0.13, 0.06, 0.05))
_DOORS = (_OXBLOOD, _NAVY, _BLACK, _FOREST, _WALNUT, _TEAL, _WHITE, _BARN_RED)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Style:
    """One family of houses; choices are drawn evenly unless they say otherwise.

    Attributes:
        lower, upper, gable: (material, colours) of the walls of the ground floor, the upper floor
            and the gables; None repeats the one below.
        plinth: (material, colours).
        trims, frames, doors, garage_doors: colours of paint.
        roof: (material, colours).
        forms: roof forms of the main block.
        pitch_deg, eaves_m: ranges.
        windows: kinds of window, one drawn for the house.
        entrances, garages: kinds of door.
        two_storeys: share of houses.
        width_m, depth_m: ranges of the main block, along the street and away from it.
        garage: weights of (none, side, front, detached).
        front_wing: share with a wing towards the street.
        porch: weights of (stoop, portico, full width, canopy).
        casing_m, reveal_m: of the openings.
        window_size_m: (width, height).
        sills: material of the sills, "paint" takes the trim's colour.
        shutters, dormers, bay, chimney, solar, corner_boards, timbering, brackets: shares.
        columns: posts of the porch: "square", "round", "tapered" or "steel".
    """

    lower: tuple[str, tuple[Tint, ...]]
    upper: tuple[str, tuple[Tint, ...]] | None = None
    gable: tuple[str, tuple[Tint, ...]] | None = None
    plinth: tuple[str, tuple[Tint, ...]] = ("concrete", ((0.9, 0.9, 0.9),))
    trims: tuple[Tint, ...] = (_WHITE,)
    frames: tuple[Tint, ...] = (_WHITE,)
    doors: tuple[Tint, ...] = _DOORS
    garage_doors: tuple[Tint, ...] = (_WHITE, _IVORY)
    roof: tuple[str, tuple[Tint, ...]] = ("shingle", _SHINGLES)
    forms: tuple[str, ...] = ("gable",)
    pitch_deg: tuple[float, float] = (24, 34)
    eaves_m: tuple[float, float] = (0.35, 0.5)
    windows: tuple[str, ...] = ("double_hung",)
    entrances: tuple[str, ...] = ("door_panel", "door_fan", "door_lite")
    garages: tuple[str, ...] = ("garage_4", "garage_4_lites", "garage_8")
    two_storeys: float = 0.0
    width_m: tuple[float, float] = (10, 14)
    depth_m: tuple[float, float] = (8, 10)
    garage: tuple[float, float, float, float] = (0.2, 0.4, 0.2, 0.2)
    front_wing: float = 0.4
    porch: tuple[float, float, float, float] = (0.3, 0.4, 0.3, 0.0)
    casing_m: float = 0.1
    reveal_m: float = 0.1
    window_size_m: tuple[float, float] = (1.0, 1.4)
    sills: str = "paint"
    shutters: float = 0.0
    dormers: float = 0.0
    bay: float = 0.15
    chimney: float = 0.5
    solar: float = 0.15
    corner_boards: float = 0.0
    timbering: float = 0.0
    brackets: float = 0.0
    columns: str = "square"


STYLES = {
    "weatherboard_cottage": Style(
        lower=("siding", (_WHITE, _CREAM, _SAGE, _SKY, _BLUE_GREY, _YELLOW, _PALE_GREY)),
        plinth=("brick", _RED_BRICK + _BROWN_BRICK),
        pitch_deg=(32, 40),
        windows=("six_over_six", "double_hung"),
        width_m=(8.5, 11),
        depth_m=(7.5, 9),
        garage=(0.35, 0.1, 0.0, 0.55),
        porch=(0.1, 0.3, 0.6, 0.0),
        shutters=0.5,
        dormers=0.5,
        corner_boards=1.0,
        columns="round",
    ),
    "brick_ranch": Style(
        lower=("brick", _RED_BRICK + _BROWN_BRICK + _BUFF_BRICK),
        gable=("siding", (_WHITE, _IVORY, _TAN, _GREY)),
        trims=(_WHITE, _IVORY, _BROWN),
        forms=("gable", "hip", "hip"),
        pitch_deg=(18, 26),
        eaves_m=(0.45, 0.6),
        windows=("double_hung", "picture"),
        width_m=(13, 16),
        depth_m=(7.5, 9.5),
        garage=(0.1, 0.6, 0.2, 0.1),
        porch=(0.5, 0.2, 0.3, 0.0),
        casing_m=0.0,
        reveal_m=0.12,
        window_size_m=(1.3, 1.25),
        sills="concrete",
        shutters=0.45,
    ),
    "rendered_cube": Style(
        lower=("plaster", (_WHITE, (0.72, 0.72, 0.70), _PALE_GREY, _GREY, (0.56, 0.53, 0.47))),
        upper=("plaster", (_WHITE, _CHARCOAL, _PALE_GREY, (0.20, 0.19, 0.18))),
        plinth=("concrete", ((0.6, 0.6, 0.6),)),
        trims=(_CHARCOAL, (0.2, 0.2, 0.2), _PALE_GREY),
        frames=(_BLACK, _CHARCOAL),
        doors=(_WALNUT, _CHARCOAL, _CEDAR),
        garage_doors=(_CHARCOAL, _GREY, _WALNUT),
        roof=("gravel", ((1.0, 1.0, 1.0), (0.85, 0.85, 0.85))),
        forms=("parapet",),
        windows=("fixed", "ribbon", "casement"),
        entrances=("door_flush",),
        garages=("garage_flush", "garage_plank"),
        two_storeys=0.7,
        width_m=(9, 13),
        depth_m=(8, 11),
        garage=(0.1, 0.5, 0.4, 0.0),
        front_wing=0.6,
        porch=(0.2, 0.0, 0.0, 0.8),
        casing_m=0.0,
        reveal_m=0.18,
        window_size_m=(1.8, 1.6),
        bay=0.0,
        chimney=0.1,
        solar=0.3,
        columns="steel",
    ),
    "brick_and_siding_colonial": Style(
        lower=("brick", _RED_BRICK + _BUFF_BRICK),
        upper=("siding", (_WHITE, _IVORY, _BEIGE, _BLUE_GREY, _SAGE)),
        pitch_deg=(26, 36),
        windows=("six_over_six", "double_hung"),
        two_storeys=1.0,
        width_m=(10, 13),
        depth_m=(8, 9.5),
        garage=(0.1, 0.6, 0.2, 0.1),
        front_wing=0.25,
        porch=(0.25, 0.6, 0.15, 0.0),
        shutters=0.75,
        corner_boards=1.0,
        columns="round",
    ),
    "craftsman_bungalow": Style(
        lower=("siding", (_SAGE, _OLIVE, _TAUPE, _SLATE, _TAN, _BARN_RED, _BLUE_GREY)),
        gable=("wood", (_TAUPE, _BROWN, _CEDAR, _SAGE)),
        plinth=("brick", _BROWN_BRICK),
        trims=(_IVORY, _WHITE, _CREAM, _BROWN),
        frames=(_WHITE, _IVORY, _BROWN),
        pitch_deg=(22, 28),
        eaves_m=(0.5, 0.6),
        windows=("four_over_one",),
        width_m=(9, 11.5),
        depth_m=(9, 11),
        garage=(0.3, 0.05, 0.05, 0.6),
        front_wing=0.3,
        porch=(0.0, 0.2, 0.8, 0.0),
        casing_m=0.13,
        dormers=0.45,
        chimney=0.7,
        corner_boards=0.6,
        brackets=1.0,
        columns="tapered",
    ),
    "tudor": Style(
        lower=("brick", _RED_BRICK + _BROWN_BRICK),
        upper=("plaster", (_IVORY, _CREAM, (0.66, 0.62, 0.54))),
        gable=("plaster", (_IVORY, _CREAM, (0.66, 0.62, 0.54))),
        trims=(_BROWN, (0.05, 0.04, 0.03)),
        frames=(_BROWN, _IVORY, _BLACK),
        doors=(_WALNUT, _OXBLOOD, _BLACK),
        garage_doors=(_BROWN, _WALNUT),
        roof=("roof_tile", _CONCRETE_TILES + _CLAY_TILES[1:2]),
        pitch_deg=(36, 40),
        eaves_m=(0.3, 0.4),
        windows=("leaded", "casement_cottage"),
        entrances=("door_panel", "door_fan"),
        garages=("garage_plank",),
        two_storeys=0.75,
        depth_m=(7.5, 9),
        garage=(0.3, 0.4, 0.1, 0.2),
        front_wing=0.9,
        porch=(0.4, 0.6, 0.0, 0.0),
        casing_m=0.09,
        bay=0.4,
        chimney=1.0,
        timbering=1.0,
    ),
    "mediterranean": Style(
        lower=("plaster", ((0.56, 0.45, 0.31), (0.62, 0.53, 0.40), (0.47, 0.30, 0.21), _IVORY)),
        plinth=("plaster", (_TAUPE, _BEIGE)),
        trims=(_BROWN, _IVORY, _WALNUT),
        frames=(_BROWN, _IVORY, _WALNUT),
        doors=(_WALNUT, _TEAL, _BROWN),
        garage_doors=(_WALNUT, _BROWN, _BEIGE),
        roof=("roof_tile", _CLAY_TILES),
        forms=("hip", "hip", "gable"),
        pitch_deg=(18, 23),
        eaves_m=(0.4, 0.6),
        windows=("casement_cottage", "casement"),
        garages=("garage_plank", "garage_4"),
        two_storeys=0.5,
        depth_m=(8.5, 11),
        garage=(0.15, 0.45, 0.4, 0.0),
        front_wing=0.6,
        porch=(0.3, 0.3, 0.4, 0.0),
        casing_m=0.0,
        reveal_m=0.2,
        window_size_m=(1.1, 1.35),
        sills="concrete",
        shutters=0.4,
        bay=0.05,
        chimney=0.4,
        columns="round",
    ),
    "siding_two_storey": Style(
        lower=("siding", (_BEIGE, _PALE_GREY, _GREY, _BLUE_GREY, _TAN, _IVORY, _SLATE, _SAGE)),
        gable=("siding", (_BEIGE, _PALE_GREY, _WHITE, _TAUPE)),
        forms=("gable", "gable", "hip"),
        pitch_deg=(24, 36),
        eaves_m=(0.3, 0.45),
        windows=("double_hung", "six_over_six", "casement"),
        two_storeys=1.0,
        width_m=(8.5, 12),
        depth_m=(8.5, 10.5),
        garage=(0.05, 0.3, 0.65, 0.0),
        porch=(0.2, 0.4, 0.4, 0.0),
        shutters=0.3,
        solar=0.25,
        corner_boards=1.0,
    ),
    "mid_century": Style(
        lower=("wood", (_WALNUT, _CEDAR, _TAUPE, _CHARCOAL)),
        gable=("wood", (_CEDAR, _WALNUT, _IVORY)),
        plinth=("brick", _BROWN_BRICK + _BUFF_BRICK),
        trims=(_BROWN, _WHITE, _CHARCOAL),
        frames=(_BROWN, _CHARCOAL, _WHITE),
        doors=((0.42, 0.20, 0.05), _TEAL, _BARN_RED, (0.45, 0.35, 0.08)),
        garage_doors=(_WALNUT, _WHITE, _TAUPE),
        roof=("shingle", _SHINGLES[2:3] + _SHINGLES[6:]),
        forms=("gable", "slab", "shed"),
        pitch_deg=(18, 20),
        eaves_m=(0.55, 0.6),
        windows=("ribbon", "picture", "fixed"),
        entrances=("door_flush", "door_lite"),
        garages=("garage_flush", "garage_plank"),
        width_m=(12, 16),
        depth_m=(7.5, 9),
        garage=(0.2, 0.6, 0.1, 0.1),
        front_wing=0.2,
        porch=(0.3, 0.0, 0.3, 0.4),
        casing_m=0.05,
        window_size_m=(1.9, 1.5),
        bay=0.0,
        chimney=0.6,
        columns="steel",
    ),
    "modern_farmhouse": Style(
        lower=("siding", (_WHITE, (0.74, 0.74, 0.72), _CHARCOAL, _PALE_GREY)),
        trims=(_WHITE, _BLACK, _CHARCOAL),
        frames=(_BLACK, _CHARCOAL),
        doors=(_CEDAR, _BLACK, _WALNUT),
        garage_doors=(_WHITE, _CEDAR, _CHARCOAL),
        roof=("paint", _SEAM_METALS),
        pitch_deg=(30, 40),
        eaves_m=(0.3, 0.4),
        windows=("casement", "double_hung"),
        garages=("garage_4_lites", "garage_plank"),
        two_storeys=0.6,
        depth_m=(7.5, 9.5),
        garage=(0.1, 0.55, 0.25, 0.1),
        front_wing=0.75,
        porch=(0.0, 0.2, 0.8, 0.0),
        casing_m=0.08,
        dormers=0.25,
        solar=0.3,
        corner_boards=0.5,
    ),
    "tile_and_brick_hip": Style(
        lower=("brick", _BUFF_BRICK + _BROWN_BRICK + ((0.52, 0.50, 0.46),)),
        gable=("siding", (_IVORY, _GREY)),
        trims=(_IVORY, _CHARCOAL, _WHITE),
        frames=(_IVORY, _CHARCOAL),
        roof=("roof_tile", _CONCRETE_TILES + _CLAY_TILES),
        forms=("hip",),
        pitch_deg=(22, 27),
        eaves_m=(0.45, 0.6),
        windows=("casement", "ribbon"),
        garages=("garage_flush", "garage_8"),
        two_storeys=0.25,
        width_m=(11, 14),
        depth_m=(9, 12),
        garage=(0.05, 0.4, 0.55, 0.0),
        front_wing=0.5,
        porch=(0.3, 0.3, 0.4, 0.0),
        casing_m=0.0,
        reveal_m=0.11,
        window_size_m=(1.5, 1.3),
        sills="brick",
        chimney=0.15,
        solar=0.35,
    ),
    "stucco_bungalow": Style(
        lower=("plaster", (_PALE_GREY, _BEIGE, (0.45, 0.47, 0.42), _CREAM, _BLUE_GREY, _WHITE)),
        gable=("shingle", (_TAUPE, _GREY, _BROWN)),
        plinth=("plaster", (_GREY, _TAUPE)),
        forms=("gable", "hip"),
        pitch_deg=(20, 30),
        windows=("double_hung", "four_over_one", "picture"),
        width_m=(8.5, 11),
        depth_m=(9, 11),
        garage=(0.25, 0.15, 0.2, 0.4),
        front_wing=0.6,
        porch=(0.4, 0.4, 0.2, 0.0),
        casing_m=0.07,
        reveal_m=0.13,
        window_size_m=(1.2, 1.3),
        chimney=0.6,
    ),
}
