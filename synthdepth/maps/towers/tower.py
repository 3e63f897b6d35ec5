"""City buildings: what one is, drawing one, building one at three levels of detail."""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import Model
from synthdepth.maps.towers.balconies import RAILINGS, add_balconies, add_escapes
from synthdepth.maps.towers.curtain import add_curtain
from synthdepth.maps.towers.facades import cells_of, far_walls, plain_walls
from synthdepth.maps.towers.ground import add_ground
from synthdepth.maps.towers.massing import Tier, draw_tiers, edges_of
from synthdepth.maps.towers.mouldings import (
    add_downpipes,
    add_mouldings,
    add_mural,
    add_parapets,
)
from synthdepth.maps.towers.panels import Panels
from synthdepth.maps.towers.punched import add_punched
from synthdepth.maps.towers.rooftop import add_roofs
from synthdepth.maps.towers.styles import FRAMES, GLASSES, STYLES, Tint
from synthdepth.seeding import lane

FACADES: tuple[str, ...] = tuple(STYLES)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tower:
    """A city building in world coordinates, the ground at z = 0.

    Attributes:
        facade: one of `FACADES`.
        seed: of what is too small to choose: pane tilt, blinds, stains.
        tiers: podium, shaft and setbacks, from the ground up.
        levels_m: (storeys + 1,) float64 heights of the floors and the roof.
        wall: (material, tint).
        trim, frame, glass, accent: tints of mouldings, window frames, panes, shop fronts.
        bay_m: about how wide a bay is.
        margin_m: wall between a corner and the first bay.
        window_width: share of the bay.
        sill_m, head_m: from the floor to the sill, from the head to the floor above.
        reveal_m: how far panes lie behind the wall.
        frame_m: width of window frames.
        pier_bays: bays between piers of ribbon windows.
        fin_bays, fin_m: bays between fins of a curtain wall and how far those stand out.
        spandrel_glass: a curtain wall's bands before the slabs are of glass.
        columns, rows: panes of a window.
        lintel, cornice, ground: as in `Style`.
        pilaster_m: depth of piers between bays, or 0.
        balconies, air_conditioners: share of bays and windows that have one.
        balcony_m, railing: depth of balconies, one of `RAILINGS`.
        courses: storeys between string courses, or 0.
        rusticated: the ground floor is of the trim's stone.
        roof: material of the roofs.
    """

    facade: str
    seed: int
    tiers: tuple[Tier, ...]
    levels_m: np.ndarray
    wall: tuple[str, Tint]
    trim: tuple[str, Tint]
    frame: Tint
    glass: Tint
    accent: Tint
    bay_m: float
    margin_m: float
    window_width: float
    sill_m: float
    head_m: float
    reveal_m: float
    frame_m: float
    pier_bays: int
    fin_bays: int
    fin_m: float
    spandrel_glass: bool
    columns: int
    rows: int
    lintel: str
    cornice: str
    ground: str
    pilaster_m: float
    balconies: float
    air_conditioners: float
    balcony_m: float
    railing: str
    courses: int
    rusticated: bool
    roof: str

    @property
    def storeys(self) -> int:
        """Number of storeys, the ground floor included."""
        return len(self.levels_m) - 1

    @property
    def height_m(self) -> float:
        """Height of the main roof above the ground."""
        return float(self.levels_m[-1])

    @property
    def skin(self) -> str:
        """How the façade is made: see `Style`."""
        return STYLES[self.facade].skin


