"""A contact sheet: what a dataset looks like, on one page."""

import itertools
from pathlib import Path

import cv2
import numpy as np

from synthdepth.dataset.manifest import read_index, read_manifest
from synthdepth.dataset.pair import ALWAYS, BY_MODALITY, Pair, decode_pair
from synthdepth.dataset.shard import Member, read_members
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.seeding import lane

_CAPTION_PX = 18
_HISTOGRAM_PX = 140
_BANDS_M = (0, 10, 25, 50, 100, 200)


def colour_depth(depth_m: np.ndarray, max_depth_m: float) -> np.ndarray:
    """Depth in false colour on a logarithmic scale, near is red, beyond the range is black.

    Args:
        depth_m: (H, W) [m].
        max_depth_m: where it saturates.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    near = 1.0
    place = np.log(np.maximum(depth_m, near) / near) / np.log(max_depth_m / near)
    grey = (255 * (1 - np.clip(place, 0, 1))).astype(np.uint8)
    colour = cv2.cvtColor(cv2.applyColorMap(grey, cv2.COLORMAP_TURBO), cv2.COLOR_BGR2RGB)
    colour[depth_m >= max_depth_m] = 0
    return colour


def random_pairs(folder: Path, count: int, seed: int) -> list[Pair]:
    """`count` different pairs of a dataset (or all, if it has fewer), read through the index."""
    return [_read_row(folder, row) for row in random_rows(folder, count, seed)]


def random_rows(folder: Path, count: int, seed: int) -> list[dict]:
    """The rows of the index that `random_pairs` reads, in the index's order."""
    index = read_index(folder)
    chosen = lane(seed, "preview").permutation(len(index))[:count]
    return index.take(sorted(chosen)).to_pylist()


def _read_row(folder: Path, row: dict) -> Pair:
    suffixes = {name.split(".")[0]: name for name in (*ALWAYS, *BY_MODALITY.values())}
    members = {
        suffix: Member(offset=row[f"{name}_offset"], size=row[f"{name}_size"])
        for name, suffix in suffixes.items()
        if f"{name}_offset" in row
    }
    shard = folder / row["shard"]
    try:
        return decode_pair(row["key"], read_members(shard, members))
    except (OSError, ValueError) as error:
        raise DatasetError(
            f"{shard}: pair {row['key']} cannot be read: {error}; synthdepth verify says where"
        ) from error


def colour_flow(flow: np.ndarray) -> np.ndarray:
    """Flow (H, W, 2) [px], direction as hue, length as saturation: (H, W, 3) uint8 RGB."""
    length, angle = cv2.cartToPolar(flow[..., 0], flow[..., 1])
    share = np.clip(length / max(float(np.percentile(length, 99)), 1e-6), 0, 1)
    hue, saturation = angle * (90 / np.pi), 255 * share
    hsv = np.stack([hue, saturation, np.full_like(hue, 255)], axis=-1).astype(np.uint8)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


# A colour a label, told apart by neighbours and by those who see no red or green.
_LABEL_COLOURS = np.array(
    [
        [0, 0, 0], [150, 120, 80], [90, 90, 100], [200, 190, 210], [190, 110, 90], [130, 30, 50],
        [60, 150, 60], [110, 70, 30], [40, 110, 220], [250, 210, 40], [255, 60, 200],
        [250, 130, 30],
        [0, 240, 240], [150, 90, 230], [255, 255, 160], [0, 120, 110], [160, 180, 150],
    ],
    np.uint8,
)  # fmt: skip


def colour_labels(seg: np.ndarray) -> np.ndarray:
    """Labels (H, W) uint8 in a colour each, (H, W, 3) uint8 RGB; sky is black, unknown white."""
    known = np.minimum(seg, len(_LABEL_COLOURS))
    return np.concatenate([_LABEL_COLOURS, [[255, 255, 255]]]).astype(np.uint8)[known]


