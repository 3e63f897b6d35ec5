"""Recipes: the TOML files that say what a dataset is drawn from."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from synthdepth.camera import Intrinsics
from synthdepth.config import Config, number, parse_toml, shown, shown_key
from synthdepth.errors import RecipeError
from synthdepth.flight.limits import FlightLimits
from synthdepth.maps.light import LightRanges
from synthdepth.maps.registry import MAPS
from synthdepth.render.sensor import SensorRanges
from synthdepth.render.settings import RenderSettings


@dataclasses.dataclass(frozen=True, kw_only=True)
class CameraRecipe(Config):
    """The camera of a dataset: a pinhole with square pixels.

    Attributes:
        width: [px].
        height: [px].
        fov_deg: horizontal field of view, unless `focal_px` is given.
        focal_px: focal length [px].
        cx, cy: principal point [px]; the image's middle unless given.
    """

    width: int = number(256, 16, 8192)
    height: int = number(256, 16, 8192)
    fov_deg: float = number(90.0, 5, 150)
    focal_px: float | None = number(None, 1, 1e5)
    cx: float | None = number(None, 0, 8192)
    cy: float | None = number(None, 0, 8192)

    def intrinsics(self) -> Intrinsics:
        """The intrinsics of every frame."""
        made = Intrinsics.from_fov(self.width, self.height, self.fov_deg)
        given = {"fx": self.focal_px, "fy": self.focal_px, "cx": self.cx, "cy": self.cy}
        known = {name: value for name, value in given.items() if value is not None}
        return dataclasses.replace(made, **known)


# AirSim's documented default capture, and KITTI's left colour camera (P_rect_02 of 2011_09_26).
CAMERAS = {
    "airsim": CameraRecipe(width=256, height=144, fov_deg=90.0),
    "kitti": CameraRecipe(width=1242, height=375, focal_px=721.5377, cx=609.5593, cy=172.854),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class SamplingRecipe(Config):
    """How pairs are taken from scenes and flights.

    A flight gives `pairs_per_flight` pairs in bursts of consecutive frames: within a burst every
    picture serves as frame t of one pair and frame t-1 of the next, so a burst of 8 pairs costs 9
    pictures, and bursts lie apart so that they show different places.

    Attributes:
        pairs_per_scene: one scene is one shard.
        pairs_per_flight: pairs of one flight.
        burst_pairs: pairs of one burst.
    """

    pairs_per_scene: int = number(256, 1, 100_000)
    pairs_per_flight: int = number(32, 1, 10_000)
    burst_pairs: int = number(8, 1, 10_000)

    @property
    def bursts_per_flight(self) -> int:
        """Number of bursts; the last one may be cut short."""
        return -(-self.pairs_per_flight // self.burst_pairs)

    @property
    def frames_per_flight(self) -> int:
        """Pictures that a flight's bursts take: a burst needs the frame before its first pair."""
        return self.bursts_per_flight * (self.burst_pairs + 1)

    @property
    def frames_per_scene(self) -> int:
        """Pictures that a whole scene takes."""
        return -(-self.pairs_per_scene // self.pairs_per_flight) * self.frames_per_flight


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recipe:
    """All that a dataset is drawn from, but its seed.

    Attributes:
        map: which generator builds the scenes.
        scene: the generator's own ranges.
        light, flight, camera, sensor, sampling, render: what their classes say.
    """

    map: str
    scene: Config
    light: LightRanges
    flight: FlightLimits
    camera: CameraRecipe
    sensor: SensorRanges
    sampling: SamplingRecipe
    render: RenderSettings

    def __post_init__(self):
        shortest = int(self.flight.duration_s[0] / self.flight.frame_interval_s + 1e-6) + 1
        if self.sampling.frames_per_flight > shortest:
            raise RecipeError(
                f"pairs_per_flight = {self.sampling.pairs_per_flight} in bursts of "
                f"{self.sampling.burst_pairs} takes {self.sampling.frames_per_flight} frames, but "
                f"the shortest flight (duration_s = {self.flight.duration_s[0]:g} s) has {shortest}"
            )

    def as_dict(self) -> dict:
        """The recipe as plain tables, as the manifest holds it."""
        return _plain(dataclasses.asdict(self))


def _plain(value):
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return list(value) if isinstance(value, tuple) else value


_SECTIONS = {
    "light": LightRanges,
    "flight": FlightLimits,
    "camera": CameraRecipe,
    "sensor": SensorRanges,
    "sampling": SamplingRecipe,
    "render": RenderSettings,
}


def scenes_folder() -> Path:
    """Where the shipped recipes lie: in an installed wheel, or beside the package's source."""
    installed = Path(__file__).resolve().parents[1] / "scenes"
    return installed if installed.is_dir() else installed.parents[1] / "scenes"


def shipped_recipes() -> dict[str, Path]:
    """The shipped recipes by name."""
    return {path.stem: path for path in sorted(scenes_folder().glob("*.toml"))}


def load_recipe(name_or_file: str) -> Recipe:
    """A shipped recipe by its name, or one of the user's own by its file.

    Raises:
        RecipeError: no such map or file, or something in it is not allowed.
    """
    shipped = shipped_recipes()
    path = shipped.get(name_or_file, Path(name_or_file))
    if name_or_file not in shipped and path.suffix != ".toml":
        raise RecipeError(
            f"--map {name_or_file} is unknown: the maps are {', '.join(shipped)}, or a .toml file"
        )
    try:
        table = parse_toml(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RecipeError(f"--map {path} does not exist") from None
    except (OSError, UnicodeDecodeError) as error:
        raise RecipeError(f"{path} cannot be read: {error}") from None
    except ValueError as error:
        raise RecipeError(f"{path} is not valid TOML: {error}") from None
    return recipe_from_table(table, path.name)


def recipe_from_table(table: Mapping, where: str) -> Recipe:
    """The recipe of a parsed TOML file or of a manifest's `recipe`."""
    allowed = ["map", "scene", *_SECTIONS]
    for key in table:
        if key not in allowed:
            raise RecipeError(
                f"{where}: {shown_key(key)} is unknown: allowed are {', '.join(allowed)}"
            )
    map_name = table.get("map")
    if not isinstance(map_name, str) or map_name not in MAPS:
        raise RecipeError(f"{where}: map = {shown(map_name)}: allowed are {', '.join(MAPS)}")
    parts = {
        name: kind.from_table(table.get(name, {}), f"{where}: [{name}]")
        for name, kind in _SECTIONS.items()
    }
    scene = MAPS[map_name].ranges.from_table(table.get("scene", {}), f"{where}: [scene]")
    try:
        return Recipe(map=map_name, scene=scene, **parts)
    except RecipeError as error:
        raise RecipeError(f"{where}: {error}") from None
