"""Weights of junyanz/pytorch-CycleGAN-and-pix2pix, read and written.

Its U-Net is a nest of blocks, each a `Sequential` named `model`, and the names of its weights count
the places in it. The outermost block holds convolution 0, inner block 1, ReLU 2, convolution 3; the
others LeakyReLU 0, convolution 1, norm 2, inner block 3, ReLU 4, convolution 5, norm 6; the
innermost LeakyReLU 0, convolution 1, ReLU 2, convolution 3, norm 4. Its PatchGAN is one
`Sequential` of convolutions, norms and LeakyReLUs. Files are read without running any code in them.
"""

import pickle
from collections.abc import Mapping
from pathlib import Path

import safetensors
import safetensors.torch
import torch

from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.discriminator import DiscriminatorConfig, PatchDiscriminator
from synthdepth.pix2pix.generator import GeneratorConfig, UNetGenerator

Weights = Mapping[str, torch.Tensor]


def load_original_generator(source: str | Path | Weights) -> UNetGenerator:
    """A U-Net with the original's weights; channels, depth and norm come from their
    shapes. Dropout leaves no trace in a file: it is on, as by default in the original.

    Args:
        source: `*_net_G.pth` or a safetensors file, or its tensors by name.

    Raises:
        SynthdepthError: no such file, not weights, or not of this network.
    """
    weights, where = _read(source)
    first = _shape(weights, "model.model.0.weight", where)
    depth = 1
    while f"{_block(depth)}1.weight" in weights:
        depth += 1
    last = _shape(weights, "model.model.3.weight", where)
    shape = {"in_channels": first[1], "out_channels": last[1], "ngf": first[0], "depth": depth}
    norm = "instance" if "model.model.0.bias" in weights else "batch"
    network = _unfilled(UNetGenerator, GeneratorConfig, shape | {"norm": norm}, where)
    return _fill(network, generator_names(network.config), weights, where)


def load_original_discriminator(source: str | Path | Weights) -> PatchDiscriminator:
    """A PatchGAN with the original's weights (`basic` or `n_layers`).

    Args:
        source: `*_net_D.pth` or a safetensors file, or its tensors by name.

    Raises:
        SynthdepthError: no such file, not weights, or not of this network.
    """
    weights, where = _read(source)
    first = _shape(weights, "model.0.weight", where)
    norm = "instance" if "model.2.bias" in weights else "batch"
    layers = 0
    while f"model.{3 * layers + 5}.weight" in weights:
        layers += 1
    shape = {"in_channels": first[1], "ndf": first[0], "layers": layers, "norm": norm}
    network = _unfilled(PatchDiscriminator, DiscriminatorConfig, shape, where)
    return _fill(network, discriminator_names(network.config), weights, where)


def original_weights(network: UNetGenerator | PatchDiscriminator) -> dict[str, torch.Tensor]:
    """The weights of a network by the original's names, for its `load_state_dict`.

    Raises:
        SynthdepthError: the original has no such network (group norm, resize upsampling).
    """
    generator = isinstance(network, UNetGenerator)
    if network.config.norm == "group" or (generator and network.config.upsample != "transposed"):
        raise SynthdepthError(
            "the original Pix2Pix has no such network: allowed are norm batch or instance, and "
            "upsample transposed"
        )
    names = (generator_names if generator else discriminator_names)(network.config)
    return {theirs: network.state_dict()[ours] for ours, theirs in names.items()}


def generator_names(config: GeneratorConfig) -> dict[str, str]:
    """The original's name of each entry of our U-Net's state dict."""
    names, innermost = {}, config.depth - 1
    bias = config.norm == "instance"
    for k in range(config.depth):
        block = _block(k)
        decoder = f"decoders.{innermost - k}" if k > 0 else "head"
        # Places of the down convolution, its norm, the up convolution and its norm in the block.
        down, down_norm, up, up_norm = 1, 2, 5, 6
        if k == 0:
            down, down_norm, up, up_norm = 0, None, 3, None
        elif k == innermost:
            down, down_norm, up, up_norm = 1, None, 3, 4
        names |= _convolution(f"encoders.{k}.conv", f"{block}{down}", bias)
        names |= _convolution(f"{decoder}.conv", f"{block}{up}", bias or k == 0)
        if config.norm == "batch" and down_norm:
            names |= _batch_norm(f"encoders.{k}.norm", f"{block}{down_norm}")
        if config.norm == "batch" and up_norm:
            names |= _batch_norm(f"{decoder}.norm", f"{block}{up_norm}")
    return names


