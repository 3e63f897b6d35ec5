"""All that a training is decided by, in one checked record that is saved with the weights."""

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from synthdepth.config import Config, choice, number, parse_json, parse_toml, shown
from synthdepth.errors import RecipeError
from synthdepth.pix2pix.augment import AugmentationConfig
from synthdepth.pix2pix.discriminator import DiscriminatorConfig
from synthdepth.pix2pix.generator import GeneratorConfig
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.pix2pix.objective import ObjectiveConfig
from synthdepth.pix2pix.target import DepthCoding

_LEAST_SIDE_PX, _MOST_SIDE_PX = 16, 8192
_PARTS = {
    "input": InputConfig,
    "coding": DepthCoding,
    "generator": GeneratorConfig,
    "discriminator": DiscriminatorConfig,
    "objective": ObjectiveConfig,
    "augmentation": AugmentationConfig,
}
# What may differ when a training goes on: no weight depends on it.
FREE = ("workers", "checkpoint_minutes")


@dataclasses.dataclass(frozen=True, kw_only=True)
class TrainConfig(Config):
    """A training. As it stands it is the paper's (100 epochs, batch 1, lambda 100) and, where the
    paper is silent, that of the authors of Pix2Pix, but for two things that measurably help and
    cost nothing: depth is coded by its logarithm, and the model is an average of the weights. The
    paper's are `coding.kind = "linear"` and `ema = 0`.

    Attributes:
        input: what the generator is given. The channels of both networks follow from it.
        coding, generator, discriminator, objective, augmentation: what their classes say.
            Without `objective.lambda_gan` there is no discriminator, and a step costs a fifth less.
        epochs: passes over the training pairs.
        batch_size: pairs of a step in each process; what is left over of a pass is not used in it.
        lr, beta1, beta2: of Adam, for both networks.
        decay: "none", or "linear": lr falls to 0 over the second half.
        ema: decay of an average of the generator's weights over the steps, which is validated and
            saved as the model; 0 is none.
        seed: of the first weights, the order, the noise and all that is drawn.
        size: (width, height) to bring the pairs to [px]; None leaves them as they are.
        precision: "fp32", or "bf16" for the networks' inside: about twice as fast where the
            machine has it (AMX, tensor cores). Losses, weights and depth stay float32.
        compile: let torch compile both networks: minutes at first, then faster on a GPU.
        validate_every: epochs between validations, the last included; 0 is never.
        validation_share: share of the scenes of the split "train", in each dataset, that are kept
            back to validate, at least one. The split "test" is left for the judgement.
        validation_pairs: so many of their pairs, drawn once; 0 is all.
        max_pairs: train with so many, drawn once; 0 is all.
        log_every: steps of a line of the log.
        checkpoint_minutes: between checkpoints within an epoch; one is written at its end anyway.
        workers: processes that read ahead.
    """

    input: InputConfig = dataclasses.field(default_factory=InputConfig)
    coding: DepthCoding = dataclasses.field(default_factory=DepthCoding)
    generator: GeneratorConfig = dataclasses.field(default_factory=GeneratorConfig)
    discriminator: DiscriminatorConfig = dataclasses.field(default_factory=DiscriminatorConfig)
    objective: ObjectiveConfig = dataclasses.field(default_factory=ObjectiveConfig)
    augmentation: AugmentationConfig = dataclasses.field(default_factory=AugmentationConfig)
    epochs: int = number(100, 1, 1_000_000)
    batch_size: int = number(1, 1, 4096)
    lr: float = number(2e-4, 0.0, 10.0)
    beta1: float = number(0.5, 0.0, 0.9999)
    beta2: float = number(0.999, 0.0, 0.999999)
    decay: str = choice("none", ("none", "linear"))
    ema: float = number(0.999, 0.0, 0.999999)
    seed: int = number(0, 0, 2**53)
    size: tuple[int, int] | None = None
    precision: str = choice("fp32", ("fp32", "bf16"))
    compile: bool = False
    validate_every: int = number(1, 0, 1_000_000)
    validation_share: float = number(0.1, 0.0, 0.9)
    validation_pairs: int = number(200, 0, 10_000_000)
    max_pairs: int = number(0, 0, 1_000_000_000)
    log_every: int = number(50, 1, 1_000_000)
    checkpoint_minutes: float = number(10.0, 0.0, 1e6)
    workers: int = number(4, 0, 256)

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.compile, bool):
            raise RecipeError(f"compile = {shown(self.compile)}: allowed are true and false")
        object.__setattr__(self, "size", _checked_size(self.size))
        channels = self.input.channels
        self._follow("generator", in_channels=channels, out_channels=1)
        self._follow("discriminator", in_channels=channels + 1)

    def _follow(self, part: str, **right: int) -> None:
        """Set the channels of a network; those given must be the default or right."""
        given = getattr(self, part)
        for name, value in right.items():
            if getattr(given, name) not in (value, getattr(type(given)(), name)):
                raise RecipeError(
                    f"{part} {name} = {getattr(given, name)}: allowed is {value}, as the input "
                    f"{self.input.kind!r} has {self.input.channels} channels and depth has 1"
                )
        object.__setattr__(self, part, dataclasses.replace(given, **right))

    @classmethod
    def from_table(cls, table: Any, where: str) -> "TrainConfig":
        """The configuration of a table, with a table in it for each part.

        Args:
            table: e.g. of a TOML file or of `as_table`; what it lacks has its default.
            where: where it is from, for the error.

        Raises:
            RecipeError: an unknown key, or a value that is not allowed.
        """
        if not isinstance(table, Mapping):
            raise RecipeError(f"{where} is {shown(table)}: allowed is a table of keys")
        parts = {
            name: part.from_table(table[name], f"{where} {name}")
            for name, part in _PARTS.items()
            if name in table
        }
        return super().from_table(dict(table) | parts, where)

    def as_table(self) -> dict:
        """The configuration as tables of JSON's and TOML's types: `from_table` makes it again."""
        table = dataclasses.asdict(self)
        return table | {"size": None if self.size is None else list(self.size)}

    def lr_at(self, done: float) -> float:
        """The learning rate after this share of all steps."""
        return self.lr * (1.0 if self.decay == "none" else min(1.0, 2 * (1 - done)))


