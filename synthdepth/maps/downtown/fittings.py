"""What stands on the pavements of a downtown, gathered first and built in one go."""

import dataclasses

import numpy as np

from synthdepth.maps.downtown.surface import KERB_HEIGHT_M
from synthdepth.maps.furniture.signs import signs, street_lamps
from synthdepth.maps.furniture.street_furniture import scatter_furniture
from synthdepth.maps.geometry import Model
from synthdepth.maps.people import people
from synthdepth.maps.placement import distance_to
from synthdepth.maps.vegetation.trees import plant


@dataclasses.dataclass
class Fittings:
    """Places by kind, each an x, y [m], a yaw [rad] and a height [m].

    Attributes:
        models: what is built already.
        furniture: by name.
        lamps: by kind.
        signs: by kind.
        trees: x, y by species.
        people: by pose; "" is a mixture.
    """

    models: list[Model] = dataclasses.field(default_factory=list)
    furniture: dict[str, list] = dataclasses.field(default_factory=dict)
    lamps: dict[str, list] = dataclasses.field(default_factory=dict)
    signs: dict[str, list] = dataclasses.field(default_factory=dict)
    trees: dict[str, list] = dataclasses.field(default_factory=dict)
    people: dict[str, list] = dataclasses.field(default_factory=dict)

    def add(self, kind: str, name: str, xy, yaw_rad=0.0, z_m: float = KERB_HEIGHT_M) -> None:
        """Adds things at `xy` (k, 2) to one of the tables by name; on the pavement by default."""
        xy = np.asarray(xy, float).reshape(-1, 2)
        yaw = np.broadcast_to(np.asarray(yaw_rad, float), len(xy))
        rows = np.column_stack([xy, yaw, np.full(len(xy), z_m)])
        getattr(self, kind).setdefault(name, []).append(rows)

    def rows(self, kind: str) -> dict[str, np.ndarray]:
        """A table by name, each (k, 4)."""
        table = getattr(self, kind)
        return {name: np.concatenate(table[name]) for name in sorted(table)}

    def build(self, rng: np.random.Generator, bounds: np.ndarray) -> list[Model]:
        """All of it; what is far from the square that flights keep to is coarse or left out."""
        kinds = ("furniture", "lamps", "signs", "trees", "people")
        lanes = dict(zip(kinds, rng.spawn(5), strict=True))
        models = list(self.models)
        for name, rows in self.rows("furniture").items():
            rows = rows[distance_to(bounds, rows) < 60]
            models.append(scatter_furniture(lanes["furniture"], name, _feet(rows), rows[:, 2]))
        for kind, rows in self.rows("lamps").items():
            models.append(street_lamps(lanes["lamps"], _feet(rows), rows[:, 2], kind))
        for kind, rows in self.rows("signs").items():
            rows = rows[distance_to(bounds, rows) < 80]
            models.append(signs(lanes["signs"], _feet(rows), rows[:, 2], kind))
        for pose, rows in self.rows("people").items():
            rows = rows[distance_to(bounds, rows) < 15]
            if len(rows):
                models.append(people(lanes["people"], _feet(rows), rows[:, 2], pose=pose or None))
        trees = self.rows("trees")
        if trees:
            feet = np.concatenate([_feet(rows) for rows in trees.values()])
            species = np.repeat(list(trees), [len(rows) for rows in trees.values()])
            models.append(plant(lanes["trees"], feet, species, distance_to(bounds, feet), 4))
        return models


def _feet(rows: np.ndarray) -> np.ndarray:
    """Where things stand, (k, 3)."""
    return rows[:, [0, 1, 3]]
