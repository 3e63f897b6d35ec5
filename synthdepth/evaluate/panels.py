"""Pictures of predictions: frame, input, truth, and what each source makes of it."""

import dataclasses
from collections.abc import Sequence

import cv2
import numpy as np

from synthdepth.charts.pictures import Tile, tile
from synthdepth.dataset.preview import colour_depth
from synthdepth.dataset.sample import Sample
from synthdepth.evaluate.metrics import HIGHEST_M, LOWEST_M, known_truth, usable_depth
from synthdepth.evaluate.protocols import resized
from synthdepth.evaluate.sources import BASELINE, Source
from synthdepth.pix2pix.panels import colour_error

# Truth that covers less than this is drawn with larger dots, or nobody would see it.
_SPARSE = 0.5
_DOT_PX = 5
_MOST_SOURCES = 3


@dataclasses.dataclass(frozen=True, kw_only=True)
class Panel:
    """One picture.

    Attributes:
        key: its name.
        facts: of its metadata, in words.
        tiles: frame, input where it is another, truth; then prediction and error of each source.
    """

    key: str
    facts: tuple[str, ...]
    tiles: tuple[Tile, ...]


def make_panel(sample: Sample, sources: Sequence[Source], far_m: float) -> Panel:
    """The panel of a sample.

    Args:
        sample: with ground truth.
        sources: models before baselines; the first few are shown.
        far_m: where the colours of depth end [m].
    """
    known = known_truth(sample.depth_m, sample.valid)
    learnt = [source for source in sources if not source.name.startswith(BASELINE)]
    shown = (learnt or list(sources))[:_MOST_SOURCES]
    tiles = [tile("frame t", "frame t", sample.rgb)]
    tiles += [
        tile(_named("input", source, shown), f"input of {source.name}", picture)
        for source in shown
        if (picture := source.picture(sample)) is not None
    ]
    truth = np.where(known[..., None], colour_depth(sample.depth_m, far_m), 0).astype(np.uint8)
    tiles.append(tile("truth", "true depth", _visible(truth, known)))
    for source in shown:
        prediction = resized(source.depth_m([sample])[0], known.shape, "edges")
        p = usable_depth(prediction, LOWEST_M, min(sample.max_depth_m, HIGHEST_M))
        g = np.where(known, sample.depth_m, 0)
        error = f"AbsRel {np.mean(np.abs(p - g)[known] / g[known]):.3f}" if known.any() else "–"
        name = _named("prediction", source, shown)
        tiles.append(tile(name, f"depth predicted by {source.name}", colour_depth(p, far_m)))
        wrong = _visible(colour_error(g, p), known)
        tiles.append(tile(f"error, {error}", f"relative error of {source.name}, {error}", wrong))
    return Panel(key=sample.key, facts=_facts(sample), tiles=tuple(tiles))


def _named(what: str, source: Source, shown: Sequence[Source]) -> str:
    return what if len(shown) == 1 else f"{what}, {source.name}"


def _visible(colours: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Colours with larger dots where they are sparse."""
    if known.mean() >= _SPARSE:
        return colours
    return cv2.dilate(colours, np.ones((_DOT_PX, _DOT_PX), np.uint8))


def _facts(sample: Sample) -> tuple[str, ...]:
    meta = sample.meta
    known = {
        "condition": lambda value: str(value).replace("_", " "),
        "altitude_m": lambda value: f"{value:.1f} m up",
        "speed_mps": lambda value: f"{value:.1f} m/s",
        "drive": str,
    }
    return tuple(text(meta[name]) for name, text in known.items() if name in meta)
