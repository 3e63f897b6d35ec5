"""Runs whose shards are made by formula in milliseconds, in this process: all but the rendering."""

import json
from pathlib import Path

from synthdepth.dataset.checksums import checksums_bytes
from synthdepth.dataset.manifest import CHECKSUMS, MANIFEST, manifest_bytes
from synthdepth.dataset.pair import pair_key
from synthdepth.dataset.shard import ShardWriter, read_members, shard_members
from synthdepth.production import run
from synthdepth.production.overrides import with_overrides
from synthdepth.production.pool import Finished, Progress
from synthdepth.production.recipe import load_recipe
from synthdepth.production.shard_job import shard_record
from synthdepth.production.studio import Cost
from tests.made import CAMERA, CONDITIONS, _members, _pose

PAIRS, PAIRS_PER_SHARD = 8, 3


def recipe():
    """Shards of three pairs."""
    return with_overrides(
        load_recipe("blocks"), size=f"{CAMERA.width}x{CAMERA.height}", pairs_per_scene=3,
        pairs_per_flight=3, burst_pairs=3,
    )  # fmt: skip


def made_shard(job, recipe, folder, progress):
    """As `shard_job.run_shard_job`, without a scene: pairs that are there are copied."""
    path = Path(folder) / job.path
    ready = shard_members(path) if job.extends else {}
    with ShardWriter(path) as shard:
        for key, members in ready.items():
            shard.add(key, read_members(path, members))
        for frame in range(len(ready) + 1, job.pairs + 1):
            known = {name: getattr(job, name) for name in ("scene_index", "scene_seed", "split")}
            known |= {"frame_index": frame, "condition": CONDITIONS[job.scene_index % 3]}
            poses = [_pose(step, 5.0 + job.scene_index, 0.1) for step in (frame - 1, frame)]
            key = pair_key("blocks", job.scene_index, 0, frame)
            shard.add(key, _members(CAMERA, poses, known, (), recipe.render.max_depth_m))
            progress(frame)
    cost = Cost(render_s=[0.0] * (job.pairs - len(ready)))
    return shard_record(job, shard.sha256, shard.size, cost, [])


def in_this_process(function, jobs, workers, *, patience_s):
    """As `pool.run_jobs`, without processes."""
    for number, job in enumerate(jobs):
        told = []
        result = function(job, told.append)
        yield from (Progress(number, done) for done in told)
        yield Finished(number, result)


def without_rendering(monkeypatch, shard=made_shard, run_jobs=in_this_process):
    """Have `run.render_dataset` make its shards by formula."""
    monkeypatch.setattr(run, "run_shard_job", shard)
    monkeypatch.setattr(run, "run_jobs", run_jobs)
    monkeypatch.setattr(run, "activate", lambda backend, threads: None)


def render(place, pairs=PAIRS, **options):
    """A run over all but the rendering."""
    return run.render_dataset(recipe(), place, pairs=pairs, variant="scalar", **options)


def contents(folder):
    """{name: bytes} of every file, hidden and half-written ones too, but for what a kill loses."""
    files = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in Path(folder).rglob("*")
        if path.is_file()
    }
    manifest = json.loads(files[MANIFEST])
    shards = [record | {"cost": None, "redrawn": None} for record in manifest["shards"]]
    files[MANIFEST] = manifest_bytes(manifest | {"shards": shards})
    if CHECKSUMS in files and manifest["complete"]:
        # They are those of the manifest, costs and all.
        assert files[CHECKSUMS] == checksums_bytes(manifest)
        files[CHECKSUMS] = b""
    return files