def discriminator_names(config: DiscriminatorConfig) -> dict[str, str]:
    """The original's name of each entry of our PatchGAN's state dict."""
    names = _convolution("blocks.0.conv", "model.0", True)
    for k in range(1, config.layers + 1):
        names |= _convolution(f"blocks.{k}.conv", f"model.{3 * k - 1}", config.norm == "instance")
        if config.norm == "batch":
            names |= _batch_norm(f"blocks.{k}.norm", f"model.{3 * k}")
    return names | _convolution("head", f"model.{3 * config.layers + 2}", True)


def _block(k: int) -> str:
    """Prefix of the k-th block from outside."""
    return "model.model." + ("1.model." if k > 0 else "") + "3.model." * (k - 1)


def _convolution(ours: str, theirs: str, bias: bool) -> dict[str, str]:
    return {f"{ours}.{part}": f"{theirs}.{part}" for part in ("weight", "bias")[: 1 + bias]}


def _batch_norm(ours: str, theirs: str) -> dict[str, str]:
    parts = ("weight", "bias", "running_mean", "running_var", "num_batches_tracked")
    return {f"{ours}.{part}": f"{theirs}.{part}" for part in parts}


def _read(source: str | Path | Weights) -> tuple[dict[str, torch.Tensor], str]:
    if isinstance(source, Mapping):
        weights, where = source, "state dict"
    else:
        path, where = Path(source), str(source)
        try:
            if path.suffix == ".safetensors":
                weights = safetensors.torch.load_file(path)
            else:
                weights = torch.load(path, map_location="cpu", weights_only=True)
        except FileNotFoundError:
            raise SynthdepthError(f"{where}: there is no such file") from None
        except (
            OSError,
            EOFError,
            RuntimeError,
            ValueError,
            pickle.UnpicklingError,
            safetensors.SafetensorError,
        ) as error:
            raise SynthdepthError(
                f"{where}: not readable as weights; allowed are tensors by name, as torch.save "
                f"writes a state dict, or safetensors ({_first_line(error)})"
            ) from None
    if not isinstance(weights, Mapping) or not all(
        isinstance(name, str) and isinstance(value, torch.Tensor) for name, value in weights.items()
    ):
        raise SynthdepthError(f"{where} holds more than tensors by name: allowed is a state dict")
    return dict(weights), where


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0].split(". ")[0]


def _shape(weights: Weights, name: str, where: str) -> torch.Size:
    shape = weights[name].shape if name in weights else ()
    if len(shape) != 4:
        raise SynthdepthError(
            f"{where} has no {name} of four axes: allowed are weights of the original's unet_* "
            "generator or basic / n_layers discriminator"
        )
    return shape


def _unfilled(network, config, values: dict, where: str) -> torch.nn.Module:
    """The network without memory for its weights: they come from the file."""
    try:
        checked = config(**values)
    except SynthdepthError as error:
        raise SynthdepthError(f"{where}: {error}") from None
    with torch.device("meta"):
        return network(checked)


def _fill(network, names: dict[str, str], weights: Weights, where: str) -> torch.nn.Module:
    ours = network.state_dict()
    state = {}
    for name, theirs in names.items():
        if theirs in weights:
            # A copy: training must not change what the caller holds.
            state[name] = weights[theirs].detach().to("cpu", ours[name].dtype, copy=True)
        elif theirs.endswith("num_batches_tracked"):  # PyTorch before 0.4.1 wrote none.
            state[name] = torch.zeros((), dtype=torch.long)
        else:
            raise SynthdepthError(f"{where} lacks {theirs}: {_structure(network)}")
        if state[name].shape != ours[name].shape:
            raise SynthdepthError(
                f"{where}: {theirs} has shape {tuple(state[name].shape)}, allowed is "
                f"{tuple(ours[name].shape)}: {_structure(network)}"
            )
    more = sorted(set(weights) - set(names.values()))
    if more:
        raise SynthdepthError(f"{where} has {more[0]} too much: {_structure(network)}")
    network.load_state_dict(state, assign=True)
    return network


def _structure(network) -> str:
    return f"it began like a {type(network).__name__} of {network.config}"
