"""The command line: every command parses, calls one library function, and says what came of it."""

import contextlib
import dataclasses
import io
import json
import os
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

import synthdepth
from synthdepth.console import progress_bar, say
from synthdepth.errors import SynthdepthError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Render:
    """Render a dataset: pairs of frames with 200 m depth, in shards.

    Stopped in any way, the same command goes on where it was; with more --pairs it extends the
    dataset without rendering anything again.
    """

    map: str
    """Which map (see `synthdepth maps`), or a recipe file of your own (.toml)."""
    pairs: int
    """How many pairs the dataset shall hold."""
    out: Path | None = None
    """Folder of the dataset; data/<map>-seed<seed> by default."""
    seed: int = 0
    """Everything is drawn from it."""
    size: str | None = None
    """Image size, e.g. 256x256; the recipe's by default."""
    camera: str | None = None
    """airsim, kitti, or a .toml file with the keys of a recipe's [camera]."""
    max_depth_m: float | None = None
    """Where the depth saturates; the recipe's by default."""
    spp: int | None = None
    """Samples a pixel, a power of two; the recipe's by default."""
    pairs_per_scene: int | None = None
    """Pairs of one scene, which is one shard; the recipe's by default."""
    pairs_per_flight: int | None = None
    """Pairs of one flight; the recipe's by default."""
    burst_pairs: int | None = None
    """Pairs of consecutive frames in a row; 1 sets all pairs apart, at twice the cost."""
    modalities: tuple[str, ...] | None = None
    """Ground truth beside the depth: any of flow seg normal; the recipe's by default."""
    conditions: tuple[str, ...] | None = None
    """Light and weather that scenes draw from: any of clear golden_hour overcast haze fog wet
    night; the recipe's by default."""
    sensor: Literal["drawn", "ideal"] | None = None
    """Whether frames show a real camera's faults; ground truth never does."""
    train_share: float = 0.5
    """Share of the scenes that goes to the split train; the others go to test."""
    workers: int | None = None
    """Processes at once; by default one a core."""
    variant: Literal["cuda", "llvm", "scalar"] | None = None
    """How Mitsuba computes; by default the best that works here."""
    json: Path | None = None
    """Write the run's figures to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.production.overrides import with_overrides
        from synthdepth.production.recipe import load_recipe
        from synthdepth.production.run import render_dataset

        recipe = with_overrides(
            load_recipe(self.map),
            size=self.size,
            camera=self.camera,
            max_depth_m=self.max_depth_m,
            spp=self.spp,
            pairs_per_scene=self.pairs_per_scene,
            pairs_per_flight=self.pairs_per_flight,
            burst_pairs=self.burst_pairs,
            modalities=self.modalities,
            conditions=self.conditions,
            sensor=self.sensor,
        )
        out = self.out or Path("data") / f"{Path(self.map).stem}-seed{self.seed}"
        try:
            with progress_bar("rendering", "pairs") as progress:
                report = render_dataset(
                    recipe,
                    out,
                    pairs=self.pairs,
                    seed=self.seed,
                    train_share=self.train_share,
                    workers=self.workers,
                    variant=self.variant,
                    on_progress=progress,
                    on_backend=lambda backend: say(
                        f"renders with {backend.name}: {backend.reason}"
                    ),
                )
        except KeyboardInterrupt:
            say(f"\nstopped: finished shards in {out} are safe; the same command goes on")
            return 130
        speed = report.rendered / report.wall_s
        say(
            f"{out}: {report.pairs} pairs, {report.rendered} of them rendered now in "
            f"{report.wall_s:.0f} s ({speed:.2f} pairs/s, {100 * report.render_share:.0f} % of "
            "the workers' time in rendering)"
        )
        _write_json(self.json, dataclasses.asdict(report) | {"pairs_per_s": speed})
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Maps:
    """List the maps."""

    json: Path | None = None
    """Write the list to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.maps.registry import MAPS
        from synthdepth.production.recipe import load_recipe, shipped_recipes

        rows = {
            name: {"map": load_recipe(name).map, "recipe": str(path)}
            for name, path in shipped_recipes().items()
        }
        for name, row in rows.items():
            row["summary"] = MAPS[row["map"]].summary
            say(f"{name:16s} {row['summary']}\n{'':16s} {row['recipe']}")
        _write_json(self.json, rows)
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scene:
    """Write one generated world as glTF, for any 3D viewer."""

    map: str
    """Which map, or a recipe file."""
    seed: int
    """The scene's seed: `scene_seed` of a pair's meta.json rebuilds that pair's scene."""
    out: Path = Path("scene.glb")
    """The file to write."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.maps.gltf import check_glb_path, write_glb
        from synthdepth.maps.registry import build_world
        from synthdepth.production.recipe import load_recipe

        if not 0 <= self.seed < 2**63:
            raise SynthdepthError(f"--seed {self.seed}: allowed is a whole number from 0 to 2^63-1")
        check_glb_path(self.out)
        recipe = load_recipe(self.map)
        world = build_world(recipe.map, recipe.scene, recipe.light, self.seed)
        size = write_glb(world, self.out)
        say(f"{self.out}: {world.triangle_count} triangles, {size / 1e6:.0f} MB")
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Preview:
    """Write a contact sheet of a dataset: frame, previous frame and depth of random pairs."""

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    out: Path | None = None
    """The PNG to write; preview.png beside the dataset folder by default."""
    count: int = 24
    """How many pairs."""
    seed: int = 0
    """Which pairs."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.dataset.preview import preview

        # Beside, not inside: a dataset folder holds nothing but the dataset.
        out = self.out or Path(f"{self.folder.resolve()}-preview.png")
        count = preview(self.folder, out, count=self.count, seed=self.seed)
        say(f"{out}: {count} pairs")
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verify:
    """Check a dataset: checksums, counts, decoding, contract. Exit 1 if anything is wrong."""

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    json: Path | None = None
    """Write what was found to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.dataset.verify import verify

        with progress_bar("verifying", "pairs") as progress:
            report = verify(self.folder, on_progress=progress)
        for fault in report.faults:
            say(f"{fault.where}: {fault.what}")
        verdict = f"{len(report.faults)} faults" if report.faults else "no fault"
        say(f"{self.folder}: {report.shards} shards, {report.pairs} pairs, {verdict}")
        _write_json(self.json, dataclasses.asdict(report))
        return 1 if report.faults else 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Doctor:
    """Say what this machine has for rendering, and what to do about what is missing."""

    json: Path | None = None
    """Write the findings to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.render.doctor import examine

        findings = examine()
        for finding in findings:
            say(f"{'ok ' if finding.ok else 'NO '} {finding.name:10s} {finding.text}")
        _write_json(self.json, [dataclasses.asdict(finding) for finding in findings])
        return 0


