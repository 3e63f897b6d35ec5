"""Repairing a dataset: what is damaged is made again by recipe and seed, to the same bytes."""

import dataclasses
import functools
import hashlib
import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from synthdepth.dataset.card import write_card
from synthdepth.dataset.checksums import Settled, file_record, settle, with_files, write_checksums
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.manifest import (
    CHECKSUMS,
    DERIVED,
    DESCRIPTIONS,
    INDEX,
    MANIFEST,
    write_index,
    write_manifest,
)
from synthdepth.dataset.shard import sha256_of, sync_folder, write_whole
from synthdepth.dataset.verify_damage import REPAIR, Fault
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.production.ledger import software
from synthdepth.production.plan import ShardJob
from synthdepth.production.pool import PATIENCE_S, Finished, run_jobs
from synthdepth.production.recipe import Recipe, recipe_from_table
from synthdepth.production.run import default_workers, usable_cores
from synthdepth.production.shard_job import run_shard_job
from synthdepth.production.storage import LocalFolder
from synthdepth.render.backend import VARIANTS, Backend, activate, choose


@dataclasses.dataclass(frozen=True, kw_only=True)
class Repair:
    """What was done about a file.

    Attributes:
        where: the file.
        done: whether it is now as it should be.
        what: in one line.
    """

    where: str
    done: bool
    what: str


def repair(
    folder: Path,
    faults: Sequence[Fault],
    *,
    workers: int | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Repair]:
    """Make again what `verify` found wrong; what was not found wrong is not touched.

    A shard is put back only if it has the bytes that the manifest knows. What cannot be repaired
    stays as it is.

    Args:
        folder: the dataset.
        faults: that `verify` found in it.
        workers: processes that render; by default one a core.
        on_progress: called with (pairs rendered, pairs to render).

    Returns:
        What was done and what was not, a file each.

    Raises:
        DatasetError: there is no dataset, its run has not finished, or a run is writing to it.
    """
    folder = Path(folder)
    settled = settle(folder)
    if not settled.manifest["complete"]:
        raise DatasetError(f"{folder}: its run has not finished; the same render command goes on")
    scratch = folder / REPAIR
    with LocalFolder(folder).locked():
        shutil.rmtree(scratch, ignore_errors=True)
        try:
            repairs = [*_swept(folder, faults), *_left_alone(faults, settled.manifest)]
            repairs += _put_back(folder, faults, settled)
            wrong = {f.where for f in faults} - {one.where for one in repairs}
            todo = [r for r in settled.manifest["shards"] if r["path"] in wrong]
            if todo:
                repairs += _rendered(folder, todo, settled.manifest, workers, on_progress)
            lost = [one.where for one in repairs if not one.done and one.where.endswith(".tar")]
            repairs += _derived(folder, wrong, settled, lost)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    return repairs


def _swept(folder: Path, faults: Sequence[Fault]) -> Iterator[Repair]:
    """Remove what a killed run left."""
    for fault in faults:
        if fault.kind == "leftover":
            (folder / fault.where).unlink(missing_ok=True)
            yield Repair(where=fault.where, done=True, what="removed")


def _left_alone(faults: Sequence[Fault], manifest: Mapping) -> Iterator[Repair]:
    """What no repair can help."""
    words = {
        "stranger": "is left alone: remove it yourself if nobody wants it",
        "manifest": "was written so: render the dataset anew",
        "gate": "was written so, and rendering gives the same bytes: render the dataset anew",
    }
    if "source" in manifest:
        words["gate"] = "was imported so"
    for fault in faults:
        if fault.kind in words:
            yield Repair(where=fault.where, done=False, what=words[fault.kind])


def _put_back(folder: Path, faults: Sequence[Fault], settled: Settled) -> Iterator[Repair]:
    """Move files home whose bytes another name should have."""
    manifest = settled.manifest
    wrong = {fault.where for fault in faults if fault.kind not in ("gate", "manifest")}
    digests = {record["path"]: record["sha256"] for record in manifest["shards"]}
    digests |= {name: record["sha256"] for name, record in manifest.get("files", {}).items()}
    digests |= {name: hashlib.sha256(data).hexdigest() for name, data in settled.right.items()}
    homes = {digests[name]: name for name in wrong.intersection(digests)}
    found = {}
    for origin in sorted(wrong):
        path = folder / origin
        if path.is_file() and (name := homes.get(sha256_of(path))) is not None:
            found.setdefault(name, origin)
    for name, origin in found.items():
        (folder / REPAIR / name).parent.mkdir(parents=True, exist_ok=True)
        os.replace(folder / origin, folder / REPAIR / name)
    for name, origin in found.items():
        _put(folder, name)
        yield Repair(where=name, done=True, what=f"put back from {origin}")
        if origin not in digests and origin not in DESCRIPTIONS:
            yield Repair(where=origin, done=True, what=f"moved to {name}")
    for fault in faults:
        if fault.kind == "misplaced" and fault.where not in found.values():
            what = "is left alone, as its bytes are in their place: remove it yourself"
            yield Repair(where=fault.where, done=False, what=what)


