"""One shard job: render a scene's pairs, let no wrong one through, write the shard."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from synthdepth.dataset.gate import gate_shard
from synthdepth.dataset.gate_check import Check
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.shard import ShardWriter, read_members, sha256_of, shard_members
from synthdepth.dataset.verify_shard import pair_checks
from synthdepth.errors import SynthdepthError
from synthdepth.maps.world import LABELS
from synthdepth.production.plan import ShardJob
from synthdepth.production.recast import recast_faults
from synthdepth.production.recipe import Recipe
from synthdepth.production.shots import Shot
from synthdepth.production.studio import Cost, Studio, adding_time
from synthdepth.seeding import lane


class GateError(SynthdepthError):
    """A shard cannot pass the gate.

    Attributes:
        key: of the pair that fails, or of the first of those that fail together.
    """

    def __init__(self, message: str, key: str):
        super().__init__(message)
        self.key = key

    def __reduce__(self):
        return GateError, (self.args[0], self.key)


def run_shard_job(
    job: ShardJob, recipe: Recipe, folder: Path, progress: Callable[[int], None]
) -> dict:
    """Render one shard and return its record for the manifest.

    Pairs that an earlier, shorter shard of the same scene holds are copied, not rendered again. A
    pair that fails the gate gives its place to another frame of its flight.

    Args:
        job: which scene, how many pairs.
        recipe: what it is drawn from.
        folder: the dataset folder.
        progress: called with the number of pairs done so far.

    Raises:
        GateError: a pair fails, and so does what is drawn instead; or all pairs together do.
    """
    cost, redrawn, judged = Cost(), [], []
    path = Path(folder) / job.path
    ready = _ready(path, job)
    with ShardWriter(path) as shard:
        for key, members in ready.items():
            shard.add(key, read_members(path, members))
        progress(len(ready))
        studio = Studio(job, recipe, cost)
        for shot, key in zip(studio.shots, ready, strict=False):
            if key != studio.key(shot):
                redrawn.append(_known(job, studio.key(shot), key))
        for done, shot in enumerate(studio.shots[len(ready) :], start=len(ready) + 1):
            key, files, checks, why = _passing(studio, shot, job, recipe)
            if why:
                redrawn.append({"key": key, "instead_of": studio.key(shot), "why": why})
            judged.append(checks)
            with adding_time(cost, "encode_s"):
                shard.add(key, files)
            progress(done)
        for check in gate_shard(judged):
            first = studio.key(studio.shots[len(ready)])
            raise GateError(f"{job.path} fails the gate: {check.fault}", first)
    return shard_record(job, shard.sha256, shard.size, cost, redrawn)


def shard_record(
    job: ShardJob, sha256: str, size: int, cost: Cost | None, redrawn: list[dict] | None = None
) -> dict:
    """A shard's entry in the manifest; `cost` and `redrawn` are None where a kill lost them."""
    spent = None
    if cost is not None:
        spent = dataclasses.asdict(cost)
        spent = {
            name: [round(s, 4) for s in value] if isinstance(value, list) else round(value, 3)
            for name, value in spent.items()
        }
    return {
        "path": job.path,
        "split": job.split,
        "scene_index": job.scene_index,
        "scene_seed": job.scene_seed,
        "pairs": job.pairs,
        "bytes": size,
        "sha256": sha256,
        "redrawn": redrawn,
        "cost": spent,
    }


def pair_faults(
    studio: Studio, key: str, files: Mapping[str, bytes], job: ShardJob, recipe: Recipe
) -> tuple[list[Check], list[str]]:
    """The gate's checks of a rendered pair, and all that is wrong with it.

    Args:
        studio: that rendered it.
        key: of the pair.
        files: of the pair, as they are written.
        job: of its scene.
        recipe: that it was drawn from.
    """
    record = {name: getattr(job, name) for name in ("split", "scene_index", "scene_seed")}
    checks = pair_checks(key, files, record, _manifest_of(recipe))
    faults = [check.fault for check in checks if check.fault]
    if not faults:
        pair = decode_pair(key, files)
        places = pair.meta["flight_index"], pair.meta["frame_index"]
        rng = lane(job.scene_seed, "recast", *places)
        faults += recast_faults(rng, pair, studio.renderer.reach)
    return checks, faults


def _passing(
    studio: Studio, shot: Shot, job: ShardJob, recipe: Recipe
) -> tuple[str, dict[str, bytes], list[Check], str]:
    """Key, files and checks of a shot's pair or of the first spare that passes.

    Last comes why the pair itself did not; "" if it did.
    """
    why = ""
    for one in _with_spares(studio, shot):
        key = studio.key(one)
        files = studio.files(one)
        with adding_time(studio.cost, "gate_s"):
            checks, faults = pair_faults(studio, key, files, job, recipe)
        if not faults:
            return key, files, checks, why
        why = why or faults[0]
    key = studio.key(shot)
    told = f"the pair {key} fails the gate, and so does what was drawn instead"
    raise GateError(f"{told} (scene seed {job.scene_seed}): {why}", key)


def _with_spares(studio: Studio, shot: Shot) -> Iterator[Shot]:
    yield shot
    yield from studio.spares(shot)


def _ready(path: Path, job: ShardJob) -> dict:
    """What a shorter shard holds, if there is one, and it is whole; else nothing."""
    if not path.exists() or job.extends is None or sha256_of(path) != job.extends["sha256"]:
        return {}
    return shard_members(path)


def _known(job: ShardJob, planned: str, key: str) -> dict:
    """What the record of the shorter shard says of a pair that was drawn again."""
    for entry in job.extends.get("redrawn") or []:
        if entry["key"] == key:
            return entry
    return {"key": key, "instead_of": planned, "why": None}


def _manifest_of(recipe: Recipe) -> dict:
    """What the gate asks of a manifest."""
    return {
        "map": recipe.map,
        "depth": {"max_depth_m": recipe.render.max_depth_m},
        "recipe": recipe.as_dict(),
        "labels": LABELS if "seg" in recipe.render.modalities else {},
    }
