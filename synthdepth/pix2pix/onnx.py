"""A trained generator as ONNX, for machines without PyTorch.

The graph is written operator by operator, weights under their own names, in a version of the
standard that TensorRT, OpenVINO and onnxruntime have all known for years.
"""

import json
import math
from pathlib import Path

import numpy as np
from torch import nn

import synthdepth
from synthdepth.dataset.shard import write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.checkpoint import load_generator
from synthdepth.pix2pix.generator import UNetGenerator, padding_of
from synthdepth.pix2pix.inference import for_inference
from synthdepth.pix2pix.target import DepthCoding

INPUT, OUTPUT = "input", "depth_m"
_OPSET, _IR_VERSION = 17, 8


def export_onnx(model: Path | str, out: Path, *, size: tuple[int, int] | None = None) -> int:
    """Write a model as one ONNX file.

    Its input `input` is (B, C, height, width) float32 in [-1, 1], what `inputs.MakeInput` makes;
    its output `depth_m` is (B, 1, height, width) float32 [m]. B may be any. The file's metadata
    say, as JSON, how the input is made (`input`), which range depth has (`coding`), and the `size`.

    Args:
        model: a model, a checkpoint, or the folder of a training.
        out: the file, `.onnx`.
        size: (width, height) of the pictures [px]; by default what the model was trained at, or
            256x256 where it took the data's.

    Returns:
        Size of the file in bytes.

    Raises:
        SynthdepthError: no such model, another suffix, onnx is not installed, or the file cannot be
            written.
    """
    out = Path(out)
    if out.suffix != ".onnx":
        raise SynthdepthError(f"{out}: allowed is a file name that ends in .onnx")
    try:
        import onnx
    except ModuleNotFoundError:
        raise SynthdepthError(
            "ONNX files need onnx: install it with pip install 'synthdepth[train]'"
        ) from None
    generator, config = load_generator(model)
    width, height = size or config.size or (256, 256)
    graph = _Graph()
    code = _unet(graph, for_inference(generator), width, height)
    _decoded(graph, code, config.coding)
    sides = [height, width]
    shapes = {INPUT: ["batch", config.input.channels, *sides], OUTPUT: ["batch", 1, *sides]}
    ends = [
        onnx.helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, shape)
        for name, shape in shapes.items()
    ]
    written = onnx.helper.make_model(
        onnx.helper.make_graph(graph.nodes, "depth", ends[:1], ends[1:], graph.weights),
        producer_name="synthdepth",
        producer_version=synthdepth.__version__,
        opset_imports=[onnx.helper.make_opsetid("", _OPSET)],
        ir_version=_IR_VERSION,
    )
    table = config.as_table()
    facts = {"input": table["input"], "coding": table["coding"], "size": [width, height]}
    onnx.helper.set_model_props(written, {name: json.dumps(fact) for name, fact in facts.items()})
    onnx.checker.check_model(written, full_check=True)
    data = written.SerializeToString()
    write_whole(out, data)
    return len(data)


class _Graph:
    """Operators and weights as they come."""

    def __init__(self):
        self.nodes, self.weights = [], []

    def add(self, kind: str, *inputs: str, output: str | None = None, **attributes) -> str:
        """Append an operator; returns the name of its output."""
        from onnx.helper import make_node

        output = output or f"{kind}_{len(self.nodes)}"
        self.nodes.append(make_node(kind, list(inputs), [output], name=output, **attributes))
        return output

    def constant(self, values, name: str | None = None, dtype=np.float32) -> str:
        """Append a constant; returns its name."""
        from onnx.numpy_helper import from_array

        name = name or f"constant_{len(self.weights)}"
        self.weights.append(from_array(np.ascontiguousarray(values, dtype), name))
        return name


