"""Methods of optical flow against the exact flow of rendered pairs: error and time of each.

python tools/flow_methods.py --folder data/neighborhood --json flow.json --sheet flow.png

The dataset has to be rendered with `--modalities flow`. Counted are pixels whose place was visible
at t-1, and of these once more those with texture: what has none has no flow to be found. The row
`rest` is the error of saying that nothing moves. Of the truth it prints how long the flow is, which
the scale of the heat map has to fit.
"""

import dataclasses
import json
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import tyro

from synthdepth.dataset.pair import Pair
from synthdepth.dataset.preview import random_pairs
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.flow import (
    INTERVALS,
    METHODS,
    Dis,
    Farneback,
    embed,
    end_point_error,
    estimate_flow,
    flow_image,
)

VARIANTS = {name: method() for name, method in METHODS.items()} | {
    "farneback without gain": Farneback(gain=1.0),
    "dis fast": Dis(preset="fast"),
    "dis ultrafast": Dis(preset="ultrafast"),
}
QUANTILES = (0.5, 0.9, 0.95, 0.99, 0.999)
# Texture is a smaller eigenvalue of the gradients in 15 x 15 px above this, of luminance in [0, 1]:
# about one grey level a pixel in every direction.
_TEXTURE, _WINDOW_PX = 1e-5, 15
_TIMED_TIMES = 3


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        folder: of the dataset.
        pairs: how many, drawn at random.
        seed: of the draw.
        json: where the figures go.
        sheet: where a picture goes of a few pairs: the frame, the exact flow, the estimates, and
            the frame with flow embedded at every interval.
    """

    folder: Path
    pairs: int = 64
    seed: int = 0
    json: Path | None = None
    sheet: Path | None = None


def textured(rgb: np.ndarray) -> np.ndarray:
    """Where an (H, W, 3) uint8 picture has texture in every direction, (H, W) bool."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float64) / 255
    gy, gx = np.gradient(grey)
    xx, xy, yy = (cv2.blur(term, (_WINDOW_PX, _WINDOW_PX)) for term in (gx * gx, gx * gy, gy * gy))
    return (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy) > _TEXTURE


def statistics(errors_px: np.ndarray) -> dict[str, float]:
    """Figures of the end-point errors (N,) [px] of all pixels together."""
    return {
        "median_px": float(np.median(errors_px)),
        "mean_px": float(np.mean(errors_px)),
        "p90_px": float(np.quantile(errors_px, 0.9)),
        "below_1_px": float(np.mean(errors_px < 1)),
    }


def measure(pairs: list[Pair]) -> dict:
    """Error and time of each method, and the lengths of the exact flow."""
    masks = [(pair.visible, pair.visible & textured(pair.rgb)) for pair in pairs]
    rows = {"rest": _row(pairs, [np.zeros_like(pair.flow) for pair in pairs], masks)}
    for name, method in VARIANTS.items():
        flows, seconds = [], []
        for pair in pairs:
            for _ in range(_TIMED_TIMES):
                start = time.perf_counter()
                flow = estimate_flow(pair.prev, pair.rgb, method)
                seconds.append(time.perf_counter() - start)
            flows.append(flow)
        rows[name] = _row(pairs, flows, masks) | {"ms_a_frame": 1e3 * float(np.median(seconds))}
    lengths = np.concatenate([np.linalg.norm(pair.flow, axis=-1).ravel() for pair in pairs])
    return {
        "pairs": len(pairs),
        "size": [pairs[0].camera.width, pairs[0].camera.height],
        "visible_share": float(np.mean([visible for visible, _ in masks])),
        "textured_share": float(np.mean([texture for _, texture in masks])),
        "true_length_px": {f"p{100 * q:g}": float(np.quantile(lengths, q)) for q in QUANTILES},
        "embed_ms_a_frame": {str(interval): _embed_ms(pairs, interval) for interval in INTERVALS},
        "methods": rows,
    }


def _row(pairs: list[Pair], flows: list[np.ndarray], masks: list) -> dict:
    visible, texture = (
        np.concatenate(
            [
                end_point_error(flow, pair.flow, mask[which])
                for pair, flow, mask in zip(pairs, flows, masks, strict=True)
            ]
        )
        for which in (0, 1)
    )
    return {"visible": statistics(visible), "textured": statistics(texture)}


def _embed_ms(pairs: list[Pair], interval: int) -> float:
    seconds = []
    for pair in pairs:
        start = time.perf_counter()
        embed(pair.rgb, pair.flow, interval)
        seconds.append(time.perf_counter() - start)
    return 1e3 * float(np.median(seconds))


def text(report: dict) -> str:
    """The report for people."""
    lines = [f"{report['pairs']} pairs of {report['size'][0]} x {report['size'][1]} px"]
    for where in ("visible", "textured"):
        share = 100 * report[f"{where}_share"]
        lines.append(
            f"{where} pixels ({share:.1f} %)     median    mean    90 %   < 1 px  ms a frame"
        )
        for name, row in report["methods"].items():
            figures = row[where]
            lines.append(
                f"  {name:24}{figures['median_px']:8.3f}{figures['mean_px']:8.3f}"
                f"{figures['p90_px']:8.3f}{100 * figures['below_1_px']:7.1f} %"
                + (f"{row['ms_a_frame']:9.1f}" if "ms_a_frame" in row else "")
            )
    lengths = ", ".join(f"{name} {px:.1f}" for name, px in report["true_length_px"].items())
    times = ", ".join(f"{i}: {ms:.2f}" for i, ms in report["embed_ms_a_frame"].items())
    return "\n".join([*lines, f"length of the exact flow [px]: {lengths}", f"embed [ms]: {times}"])


def sheet(pairs: list[Pair]) -> np.ndarray:
    """Pictures of pairs, one a row: (H, W, 3) uint8 RGB."""
    rows = []
    for pair in pairs:
        flows = [estimate_flow(pair.prev, pair.rgb, method) for method in METHODS]
        tiles = [pair.rgb, flow_image(pair.flow), *(flow_image(flow) for flow in flows)]
        tiles += [embed(pair.rgb, flows[0], interval) for interval in INTERVALS]
        rows.append(np.concatenate(tiles, axis=1))
    return np.concatenate(rows)


def main(options: Options) -> int:
    try:
        if options.pairs < 1:
            raise SynthdepthError(f"--pairs {options.pairs}: allowed is a whole number from 1")
        pairs = random_pairs(options.folder, options.pairs, options.seed)
        if not pairs or pairs[0].flow is None:
            raise DatasetError(
                f"{options.folder} has no pairs with flow: allowed is a dataset rendered with "
                "--modalities flow"
            )
    except SynthdepthError as error:
        print(error, file=sys.stderr)
        return 2
    report = measure(pairs)
    print(text(report))
    if options.json:
        options.json.write_text(json.dumps(report, indent=1) + "\n")
    if options.sheet:  # Six pairs at most.
        picture = cv2.cvtColor(sheet(pairs[:: -(-len(pairs) // 6)]), cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(options.sheet), picture)
    return 0


if __name__ == "__main__":
    sys.exit(main(tyro.cli(Options, description=__doc__)))