def _between(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return float(rng.uniform(*limits))


def _choose(rng: np.random.Generator, options: tuple):
    return options[int(rng.integers(len(options)))]


def _shaken(rng: np.random.Generator, tint: Tint, spread: float = 0.1) -> Tint:
    """A tint a little lighter or darker, warmer or cooler."""
    light, warm = rng.normal(0, spread), rng.normal(0, 0.25 * spread)
    c = np.asarray(tint) * np.exp([light + warm, light, light - warm])
    return tuple(float(x) for x in np.clip(c, 0.03, 1.25))


def draw_facade(rng: np.random.Generator, storeys: int) -> str:
    """A family fit to the height."""
    weight = np.array(
        [s.weight * (s.storeys[0] <= storeys <= s.storeys[1]) for s in STYLES.values()]
    )
    return FACADES[int(rng.choice(len(FACADES), p=weight / weight.sum()))]


def draw_tower(
    rng: np.random.Generator,
    footprint: np.ndarray,
    *,
    storeys: int,
    street_sides: np.ndarray,
    facade: str | None = None,
) -> Tower:
    """Choose a city building.

    Args:
        rng: source of all choices.
        footprint: (n, 2) float64 convex CCW polygon [m].
        storeys: 3 to 60.
        street_sides: (n,) bool, edges i -> i+1 that face a street; others may be party walls.
        facade: one of `FACADES`; by default one that fits the height.

    Raises:
        KeyError: no such façade.
    """
    drawn = draw_facade(rng, storeys)
    facade = facade or drawn
    if facade not in STYLES:
        raise KeyError(f"facade {facade!r} is not one of {sorted(STYLES)}")
    style = STYLES[facade]
    window = style.window
    footprint = np.asarray(footprint, np.float64)
    street = np.asarray(street_sides, bool)
    storey_m = (3.1 if style.flats else 3.9) * rng.uniform(0.96, 1.06)
    ground_m = storey_m * rng.uniform(1.3, 1.6 if storeys < 15 else 1.9)
    levels = np.concatenate([[0.0], ground_m + storey_m * np.arange(storeys)])
    wall = (style.wall, _shaken(rng, _choose(rng, style.palette)))
    trim_material = "concrete" if style.wall == "concrete" else "stone"
    pale = (0.45, 0.42, 0.37) if trim_material == "stone" else (1.1, 1.08, 1.05)
    if style.skin == "curtain" and rng.random() < 0.6:
        pale = (0.13, 0.13, 0.135)
    lintel, head_m = _choose(rng, window.lintel), _between(rng, window.head)
    # The hood over a surround would run into a string course close above it.
    has_courses = style.skin == "punched" and (lintel != "surround" or head_m > 0.55)
    return Tower(
        facade=facade,
        seed=int(rng.integers(2**53)),
        tiers=draw_tiers(rng, footprint, street, storeys),
        levels_m=levels,
        wall=wall,
        trim=(trim_material, _shaken(rng, pale)),
        frame=_shaken(rng, _choose(rng, FRAMES)),
        glass=_shaken(rng, _choose(rng, GLASSES), 0.05),
        accent=_shaken(rng, _choose(rng, FRAMES), 0.2),
        bay_m=_between(rng, style.bay_m),
        margin_m=_between(rng, (0.4, 1.1)),
        window_width=_between(rng, window.width),
        sill_m=_between(rng, window.sill),
        head_m=head_m,
        reveal_m=_between(rng, window.reveal_m),
        frame_m=window.frame_m,
        pier_bays=int(rng.integers(3, 7)),
        fin_bays=int(rng.integers(1, 4)),
        fin_m=_choose(rng, (0.05, 0.05, 0.1, 0.16, 0.3)),
        spandrel_glass=bool(rng.random() < 0.55),
        columns=_choose(rng, window.columns),
        rows=_choose(rng, window.rows),
        lintel=lintel,
        cornice=_choose(rng, style.cornice),
        ground=_choose(rng, style.ground),
        pilaster_m=_between(rng, style.pilasters),
        balconies=style.balconies * float(rng.uniform(0.4, 1.2)),
        air_conditioners=window.air_conditioners * float(rng.uniform(0, 2)),
        balcony_m=_between(rng, (1.1, 1.7)),
        railing=_choose(rng, RAILINGS),
        courses=_choose(rng, (0, 0, 1, 3, 4)) if has_courses else 0,
        rusticated=bool(rng.random() < {"curtain": 1.0}.get(style.skin, 0.45)),
        roof=_choose(rng, style.roof),
    )


def tower(params: Tower, detail: int = 2) -> Model:
    """Build one city building in world coordinates, the ground at z = 0.

    Args:
        params: the building.
        detail: 2 near (every window in relief), 1 mid (flush panes), 0 far (textured walls).
    """
    rng = lane(params.seed, "tower")
    edges = edges_of(params.tiers)
    panels = Panels(edges.frames)
    cells = cells_of(params, edges, rng)
    add_ground(panels, params, edges, rng, detail)
    if detail == 0:
        far_walls(panels, params, edges, cells, rng)
    elif detail == 1:
        plain_walls(panels, params, edges, cells, rng)
    elif params.skin == "curtain":
        add_curtain(panels, params, edges, cells, rng)
    else:
        add_punched(panels, params, edges, cells, rng)
    if detail:
        add_balconies(panels, params, cells, rng, detail)
    if detail == 2 and STYLES[params.facade].escape:
        add_escapes(panels, params, edges, cells, rng)
    if detail:
        add_mouldings(panels, params, detail)
    if detail == 2:
        add_downpipes(panels, params, edges, cells, rng)
        add_mural(panels, params, edges, cells, rng)
    add_parapets(panels, params, rng, detail)
    add_roofs(panels, params, rng, detail)
    return panels.model()
