"""Weights on disk: safetensors with the configuration as JSON in the header. Nothing is pickled.

`last.safetensors` holds a training whole: the next run goes on as if nothing had happened.
`best.safetensors` holds a generator alone. Both are replaced whole or not at all.
"""

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path

import safetensors
import safetensors.torch
import torch

from synthdepth.config import parse_json, shown
from synthdepth.dataset.shard import write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.generator import UNetGenerator
from synthdepth.pix2pix.state import Progress, State

LAST, BEST = "last.safetensors", "best.safetensors"
FORMAT = 1
_HEADER = "synthdepth"
_MOMENTS = ("exp_avg", "exp_avg_sq")


def save_state(path: Path, state: State, facts: Mapping) -> None:
    """Write a training whole.

    Args:
        path: the file.
        state: of the training.
        facts: what else the header says: `config`, a table, among it.

    Raises:
        DatasetError: the disk is full or the folder cannot be written.
    """
    tensors = {"window": state.window}
    for name, network, adam in state.networks():
        tensors |= {f"{name}.{key}": value for key, value in network.state_dict().items()}
        for key, parameter in network.named_parameters() if adam else ():
            for what, value in adam.state.get(parameter, {}).items():
                tensors[f"{name}_adam.{key}.{what}"] = value
    _write(path, tensors, {**facts, "progress": dataclasses.asdict(state.progress)})


def restore_state(path: Path, state: State) -> None:
    """Set a state to what a file holds, in place.

    Raises:
        SynthdepthError: not a checkpoint of such a training.
    """
    facts = read_facts(path)
    if "progress" not in facts:
        raise SynthdepthError(f"{path} is a model: allowed is a checkpoint of a training")
    tensors = _read(path)
    _copy(path, {"window": state.window}, tensors)
    for name, network, adam in state.networks():
        _copy(path, network.state_dict(), tensors, f"{name}.")
        first = next(network.named_parameters())[0]
        if adam is None or f"{name}_adam.{first}.step" not in tensors:
            continue
        for key, parameter in network.named_parameters():
            # Like the weight in its memory layout, which Adam takes for granted.
            moments = {what: torch.empty_like(parameter) for what in _MOMENTS}
            moments["step"] = torch.zeros((), device=parameter.device)
            _copy(path, moments, tensors, f"{name}_adam.{key}.")
            adam.state[parameter] = moments
    state.progress = _progress(path, facts["progress"])


def save_model(path: Path, generator: UNetGenerator, facts: Mapping) -> None:
    """Write a generator alone; arguments and errors as `save_state`."""
    _write(path, {f"generator.{k}": v for k, v in generator.state_dict().items()}, facts)


def load_generator(path: Path | str) -> tuple[UNetGenerator, TrainConfig]:
    """A trained generator, ready for prediction on the CPU, and how it was trained.

    Args:
        path: a model or checkpoint, or the folder of a training, whose best model is taken, or the
            last where none was validated.

    Raises:
        SynthdepthError: no such file, or one that `train` did not write.
    """
    path = model_file(path)
    config = TrainConfig.from_table(read_facts(path).get("config"), f"{path}: config")
    with safetensors.safe_open(path, "pt") as file:
        names = set(file.keys())
        prefix = "average." if any(n.startswith("average.") for n in names) else "generator."
        ours = [name for name in names if name.startswith(prefix)]
        weights = {name.removeprefix(prefix): file.get_tensor(name) for name in ours}
    with torch.device("meta"):
        generator = UNetGenerator(config.generator)
    there = {name: _kind(value) for name, value in weights.items()}
    wanted = {name: _kind(value) for name, value in generator.state_dict().items()}
    for name in sorted(there.keys() | wanted.keys()):
        if there.get(name) != wanted.get(name):
            raise SynthdepthError(
                f"{path}: {name} has {there.get(name, 'nothing')}, allowed is "
                f"{wanted.get(name, 'nothing')}: it does not agree with its own configuration"
            )
    generator.load_state_dict(weights, assign=True)
    return generator.eval().requires_grad_(False), config


def model_file(path: Path | str) -> Path:
    """The file of a model, which may be given by its folder."""
    path = Path(path)
    if not path.is_dir():
        return path
    for name in (BEST, LAST):
        if (path / name).is_file():
            return path / name
    raise SynthdepthError(f"{path} holds no model: there is neither {BEST} nor {LAST}")


def read_facts(path: Path) -> dict:
    """What the header of a file says.

    Raises:
        SynthdepthError: no such file, or one that `train` did not write.
    """
    try:
        with safetensors.safe_open(path, "pt") as file:
            facts = parse_json((file.metadata() or {})[_HEADER])
    except FileNotFoundError:
        raise SynthdepthError(f"{path}: there is no such file") from None
    except (OSError, KeyError, ValueError, safetensors.SafetensorError) as error:
        reason = "no header" if isinstance(error, KeyError) else str(error).splitlines()[0]
        raise SynthdepthError(
            f"{path}: allowed is a .safetensors file that `synthdepth train` wrote ({reason})"
        ) from None
    there = facts.get("format") if isinstance(facts, dict) else None
    if there != FORMAT:
        raise SynthdepthError(f"{path} has format {shown(there)}: allowed is {FORMAT}")
    return facts


def _kind(tensor: torch.Tensor) -> str:
    """Shape and type of a tensor, in words."""
    return f"shape {tuple(tensor.shape)} of {str(tensor.dtype).removeprefix('torch.')}"


def _progress(path: Path, table) -> Progress:
    """Where a training stood, as its checkpoint says."""
    counts = {field.name for field in dataclasses.fields(Progress)} - {"best"}
    right = isinstance(table, dict) and table.keys() == counts | {"best"}
    if right:
        right = all(type(table[n]) in (int, float) and table[n] >= 0 for n in counts)
        right &= isinstance(table["best"], dict | None)
    if not right:
        raise SynthdepthError(f"{path} has the progress {shown(table)}, which no training has")
    return Progress(**table)


def _write(path: Path, tensors: Mapping[str, torch.Tensor], facts: Mapping) -> None:
    # A file knows no memory layout but the plain one.
    plain = {name: value.detach().cpu().contiguous() for name, value in tensors.items()}
    header = {_HEADER: json.dumps({"format": FORMAT, **facts})}
    write_whole(path, safetensors.torch.save(plain, header))


def _read(path: Path) -> dict[str, torch.Tensor]:
    try:
        return safetensors.torch.load_file(path)
    except (OSError, safetensors.SafetensorError) as error:
        raise SynthdepthError(f"{path} cannot be read: {error}") from None


@torch.no_grad()
def _copy(path: Path, into: Mapping, tensors: Mapping, prefix: str = "") -> None:
    """Fills tensors by their names, in place."""
    for name, value in into.items():
        found = tensors.get(prefix + name)
        if found is None or found.shape != value.shape:
            there = "nothing" if found is None else f"shape {tuple(found.shape)}"
            raise SynthdepthError(
                f"{path} has {there} as {prefix}{name}: allowed is shape {tuple(value.shape)}"
            )
        value.copy_(found)
