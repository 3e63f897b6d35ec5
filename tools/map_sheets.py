"""A picture of every map for the documentation: frames of seven scenes, one in each condition.

    python tools/map_sheets.py --maps city coastline --out docs

Scenes are rendered as a user gets them, sensor and all; each gives frames of different flights.
"""

import dataclasses
import tempfile
from pathlib import Path

import cv2
import numpy as np
import tyro

from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.preview import colour_depth
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.maps.registry import MAPS
from synthdepth.maps.world import CONDITIONS
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import render_dataset

COLUMNS, ROWS, TILE_PX = 8, 3, 150


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to draw.

    Attributes:
        maps: which; all by default.
        out: folder of the pictures, <map>.jpg each.
        seed: of the datasets.
    """

    maps: tuple[str, ...] = tuple(MAPS)
    out: Path = Path("docs")
    seed: int = 0


def frames(map_name: str, seed: int, folder: Path) -> list[np.ndarray]:
    """Frames over their depth, (2 TILE_PX, TILE_PX, 3) uint8 RGB, of one scene a condition."""
    count = -(-COLUMNS * ROWS // len(CONDITIONS))
    found = []
    for number, condition in enumerate(CONDITIONS):
        recipe = with_overrides(
            load_recipe(map_name),
            conditions=(condition,),
            pairs_per_scene=count,
            pairs_per_flight=1,
            burst_pairs=1,
        )
        where = folder / f"{map_name}-{condition}"
        render_dataset(recipe, where, pairs=count, seed=seed + number, train_share=1.0)
        (shard,) = where.glob("train/*.tar")
        for key, members in shard_members(shard).items():
            pair = decode_pair(key, read_members(shard, members))
            depth = colour_depth(pair.depth_m, pair.meta["max_depth_m"])
            tiles = [
                cv2.resize(image, (TILE_PX, TILE_PX), interpolation=cv2.INTER_AREA)
                for image in (pair.rgb, depth)
            ]
            found.append(np.concatenate(tiles))
        print(f"{map_name}: {condition} is done", flush=True)
    # One of each condition first, so that what is left over is of no one condition.
    order = np.argsort([i % count for i in range(len(found))], kind="stable")
    return [found[i] for i in order[: COLUMNS * ROWS]]


def main(options: Options) -> None:
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.maps:
        with tempfile.TemporaryDirectory() as folder:
            tiles = frames(name, options.seed, Path(folder))
        rows = [
            np.concatenate(tiles[k : k + COLUMNS], axis=1) for k in range(0, len(tiles), COLUMNS)
        ]
        sheet = cv2.cvtColor(np.concatenate(rows), cv2.COLOR_RGB2BGR)
        path = options.out / f"{name}.jpg"
        cv2.imwrite(str(path), sheet, [cv2.IMWRITE_JPEG_QUALITY, 85])
        print(path, flush=True)


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
