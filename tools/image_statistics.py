"""Natural-image statistics of datasets, beside those of real frames: do the pictures look real?

    python tools/image_statistics.py data/city data/coastline --real FRAMES --json statistics.json

Of each dataset `--frames` frames are taken, spread evenly over its pairs (rgb.png). `--real` is a
folder with real frames: every 8-bit colour PNG or JPEG below it counts, in groups by the first word
of its first folder (kitti_object/... and kitti_depth/... make "kitti", airsim/... makes "airsim").

A side longer than 256 px is first brought to 256 px by area averaging, so that a larger frame is
squeezed to 256x256 as a trainer squeezes it. A KITTI frame (1242 px over 81 degrees) then has the
sampling across that a rendered one has (256 px over 90 degrees), which the horizontal gradient
needs, and about twice as fine a sampling down. Smaller frames stay as they are.

Of each frame, with luminance Y = 0.299 R + 0.587 G + 0.114 B of the sRGB values in 0..1:

* slope: of the power spectrum. Y less its mean under a Hann window; power averaged in 8 rings
  whose radii grow by a constant factor from 0.03 to 0.3 cycles/px; line through log power over log
  frequency.
* kurtosis: of Y[x + 1] - Y[x]: fourth central moment over squared variance, 3 for a Gaussian.
* flat_share: share of the pixels with |Laplacian of Y| < 1/255, from the four neighbours.
* saturation: mean of (max - min) / max over R, G, B; black counts as 0.
* entropy_bits: of the histogram of Y in 256 levels.

The medians over the frames are held against the ranges of real photos in `REAL`; the definitions
above were chosen so that KITTI photos and AirSim captures fall into them as well as one definition
allows (a single frame may still lie outside: a street of white walls is flat and grey).
"""

import argparse
import json
import math
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np

from synthdepth.dataset.manifest import read_index, read_manifest
from synthdepth.dataset.pair import decode_png
from synthdepth.dataset.shard import Member, read_members, write_whole
from synthdepth.errors import DatasetError, SynthdepthError

SIDE_PX = 256
BAND_CYCLES_PER_PX = (0.03, 0.3)
RINGS = 8

