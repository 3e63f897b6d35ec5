"""What a dataset that is being written holds: the records of its whole shards, and its manifest."""

import dataclasses
import importlib.metadata
import os
import platform
import time
from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa

import synthdepth
from synthdepth.dataset.card import sheet_shards, write_card
from synthdepth.dataset.checksums import with_files, write_checksums
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.manifest import (
    CHECKSUMS,
    DESCRIPTIONS,
    MANIFEST,
    check_identity,
    index_table,
    read_manifest,
    write_index,
    write_manifest,
)
from synthdepth.dataset.pair import META_FIELDS, SCHEMA_VERSION, scene_of_key
from synthdepth.dataset.shard import sha256_of, shard_members
from synthdepth.errors import DatasetError
from synthdepth.maps.world import LABELS
from synthdepth.production.plan import plan_shards
from synthdepth.production.recipe import Recipe
from synthdepth.production.shard_job import shard_record
from synthdepth.production.storage import GoneError, Storage
from synthdepth.render.backend import Backend

# Shards may end faster than a large manifest can be written: at most so often, and for at most so
# large a share of the time. What a kill loses of a shard is what it cost.
_SAVE_EVERY_S, _SAVE_SHARE = 5.0, 0.05
# A tar archive ends in two blocks of zeros.
_TAR_END = bytes(1024)


def software(variant: str) -> dict:
    """What decides the bytes of a rendering beside its recipe: versions, variant, machine."""
    version = importlib.metadata.version
    return {
        "synthdepth": synthdepth.__version__,
        "mitsuba": version("mitsuba"),
        "numpy": version("numpy"),
        "variant": variant,
        "machine": platform.machine(),
    }


def blank_manifest(recipe: Recipe, seed: int, train_share: float, backend: Backend) -> dict:
    """The manifest of a dataset without shards."""
    return {
        "schema_version": SCHEMA_VERSION,
        "map": recipe.map,
        "seed": seed,
        "train_share": train_share,
        "pairs_planned": 0,
        "complete": False,
        "splits": {},
        "software": software(backend.variant),
        "depth": {
            "unit": "metre",
            "convention": "planar",
            "channel": "Z",
            "dtype": "float32",
            "max_depth_m": recipe.render.max_depth_m,
        },
        "meta_fields": list(META_FIELDS),
        "labels": LABELS if "seg" in recipe.render.modalities else {},
        "recipe": recipe.as_dict(),
        "shards": [],
    }