def train_config(path: Path | None = None, options: Mapping[str, Any] | None = None) -> TrainConfig:
    """The configuration of a file, with single values set otherwise.

    Args:
        path: a TOML or JSON file with keys and tables as `TrainConfig` has them; None is none.
        options: {"input.kind": "rgb", "epochs": 5, ...}; None as a value leaves it as it was.

    Raises:
        RecipeError: no such file, or something in it that is not allowed.
    """
    table = {} if path is None else _read(Path(path))
    for name, value in (options or {}).items():
        if value is not None:
            *parts, key = name.split(".")
            at = table
            for part in parts:
                at = at.setdefault(part, {})
                if not isinstance(at, dict):
                    raise RecipeError(f"{path} {part} is {shown(at)}: allowed is a table of keys")
            at[key] = value
    return TrainConfig.from_table(table, "train" if path is None else str(path))


def first_difference(there: Mapping, asked: Mapping, at: str = "") -> tuple | None:
    """(key, value there, value asked for) of the first key with other values in two tables."""
    for name in (*there, *(name for name in asked if name not in there)):
        old, new = there.get(name), asked.get(name)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            found = first_difference(old, new, f"{at}{name}.")
            if found:
                return found
        elif old != new:
            return f"{at}{name}", old, new
    return None


def parse_size(text: str) -> tuple[int, int]:
    """(width, height) of "WIDTHxHEIGHT"; RecipeError where it is none."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if not found:
        raise RecipeError(f"size {text!r}: allowed is WIDTHxHEIGHT in pixels, e.g. 256x256")
    return _checked_size((int(found[1]), int(found[2])))


def _checked_size(size) -> tuple[int, int] | None:
    if size is None:
        return None
    sides = tuple(size) if isinstance(size, list | tuple) else ()
    whole = len(sides) == 2 and all(type(side) is int for side in sides)
    if not whole or not all(_LEAST_SIDE_PX <= side <= _MOST_SIDE_PX for side in sides):
        raise RecipeError(
            f"size = {shown(size)}: allowed are [width, height], whole numbers from "
            f"{_LEAST_SIDE_PX} to {_MOST_SIDE_PX}"
        )
    return sides


def _read(path: Path) -> dict:
    try:
        text = path.read_text(encoding="utf-8")
        table = parse_json(text) if path.suffix == ".json" else parse_toml(text)
    except FileNotFoundError:
        raise RecipeError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise RecipeError(f"{path} cannot be read: {error}") from None
    if not isinstance(table, dict):
        raise RecipeError(f"{path} is {type(table).__name__}: allowed is a table of keys")
    return table