def _put(folder: Path, name: str) -> None:
    """Give a file that was made in the scratch folder its place."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    os.replace(folder / REPAIR / name, path)
    sync_folder(path.parent)


def _rendered(
    folder: Path,
    todo: Sequence[Mapping],
    manifest: Mapping,
    workers: int | None,
    on_progress: Callable[[int, int], None],
) -> Iterator[Repair]:
    """Render shards; from the first on that has other bytes than it should, none are."""
    try:
        recipe, backend = means_of(manifest)
    except SynthdepthError as error:
        for record in todo:
            yield Repair(where=record["path"], done=False, what=f"cannot be made again: {error}")
        return
    jobs = [
        ShardJob(
            **{name: r[name] for name in ("scene_index", "scene_seed", "split", "path", "pairs")}
        )
        for r in todo
    ]
    workers = min(workers or default_workers(), len(jobs))
    work = functools.partial(
        _render,
        recipe=recipe,
        scratch=folder / REPAIR,
        backend=backend,
        threads=max(1, usable_cores() // workers),
    )
    done, total, left = [0] * len(jobs), sum(job.pairs for job in jobs), list(jobs)
    on_progress(0, total)
    why = "not tried"
    events = run_jobs(work, jobs, workers, patience_s=PATIENCE_S)
    try:
        for event in events:
            if not isinstance(event, Finished):
                done[event.job] = event.done
                on_progress(sum(done), total)
                continue
            record = todo[event.job]
            left.remove(jobs[event.job])
            if event.result["sha256"] != record["sha256"]:
                why = f"renders to other bytes {_difference(manifest, backend)}"
                yield Repair(where=record["path"], done=False, what=why)
                break
            _put(folder, record["path"])
            yield Repair(where=record["path"], done=True, what="rendered again to the same bytes")
    except SynthdepthError as error:
        why = f"cannot be rendered: {error}"
    finally:
        events.close()
    for job in left:
        yield Repair(where=job.path, done=False, what=why)


def means_of(manifest: Mapping) -> tuple[Recipe, Backend]:
    """What a dataset was rendered from and with.

    Raises:
        SynthdepthError: it was not, or cannot be here.
    """
    if "source" in manifest:
        raise DatasetError(
            f"the dataset was imported from {manifest['source']['kind']}, not rendered; import the "
            f"recordings again: {', '.join(manifest['source']['recordings'])}"
        )
    names = {variant: name for name, variant in VARIANTS.items()}
    variant = manifest["software"].get("variant")
    if variant not in names:
        raise DatasetError(f"it was made with the variant {variant}: known are {', '.join(names)}")
    return recipe_from_table(manifest["recipe"], MANIFEST), choose(names[variant])


def _difference(manifest: Mapping, backend: Backend) -> str:
    """In what the software of a dataset differs from what is here."""
    then, here = manifest["software"], software(backend.variant)
    differ = [
        f"{name} {here[name]}, not {then.get(name)}"
        for name in here
        if here[name] != then.get(name)
    ]
    if differ:
        return f"with the versions that are here: {'; '.join(differ)}"
    return "though the versions are the same: another kind of processor, or changed code"


def _render(
    job: ShardJob,
    report: Callable[[int], None],
    *,
    recipe: Recipe,
    scratch: Path,
    backend: Backend,
    threads: int,
) -> dict:
    """What a worker process does."""
    activate(backend, threads)
    return run_shard_job(job, recipe, scratch, report)


def _derived(
    folder: Path, wrong: set[str], settled: Settled, lost: Sequence[str]
) -> Iterator[Repair]:
    """Make the files anew that tell of the shards, and the two that tell of all files."""
    wrong = wrong.intersection(DESCRIPTIONS)
    if not wrong and settled.sealed:
        return
    manifest = settled.manifest
    made = [name for name in DERIVED if name in wrong]
    if made and lost:
        for name in made:
            what = f"cannot be made again as long as {lost[0]} is not whole"
            yield Repair(where=name, done=False, what=what)
        made = []
    if made:
        _make(folder, manifest, made)
    same = True
    for name in made:
        same &= file_record(folder / name) == manifest.get("files", {}).get(name)
        yield Repair(where=name, done=True, what="made again")
    if not settled.sealed and lost:
        return
    if same and settled.sealed:
        for name in sorted(wrong.intersection(settled.right)):
            write_whole(folder / name, settled.right[name])
            yield Repair(where=name, done=True, what="restored")
        return
    # By other versions of the libraries they have other bytes: what tells of them has to follow.
    manifest = with_files(folder, manifest)
    write_checksums(folder, manifest)
    write_manifest(folder, manifest)
    for name in (MANIFEST, CHECKSUMS):
        yield Repair(where=name, done=True, what="written anew")


def _make(folder: Path, manifest: Mapping, names: Sequence[str]) -> None:
    """Make derived files in the scratch folder, and give some of them their places."""
    scratch = folder / REPAIR
    scratch.mkdir(exist_ok=True)
    for split in {record["split"] for record in manifest["shards"]}:
        shutil.rmtree(scratch / split, ignore_errors=True)
        (scratch / split).symlink_to(folder.resolve() / split, target_is_directory=True)
    if INDEX in names:
        write_index(scratch, manifest)
    else:
        shutil.copyfile(folder / INDEX, scratch / INDEX)
    write_card(scratch, manifest)
    write_croissant(scratch, manifest)
    for name in names:
        _put(folder, name)