# Where the median of real photos lies.
REAL = {
    "slope": (-2.9, -2.4),
    "kurtosis": (8.0, 23.0),
    "flat_share": (0.12, 0.25),
    "saturation": (0.19, 0.29),
    "entropy_bits": (6.9, 7.6),
}


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Rec. 601 luminance of display values: (H, W) float64 in 0..1 of (H, W, 3) uint8 sRGB."""
    return rgb @ np.array([0.299, 0.587, 0.114]) / 255


def spectrum_slope(grey: np.ndarray) -> float:
    """Exponent of power over spatial frequency, about -2.5 for photos; NaN if nothing varies.

    Args:
        grey: (H, W) luminance, 0..1.
    """
    height, width = grey.shape
    # Hann windows that are zero just outside the frame, so that no pixel is lost.
    window = np.outer(np.hanning(height + 2)[1:-1], np.hanning(width + 2)[1:-1])
    varying = grey - (grey * window).sum() / window.sum()
    power = np.abs(np.fft.fft2(varying * window)).ravel() ** 2
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None]).ravel()
    edges = np.geomspace(*BAND_CYCLES_PER_PX, RINGS + 1)
    ring = np.digitize(frequency, edges)
    rings = [ring == number for number in range(1, RINGS + 1) if (ring == number).any()]
    mean_power = np.array([power[r].mean() for r in rings])
    # Below this there is only the rounding of a constant frame.
    if len(rings) < 2 or mean_power.min() < 1e-18 * grey.size:
        return math.nan
    log_frequency = [np.log(frequency[r]).mean() for r in rings]
    return float(np.polyfit(log_frequency, np.log(mean_power), 1)[0])


def gradient_kurtosis(grey: np.ndarray) -> float:
    """Kurtosis of the horizontal luminance steps of (H, W); NaN if there are none."""
    step = np.diff(grey, axis=1)
    step = step - step.mean()
    variance = np.mean(step**2)
    return float(np.mean(step**4) / variance**2) if variance > 1e-18 else math.nan


def flat_share(grey: np.ndarray) -> float:
    """Share 0..1 of the inner pixels of (H, W) luminance whose |Laplacian| is under 1/255."""
    inner = grey[1:-1, 1:-1]
    around = grey[:-2, 1:-1] + grey[2:, 1:-1] + grey[1:-1, :-2] + grey[1:-1, 2:]
    # A step of exactly 1/255 is not flat, however it was rounded.
    return float(np.mean(np.abs(around - 4 * inner) < 1 / 255 - 1e-9))


def mean_saturation(rgb: np.ndarray) -> float:
    """Mean HSV saturation, 0..1, of (H, W, 3) uint8."""
    top = rgb.max(axis=-1).astype(np.float64)
    return float(np.mean((top - rgb.min(axis=-1)) / np.maximum(top, 1)))


def entropy_bits(grey: np.ndarray) -> float:
    """Entropy [bit] of the histogram of (H, W) luminance in 256 levels."""
    level = np.clip(np.round(grey * 255), 0, 255).astype(int)
    share = np.bincount(level.ravel(), minlength=256) / level.size
    share = share[share > 0]
    return float(-np.sum(share * np.log2(share)))


def comparable(rgb: np.ndarray) -> np.ndarray:
    """The frame with every side longer than 256 px brought to 256 px, (H, W, 3) uint8."""
    height, width = (min(side, SIDE_PX) for side in rgb.shape[:2])
    if (height, width) == rgb.shape[:2]:
        return rgb
    return cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA)


def frame_figures(rgb: np.ndarray) -> dict[str, float]:
    """All figures of one frame, (H, W, 3) uint8 sRGB."""
    rgb = comparable(rgb)
    grey = luminance(rgb)
    return {
        "slope": spectrum_slope(grey),
        "kurtosis": gradient_kurtosis(grey),
        "flat_share": flat_share(grey),
        "saturation": mean_saturation(rgb),
        "entropy_bits": entropy_bits(grey),
    }


def summarise(frames: Iterable[np.ndarray]) -> dict:
    """Median, 10 % and 90 % quantile of every figure over frames; frames without one are left out.

    Args:
        frames: at least one, each (H, W, 3) uint8 sRGB.
    """
    rows = [frame_figures(frame) for frame in frames]
    figures = {}
    for name, (low, high) in REAL.items():
        values = [row[name] for row in rows if not math.isnan(row[name])]
        low_10, median, high_90 = np.quantile(values, [0.1, 0.5, 0.9]) if values else [math.nan] * 3
        figures[name] = {
            "median": _rounded(median),
            "p10": _rounded(low_10),
            "p90": _rounded(high_90),
            "in_real_range": bool(low <= median <= high),
        }
    return {"frames": len(rows), "figures": figures}


def _rounded(value: float) -> float | None:
    return None if math.isnan(value) else round(float(value), 4)


def spread(count: int, most: int) -> list[int]:
    """At most `most` of the numbers 0 .. count - 1, evenly spread."""
    return [round(n) for n in np.linspace(0, count - 1, min(count, most))]


def dataset_frames(folder: Path, most: int) -> Iterator[np.ndarray]:
    """Frames t of a dataset, one at a time, (H, W, 3) uint8."""
    rows = read_index(folder, ["key", "shard", "rgb_offset", "rgb_size"])
    for row in rows.take(spread(len(rows), most)).to_pylist():
        member = Member(offset=row["rgb_offset"], size=row["rgb_size"])
        try:
            yield decode_png(read_members(folder / row["shard"], {"rgb.png": member})["rgb.png"])
        except (OSError, ValueError) as error:
            raise DatasetError(f"{folder}: {row['key']} cannot be read: {error}") from error


def real_groups(folder: Path) -> dict[str, list[Path]]:
    """The pictures below a folder by group: the first word of the first folder on their way."""
    groups: dict[str, list[Path]] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in (".png", ".jpg", ".jpeg") and _is_colour(path):
            parts = path.relative_to(folder).parts
            name = parts[0].split("_")[0] if len(parts) > 1 else folder.name
            groups.setdefault(name, []).append(path)
    if not groups:
        raise SynthdepthError(f"--real {folder}: allowed is a folder with 8-bit colour PNG or JPEG")
    return groups


def _is_colour(path: Path) -> bool:
    """Whether a PNG has 8-bit colour, by its header: ground truth lies beside real frames."""
    if path.suffix.lower() != ".png":
        return True
    with open(path, "rb") as file:
        header = file.read(26)
    # IHDR: bit depth, then colour type: 2 is RGB, 6 is RGB with alpha.
    return header[24:] in (b"\x08\x02", b"\x08\x06")


def real_frames(paths: list[Path]) -> Iterator[np.ndarray]:
    """Pictures of files, one at a time, (H, W, 3) uint8."""
    for path in paths:
        try:
            yield decode_png(path.read_bytes())
        except (OSError, ValueError) as error:
            raise SynthdepthError(f"{path} cannot be read: {error}") from error


def table(results: dict[str, dict]) -> str:
    """The figures as text, a line a source; a median outside the real range has a star."""
    wide = max(12, *(len(name) for name in results))
    heads = [f"{'':{wide}}  frames"] + [f"{name:>23}" for name in REAL]
    ranges = [f"{'real photos':{wide}}        "]
    ranges += [f"{f'{low:g} to {high:g}':>23}" for low, high in REAL.values()]
    lines = ["".join(heads), "".join(ranges)]
    for name, result in results.items():
        cells = [_cell(figure) for figure in result["figures"].values()]
        lines.append(f"{name:{wide}}  {result['frames']:6d}" + "".join(cells))
    return "\n".join([*lines, "median (10 % .. 90 %) of the frames; * outside the real range"])


def _cell(figure: dict) -> str:
    if figure["median"] is None:
        return f"{'none*':>23}"
    star = " " if figure["in_real_range"] else "*"
    return f"{figure['median']:.2f}{star}({figure['p10']:.2f} .. {figure['p90']:.2f})".rjust(23)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("datasets", nargs="*", type=Path, metavar="DATASET", help="folders")
    parser.add_argument("--real", type=Path, metavar="DIR", help="folder of real frames")
    parser.add_argument("--frames", type=int, default=200, help="most frames of each source")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the figures go")
    options = parser.parse_args(arguments)
    try:
        if options.frames < 1:
            raise SynthdepthError(f"--frames {options.frames}: allowed is a number from 1")
        if not options.datasets and not options.real:
            raise SynthdepthError("nothing to look at: give dataset folders, --real DIR or both")
        results = {}
        for folder in options.datasets:
            name = read_manifest(folder)["map"]
            # Two datasets of one map are told apart by their folders.
            name = name if name not in results else f"{name} ({folder})"
            results[name] = summarise(dataset_frames(folder, options.frames))
        for name, paths in (real_groups(options.real) if options.real else {}).items():
            chosen = [paths[n] for n in spread(len(paths), options.frames)]
            results[f"real: {name}"] = summarise(real_frames(chosen))
        print(table(results))
        if options.json:
            ranges = {name: list(limits) for name, limits in REAL.items()}
            report = {"real_ranges": ranges, "sources": results}
            write_whole(options.json, json.dumps(report, indent=1).encode() + b"\n")
    except SynthdepthError as error:
        print(f"image_statistics: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
