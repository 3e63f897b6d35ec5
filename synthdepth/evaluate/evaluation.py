"""Evaluating pictures under one or several protocols, one at a time or streaming."""

import dataclasses
import math
from collections.abc import Iterable

import numpy as np

from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.accumulate import Accumulator, average_record, image_rows
from synthdepth.evaluate.metrics import METRICS, Metrics
from synthdepth.evaluate.protocols import Protocol, compare


def evaluate_protocol(
    protocol: Protocol,
    prediction: np.ndarray,
    truth: np.ndarray,
    *,
    valid: np.ndarray | None = None,
    max_depth_m: float = math.inf,
    shows: str = "full",
) -> Metrics | None:
    """The metrics of one picture; arguments as `compare` has them.

    Returns:
        All metrics (of the boundary ones only what the protocol asks for); None where the protocol
        leaves the picture out, as too few of its pixels count.
    """
    row = _row(protocol, prediction, truth, valid, max_depth_m, shows)[0]
    return None if row is None else average_record(row, "images")


def _row(protocol, prediction, truth, valid, max_depth_m, shows):
    """The picture's row, or None where it is left out; and what it was scaled by."""
    compared = compare(
        protocol, prediction, truth, valid=valid, max_depth_m=max_depth_m, shows=shows
    )
    if np.count_nonzero(compared.mask) < protocol.least_pixels:
        return None, compared.ratio
    edges = compared.edges() if "boundary_f1" in protocol.metrics else None
    return image_rows(compared.sums(), edges), compared.ratio


@dataclasses.dataclass(frozen=True, kw_only=True)
class ProtocolResult:
    """What a protocol gave over many pictures.

    Attributes:
        protocol: which, with all its choices.
        images: means of the pictures' metrics: what programs print.
        pixels: the metrics of all pixels at once.
        left_out: pictures with too few pixels that count.
        ratio_median: median of the ratios of median scaling; 1 where there is none.
        by_scene: (scenes, row) for `scene_intervals`.
        truths: kinds of ground truth that were met; the protocol is meant for one.
    """

    protocol: Protocol
    images: Metrics
    pixels: Metrics
    left_out: int
    ratio_median: float
    by_scene: np.ndarray
    truths: tuple[str, ...] = ()

    @property
    def terms(self) -> str:
        """The protocol on one line, and what ground truth it met if that is not its own."""
        met = ", ".join(self.truths)
        return f"{self.protocol}" + (
            f"; ground truth here: {met}" if met not in ("", self.protocol.truth) else ""
        )

    def __str__(self) -> str:
        """The protocol, then what it prints."""
        counted = f"{self.images.images} pictures, {self.left_out} left out"
        if self.images.mean_truth is not None:
            counted += f", {self.images.pixels} pixels, mean truth {self.images.mean_truth:.3f} m"
        names = self.protocol.metrics
        values = [f"  {name} {_shown(getattr(self.images, name))}" for name in names]
        return "\n".join([self.terms, f"  {counted}", *values])


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"


class Evaluation:
    """Several protocols at once over a stream of pictures; parts of a run merge.

    Args:
        protocols: at least one.
    """

    def __init__(self, protocols: Iterable[Protocol]) -> None:
        self.protocols = tuple(dict.fromkeys(protocols))
        if not self.protocols:
            raise SynthdepthError("no protocol given: at least one is needed")
        self._sums = [Accumulator() for _ in self.protocols]
        self._left_out = [0] * len(self.protocols)
        self._ratios: list[list[float]] = [[] for _ in self.protocols]
        self._truths: set[str] = set()

    def add(
        self,
        prediction: np.ndarray,
        truth: np.ndarray,
        *,
        valid: np.ndarray | None = None,
        max_depth_m: float = math.inf,
        shows: str = "full",
        scene: object = None,
        truth_is: str | None = None,
    ) -> None:
        """Count a picture; arguments as `compare` has them.

        Args:
            scene: what it shows, for the bootstrap: a scene, a drive.
            truth_is: kind of its ground truth, as `Protocol.truth` has it.
        """
        if truth_is is not None:
            self._truths.add(truth_is)
        for k, protocol in enumerate(self.protocols):
            row, ratio = _row(protocol, prediction, truth, valid, max_depth_m, shows)
            if row is None:
                self._left_out[k] += 1
                continue
            self._sums[k].add(row, scene)
            if protocol.scaling == "median":
                self._ratios[k].append(ratio)

    def merge(self, other: "Evaluation") -> None:
        """Take over what another one of the same protocols has counted."""
        if self.protocols != other.protocols:
            raise ValueError("evaluations of different protocols cannot be merged")
        for k in range(len(self.protocols)):
            self._sums[k].merge(other._sums[k])
            self._left_out[k] += other._left_out[k]
            self._ratios[k] += other._ratios[k]
        self._truths |= other._truths

    def results(self) -> list[ProtocolResult]:
        """What each protocol gave, in the order they were given."""
        return [
            ProtocolResult(
                protocol=protocol,
                images=self._sums[k].metrics("images"),
                pixels=self._sums[k].metrics("pixels"),
                left_out=self._left_out[k],
                ratio_median=float(np.median(self._ratios[k])) if self._ratios[k] else 1.0,
                by_scene=self._sums[k].by_scene,
                truths=tuple(sorted(self._truths)),
            )
            for k, protocol in enumerate(self.protocols)
        ]


def metric_table(results: Iterable[ProtocolResult], names: Iterable[str] | None = None) -> str:
    """One table of several results, a line each, and under it what each protocol means.

    Args:
        results: at least one.
        names: columns, of `METRICS`; by default the mean truth, which tells crops and frames apart,
            and all that any of the protocols prints.
    """
    results = list(results)
    if names is None:
        asked = {"mean_truth"}.union(*(result.protocol.metrics for result in results))
        names = [name for name in METRICS if name in asked]
    names = list(names)
    head = ["protocol", "pictures", *names]
    lines = [
        [
            result.protocol.name,
            str(result.images.images),
            *(
                _shown(getattr(result.images, name)) if _prints(result.protocol, name) else ""
                for name in names
            ),
        ]
        for result in results
    ]
    widths = [max(map(len, column)) for column in zip(head, *lines, strict=True)]
    rows = [
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in (head, *lines)
    ]
    return "\n".join([*rows, "", *(result.terms for result in results)])


def _prints(protocol: Protocol, name: str) -> bool:
    return name in protocol.metrics or METRICS[name].better == ""
