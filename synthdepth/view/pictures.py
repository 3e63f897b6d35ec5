"""The pictures of the page: pairs as small tiles."""

from collections.abc import Mapping, Sequence

import numpy as np

from synthdepth.charts.pictures import Tile, tile
from synthdepth.dataset.pair import Pair
from synthdepth.dataset.preview import colour_depth, colour_flow, colour_labels

_STRIP_PX = 160


def tiles(pair: Pair) -> list[Tile]:
    """What a pair holds: two frames and depth, and flow, labels and normals where they are."""
    meta = pair.meta
    near, middle = meta["nearest_depth_m"], meta["median_depth_m"]
    depth = f"depth from {near:.1f} m, half of it nearer than {middle:.0f} m"
    found = [
        tile("frame t", "frame t", pair.rgb),
        tile("frame t-1", "the frame before", pair.prev),
        tile("depth", depth, colour_depth(pair.depth_m, meta["max_depth_m"])),
    ]
    if pair.flow is not None:
        length = float(np.median(np.linalg.norm(pair.flow, axis=-1)))
        says = f"optical flow, {length:.1f} px at the median"
        found.append(tile("flow", says, colour_flow(pair.flow)))
    if pair.seg is not None:
        classes = f"labels of {len(np.unique(pair.seg))} classes"
        found.append(tile("labels", classes, colour_labels(pair.seg), flat=True))
    if pair.normal is not None:
        found.append(tile("normals", "surface normals", colour_normal(pair.normal)))
    return found


def strip(pairs: Sequence[Pair], most: int) -> list[Tile]:
    """Frames over their depth, of at most `most` pairs, evenly out of the list."""
    chosen = [
        pairs[i] for i in np.linspace(0, len(pairs) - 1, min(most, len(pairs))).round().astype(int)
    ]
    found = []
    for pair in chosen:
        depth = colour_depth(pair.depth_m, pair.meta["max_depth_m"])
        both = np.concatenate([pair.rgb, depth])
        says = f"a frame in {pair.meta['condition']} over its depth"
        found.append(tile("", says, both, most_px=_STRIP_PX))
    return found


def colour_normal(normal: np.ndarray) -> np.ndarray:
    """Normals (H, W, 3), camera axes, as (H, W, 3) uint8: red to the left, green up, blue to us."""
    return (127.5 * (1 - normal)).astype(np.uint8)


def flow_wheel() -> Tile:
    """The colours of `colour_flow`: a pixel's colour here is that of a flow to this place."""
    side = np.linspace(-1, 1, 96, dtype=np.float32)
    wheel = colour_flow(np.stack(np.meshgrid(side, side), axis=-1))
    return tile("", "colours of the directions of flow, paler where it is short", wheel)


def normal_colours() -> dict[str, str]:
    """The CSS colours of `colour_normal` by where a surface faces."""
    sides = {
        "left": (-1, 0, 0), "right": (1, 0, 0), "up": (0, -1, 0), "down": (0, 1, 0),
        "the camera": (0, 0, -1), "sky": (0, 0, 0),
    }  # fmt: skip
    colours = colour_normal(np.array([list(sides.values())]))[0]
    return {side: _css(colour) for side, colour in zip(sides, colours, strict=True)}


def label_colours(labels: Mapping[str, int]) -> dict[str, str]:
    """The CSS colour of each class, {name: colour}, in the order of their ids."""
    names = sorted(labels, key=lambda name: labels[name])
    colours = colour_labels(np.array([[labels[name] for name in names]], np.uint8))[0]
    return {name: _css(colour) for name, colour in zip(names, colours, strict=True)}


def _css(colour: np.ndarray) -> str:
    return f"rgb({' '.join(str(int(part)) for part in colour)})"