def contact_sheet(pairs: list[Pair], columns: int = 4, tile_px: int = 200) -> np.ndarray:
    """One picture of many pairs: frames, depth and what else each has, and a depth histogram.

    Args:
        pairs: at least one.
        columns: pairs side by side.
        tile_px: width of one picture on the sheet.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    cells = [_cell(pair, tile_px) for pair in pairs]
    height, width = cells[0].shape[:2]
    rows = -(-len(cells) // columns)
    columns = min(columns, len(cells))
    sheet = np.full((rows * height, columns * width, 3), 255, np.uint8)
    for number, cell in enumerate(cells):
        y, x = divmod(number, columns)
        sheet[y * height : (y + 1) * height, x * width : (x + 1) * width] = cell
    return np.concatenate([sheet, _histogram(pairs, sheet.shape[1])])


def _cell(pair: Pair, tile_px: int) -> np.ndarray:
    height = round(tile_px * pair.camera.height / pair.camera.width)
    depth = colour_depth(pair.depth_m, pair.meta["max_depth_m"])
    tiles = [
        cv2.resize(image, (tile_px, height), interpolation=cv2.INTER_AREA)
        for image in (pair.rgb, pair.prev, depth, *_modality_tiles(pair))
    ]
    cell = np.full((height + _CAPTION_PX + 4, len(tiles) * tile_px + 8, 3), 255, np.uint8)
    cell[_CAPTION_PX : _CAPTION_PX + height, 4:-4] = np.concatenate(tiles, axis=1)
    text = (
        f"{pair.key}  {pair.meta['condition']}  {pair.meta['speed_mps']:.1f} m/s  "
        f"{pair.meta['altitude_m']:.1f} m up  nearest {pair.meta['nearest_depth_m']:.1f} m"
    )
    _write(cell, text, (6, _CAPTION_PX - 5))
    return cell


def _modality_tiles(pair: Pair) -> list[np.ndarray]:
    tiles = []
    if pair.flow is not None:
        tiles.append(colour_flow(pair.flow))
    if pair.seg is not None:
        tiles.append(colour_labels(pair.seg))
    if pair.normal is not None:
        tiles.append((127.5 * (1 - pair.normal)).astype(np.uint8))
    return tiles


def _histogram(pairs: list[Pair], width: int) -> np.ndarray:
    """Share of the pixels a depth band, over all pairs."""
    depth = np.concatenate([pair.depth_m.ravel() for pair in pairs])
    top = pairs[0].meta["max_depth_m"]
    edges = [edge for edge in _BANDS_M if edge < top] + [top]
    shares = [
        float(np.mean((depth >= low) & (depth < high))) for low, high in itertools.pairwise(edges)
    ]
    names = [f"{a:g}-{b:g} m" for a, b in itertools.pairwise(edges)]
    shares.append(float(np.mean(depth >= top)))
    names.append(f"{top:g} m and beyond")
    canvas = np.full((_HISTOGRAM_PX, width, 3), 255, np.uint8)
    step = width // len(shares)
    for number, (name, share) in enumerate(zip(names, shares, strict=True)):
        x, bar = number * step + 10, int(share * (_HISTOGRAM_PX - 50))
        corner = (x + step - 30, _HISTOGRAM_PX - 26)
        cv2.rectangle(canvas, (x, _HISTOGRAM_PX - 26 - bar), corner, (60, 110, 160), -1)
        _write(canvas, f"{name}: {100 * share:.1f} %", (x, _HISTOGRAM_PX - 8))
    return canvas


def _write(canvas: np.ndarray, text: str, at: tuple[int, int]) -> None:
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.36, (0, 0, 0), 1, cv2.LINE_AA)


def preview(folder: Path, out: Path, *, count: int = 24, seed: int = 0) -> int:
    """Write the contact sheet of a dataset; returns how many pairs are on it.

    Raises:
        SynthdepthError: no finished dataset there, or the picture cannot be written.
    """
    if not 1 <= count <= 400:
        raise SynthdepthError(f"--count {count}: allowed is a whole number from 1 to 400")
    if out.suffix.lower() != ".png":
        raise SynthdepthError(f"--out {out}: allowed is a file name that ends in .png or .html")
    read_manifest(folder)
    pairs = random_pairs(Path(folder), count, seed)
    sheet = contact_sheet(pairs, columns=min(4, max(1, len(pairs) // 4)))
    if not cv2.imwrite(str(out), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR)):
        raise SynthdepthError(f"--out {out} cannot be written")
    return len(pairs)