def _unet(graph: _Graph, generator: UNetGenerator, width: int, height: int) -> str:
    """`UNetGenerator.forward` of a picture of a fixed size."""
    top, bottom = padding_of(height, 2**generator.config.depth)
    left, right = padding_of(width, 2**generator.config.depth)
    x = INPUT
    if top or bottom or left or right:
        fits = bottom < height and right < width
        pads = graph.constant([0, 0, top, left, 0, 0, bottom, right], dtype=np.int64)
        x = graph.add("Pad", x, pads, mode="reflect" if fits else "edge")
    skips = []
    for k, encoder in enumerate(generator.encoders):
        x = graph.add("LeakyRelu", x, alpha=0.2) if skips else x
        x = _block(graph, x, encoder, f"encoders.{k}")
        skips.append(x)
    x = graph.add("Relu", skips.pop())
    for k, decoder in enumerate(generator.decoders):
        skip = graph.add("Relu", skips.pop())
        x = graph.add("Concat", skip, _block(graph, x, decoder, f"decoders.{k}"), axis=1)
    x = graph.add("Tanh", _block(graph, x, generator.head, "head"))
    starts = graph.constant([top, left], dtype=np.int64)
    ends = graph.constant([top + height, left + width], dtype=np.int64)
    return graph.add("Slice", x, starts, ends, graph.constant([2, 3], dtype=np.int64))


def _block(graph: _Graph, x: str, block: nn.Sequential, at: str) -> str:
    for name, layer in block.named_children():
        weights = {
            key: graph.constant(value.numpy(), f"{at}.{name}.{key}")
            for key, value in layer.state_dict().items()
        }
        if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d):
            kind = "ConvTranspose" if isinstance(layer, nn.ConvTranspose2d) else "Conv"
            sides = {"kernel_shape": layer.kernel_size, "strides": layer.stride}
            x = graph.add(kind, x, *weights.values(), **sides, pads=layer.padding * 2)
        elif isinstance(layer, nn.InstanceNorm2d):
            x = _instance_norm(graph, x, layer.num_features, layer.eps)
        elif isinstance(layer, nn.GroupNorm):
            x = _group_norm(graph, x, layer, **weights)
        elif isinstance(layer, nn.ReLU):
            x = graph.add("Relu", x)
        elif isinstance(layer, nn.Upsample):
            scales = graph.constant([1, 1, layer.scale_factor, layer.scale_factor])
            x = graph.add("Resize", x, "", scales, mode="nearest")
        elif not isinstance(layer, nn.Dropout):  # noise is for training alone
            raise TypeError(f"{at}.{name} is a {type(layer).__name__}, which has no operator here")
    return x


def _instance_norm(graph: _Graph, x: str, channels: int, eps: float) -> str:
    one, zero = graph.constant(np.ones(channels)), graph.constant(np.zeros(channels))
    return graph.add("InstanceNormalization", x, one, zero, epsilon=eps)


def _group_norm(graph: _Graph, x: str, layer: nn.GroupNorm, weight: str, bias: str) -> str:
    """Instance norm with each group as one channel, then scale and shift."""
    shape = graph.add("Shape", x)
    groups = graph.constant([0, layer.num_groups, -1], dtype=np.int64)
    y = _instance_norm(graph, graph.add("Reshape", x, groups), layer.num_groups, layer.eps)
    y = graph.add("Reshape", y, shape)
    axes = graph.constant([1, 2], dtype=np.int64)
    y = graph.add("Mul", y, graph.add("Unsqueeze", weight, axes))
    return graph.add("Add", y, graph.add("Unsqueeze", bias, axes))


def _decoded(graph: _Graph, code: str, coding: DepthCoding) -> str:
    """`DepthCoding.decode`."""
    far, near = graph.constant(coding.max_depth_m), graph.constant(coding.min_depth_m)
    if coding.kind == "linear":
        half = graph.constant(coding.max_depth_m / 2)
        depth_m = graph.add("Mul", graph.add("Add", code, graph.constant(1)), half)
    else:
        half = graph.constant(math.log(coding.max_depth_m / coding.min_depth_m) / 2)
        power = graph.add("Mul", graph.add("Sub", code, graph.constant(1)), half)
        depth_m = graph.add("Mul", graph.add("Exp", power), far)
    return graph.add("Clip", depth_m, near, far, output=OUTPUT)
