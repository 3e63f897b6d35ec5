"""One pair of a dataset, rendered again alone."""

import dataclasses
from pathlib import Path

from synthdepth.dataset.checksums import settle
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.pair import pair_key, scene_of_key
from synthdepth.errors import DatasetError
from synthdepth.production.plan import plan_shards
from synthdepth.production.repair import means_of
from synthdepth.production.shard_job import pair_faults
from synthdepth.production.shots import Shot
from synthdepth.production.studio import Cost, Studio
from synthdepth.render.backend import activate


@dataclasses.dataclass(frozen=True, kw_only=True)
class SinglePair:
    """A pair that was rendered alone.

    Attributes:
        folder: where its files are.
        scene_seed: of its scene.
        faults: what the gate finds wrong with it.
    """

    folder: Path
    scene_seed: int
    faults: list[str]


def render_pair(folder: Path, key: str, out: Path) -> SinglePair:
    """Render one pair by the manifest of its dataset, which need not be finished.

    Args:
        folder: the dataset.
        key: of the pair: one that is in it, will be, or failed the gate.
        out: where its files go; a new or empty folder.

    Raises:
        SynthdepthError: there is no such dataset or pair, or it cannot be rendered here.
    """
    manifest = settle(Path(folder)).manifest
    recipe, backend = means_of(manifest)
    sampling = recipe.sampling
    try:
        scene_index = scene_of_key(key)
        flight_index = int(key.rsplit("-f", 1)[1].split("-")[0])
    except ValueError as error:
        raise DatasetError(str(error)) from None
    flights = -(-sampling.pairs_per_scene // sampling.pairs_per_flight)
    if pair_key(recipe.map, scene_index, flight_index, 0)[:-4] != key[: key.rindex("-") + 1] or (
        flight_index >= flights
    ):
        raise DatasetError(f"{key} is no pair of {folder}")
    job = plan_shards(
        map_name=recipe.map,
        seed=manifest["seed"],
        pairs=(scene_index + 1) * sampling.pairs_per_scene,
        pairs_per_scene=sampling.pairs_per_scene,
        train_share=manifest["train_share"],
    )[-1]
    needed = min((flight_index + 1) * sampling.pairs_per_flight, job.pairs)
    activate(backend)
    with new_folder(out) as made:
        studio = Studio(dataclasses.replace(job, pairs=needed), recipe, Cost())
        files = studio.files(_shot_of(studio, key, folder))
        for suffix, data in files.items():
            (made / f"{key}.{suffix}").write_bytes(data)
    _, faults = pair_faults(studio, key, files, job, recipe)
    return SinglePair(folder=Path(out), scene_seed=job.scene_seed, faults=faults)


def _shot_of(studio: Studio, key: str, folder: Path) -> Shot:
    for shot in studio.shots:
        for one in (shot, *studio.spares(shot)):
            if studio.key(one) == key:
                return one
    raise DatasetError(f"{key} is no pair of {folder}: that frame was never drawn")