class Ledger:
    """The records of a dataset's whole shards, in memory and in its manifest.

    The manifest says that the dataset is complete last of all, when everything else is written.

    Args:
        storage: where the dataset is.
        work: the storage's workspace.
        asked: the dataset's `blank_manifest`.
        pairs: how many pairs it shall hold; it keeps what it has beyond.

    Attributes:
        records: of the shards, by path.

    Raises:
        DatasetError: something else lies there.
    """

    def __init__(self, storage: Storage, work: Path, asked: Mapping, pairs: int):
        self._storage, self._work, self._asked = storage, work, asked
        self._rows: dict[str, Path] = {}
        self._save_at, self._unsaved = 0.0, False
        self.records = self._records_there()
        self._planned = max(pairs, self.pairs)

    @property
    def pairs(self) -> int:
        """Pairs in whole shards."""
        return sum(record["pairs"] for record in self.records.values())

    def pairs_of(self, path: str) -> int:
        """Pairs in a shard; 0 if there is none."""
        return self.records.get(path, {"pairs": 0})["pairs"]

    def add(self, record: dict, rows: pa.Table | None) -> None:
        """Note a shard that is there now, with its rows of the index if they are not to be lost."""
        self.records[record["path"]] = record
        self._unsaved = True
        if rows is not None:
            path = self._work / f"{record['path']}.rows"
            path.parent.mkdir(parents=True, exist_ok=True)
            with pa.ipc.new_file(path, rows.schema) as file:
                file.write_table(rows)
            self._rows[record["path"]] = path

    def save(self) -> None:
        """Write the manifest, if anything is new and it was not written just now.

        Raises:
            GoneError: the dataset is not there any more.
        """
        if self._unsaved and time.monotonic() >= self._save_at:
            self._storage.check()
            self._write(self._manifest())

    def start(self) -> None:
        """Write the manifest before the first shard."""
        self._storage.remove(CHECKSUMS)  # They would be of an earlier state from now on.
        self._write(self._manifest())

    def finish(self) -> None:
        """Write what is made of all shards, from the index to the checksums; the manifest last.

        Raises:
            GoneError: a shard is not there any more.
        """
        self._storage.check()
        self._check_shards()
        final = self._manifest() | {"complete": self.pairs >= self._planned}
        write_index(self._work, final, self._index_table)
        for path in sheet_shards(self._work):
            self._storage.pull(self._work, path)
        write_card(self._work, final)
        write_croissant(self._work, final)
        final = with_files(self._work, final)
        write_checksums(self._work, final)
        for name in DESCRIPTIONS:
            if name != MANIFEST:
                self._storage.push(self._work, name)
        self._write(final)

    def _manifest(self) -> dict:
        shards = sorted(self.records.values(), key=lambda record: record["scene_index"])
        splits: dict[str, int] = {}
        for record in shards:
            splits[record["split"]] = splits.get(record["split"], 0) + record["pairs"]
        return {**self._asked, "pairs_planned": self._planned, "splits": splits, "shards": shards}

    def _write(self, manifest: Mapping) -> None:
        started = time.monotonic()
        write_manifest(self._work, manifest)
        self._storage.push(self._work, MANIFEST)
        ended = time.monotonic()
        self._save_at = ended + max(_SAVE_EVERY_S, (ended - started) / _SAVE_SHARE)
        self._unsaved = False

    def _check_shards(self) -> None:
        sizes = self._storage.files()
        for path, record in self.records.items():
            if sizes.get(path) != record["bytes"]:
                raise GoneError(
                    f"{self._storage.place}: {path} was deleted or changed during the run: run "
                    "again, and it is rendered again"
                )

    def _index_table(self, record: Mapping) -> pa.Table:
        path = record["path"]
        if path in self._rows:
            with pa.ipc.open_file(self._rows[path]) as file:
                return file.read_all()
        table = index_table(self._storage.pull(self._work, path), path, self._asked)
        self._storage.drop(self._work, path)
        return table

    def _records_there(self) -> dict[str, dict]:
        there = self._storage.files()
        if MANIFEST in there:
            manifest = read_manifest(self._storage.pull(self._work, MANIFEST).parent)
            check_identity(self._storage.place, manifest, self._asked)
        elif there:
            raise DatasetError(
                f"{self._storage.place} holds {min(there)!r} and no dataset: choose an empty or "
                "new --out"
            )
        else:
            manifest = self._asked
        known = {record["path"]: record for record in manifest["shards"]}
        records = {}
        for path, size in sorted(there.items()):
            if not path.endswith(".tar"):
                continue
            record = known.get(path)
            if record is None or record["bytes"] != size:
                record = self._record_of(path)
                self._storage.drop(self._work, path)
            if record is not None:
                records[path] = record
        return records

    def _record_of(self, path: str) -> dict | None:
        """The record of a shard that got its name just before a kill; None where it is not ours."""
        file = self._storage.pull(self._work, path)
        try:
            keys = list(shard_members(file))
            scene_index = scene_of_key(keys[0])
            if not _ends_as_tar(file):
                return None
        except (ValueError, IndexError):
            return None
        per_scene = self._asked["recipe"]["sampling"]["pairs_per_scene"]
        job = plan_shards(
            map_name=self._asked["map"],
            seed=self._asked["seed"],
            pairs=(scene_index + 1) * per_scene,
            pairs_per_scene=per_scene,
            train_share=self._asked["train_share"],
        )[-1]
        if job.path != path:
            return None
        job = dataclasses.replace(job, pairs=len(keys))
        return shard_record(job, sha256_of(file), file.stat().st_size, None)


def _ends_as_tar(path: Path) -> bool:
    with open(path, "rb") as file:
        file.seek(-len(_TAR_END), os.SEEK_END)
        return file.read() == _TAR_END