_COMMANDS = {
    "render": Render,
    "maps": Maps,
    "scene": Scene,
    "preview": Preview,
    "verify": Verify,
    "doctor": Doctor,
}


def _write_json(path: Path | None, figures: Any) -> None:
    if path is None:
        return
    try:
        path.write_text(json.dumps(figures, indent=1, default=str) + "\n")
    except OSError as error:
        raise SynthdepthError(f"--json {path} cannot be written: {error.strerror}") from error


def _parse(arguments: list[str]) -> Any:
    """The command of the arguments; a parse error becomes a SynthdepthError of one line."""
    union = None
    for name, command in _COMMANDS.items():
        one = Annotated[command, tyro.conf.subcommand(name)]
        union = one if union is None else union | one
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                union,
                prog="synthdepth",
                description=synthdepth.__doc__,
                args=arguments,
                config=(tyro.conf.OmitSubcommandPrefixes,),
            )
    except SystemExit as stop:
        if not stop.code:
            raise
        raise SynthdepthError(_first_section(complaint.getvalue())) from None


def _first_section(box: str) -> str:
    """The message of a framed complaint, on one line."""
    words: list[str] = []
    for line in box.splitlines():
        text = line.strip("│ \t")
        if words and text.startswith(("──", "╰")):
            break
        if text and text[0] not in "╭╰─":
            words += text.split()
    return " ".join(words) or "the arguments cannot be read; see synthdepth --help"


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if arguments == ["--version"]:
        say(synthdepth.__version__)
        return 0
    try:
        return _parse(arguments).run()
    except SynthdepthError as error:
        sys.stderr.write(f"synthdepth: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # The reader of our output has gone (`| head`): nothing to complain about.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
