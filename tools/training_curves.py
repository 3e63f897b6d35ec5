"""Curves of some trainings as one SVG: the L1 loss of training, and Rel and RMSE of validation.

python tools/training_curves.py rgb=runs/rgb embed=runs/embed5 --out docs/training.svg
"""

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import tyro

from synthdepth.charts.axes import round_step
from synthdepth.charts.svg import label, line, polyline
from synthdepth.errors import DatasetError

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 320, 220, 44, 10, 34, 30
# Legible on white and on black.
STYLE = """
text{font:12px system-ui,sans-serif;fill:#808890}.strong{font-weight:600}
.grid{stroke:#808890;stroke-opacity:.25}.axis{stroke:#808890}polyline{fill:none;stroke-width:1.8}
.k0{stroke:#3b82c4;fill:none}.k1{stroke:#e0803a;fill:none}.k2{stroke:#3fa66b;fill:none}
.k3{stroke:#b8609f;fill:none}.k4{stroke:#a89028;fill:none}.k5{stroke:#7f7fd5;fill:none}
"""
PANELS = (
    ("train", "l1", "L1 of training"),
    ("validation", "rel", "Rel of validation"),
    ("validation", "rmse_m", "RMSE of validation [m]"),
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to draw.

    Attributes:
        runs: folders of trainings, each `name=folder`; their log.jsonl is read.
        out: the .svg file.
    """

    runs: tyro.conf.Positional[tuple[str, ...]]
    out: Path


def read_curve(folder: Path, kind: str, name: str) -> np.ndarray:
    """(N, 2) epochs done and values of a curve of a training's log."""
    try:
        rows = [json.loads(row) for row in (folder / "log.jsonl").read_text().splitlines()]
    except (OSError, ValueError) as error:
        raise DatasetError(f"{folder} holds no training's log: {error}") from None
    # The last line of an epoch has all of its steps; validation counts the next epoch already.
    steps = max((r["step"] / (r["epoch"] + 1) for r in rows if r["kind"] == "train"), default=1.0)
    rows = [row for row in rows if row["kind"] == kind and name in row]
    return np.array([[row["step"] / steps, row[name]] for row in rows]).reshape(-1, 2)


def smoothed(curve: np.ndarray, most: int = 80) -> np.ndarray:
    """Means of neighbours, so that about `most` points are left."""
    width = math.ceil(len(curve) / most) if len(curve) else 1
    chunks = [curve[k : k + width] for k in range(0, len(curve), width)]
    return np.array([chunk.mean(axis=0) for chunk in chunks]).reshape(-1, 2)


def panel(curves: Mapping[str, np.ndarray], title: str, left: float) -> str:
    """One chart of some curves (N, 2), from 0 upwards."""
    right = max(float(c[:, 0].max()) for c in curves.values())
    high = max(float(np.quantile(c[:, 1], 0.98)) for c in curves.values())
    step = round_step(high / 4)
    top = step * math.ceil(high / step)

    def x(value):
        return left + LEFT + value / right * (WIDTH - LEFT - RIGHT)

    def y(value):
        return HEIGHT - BOTTOM - np.minimum(value, top) / top * (HEIGHT - BOTTOM - TOP)

    parts = [label(left + LEFT, TOP - 14, title, "start", "strong")]
    for number in range(round(top / step) + 1):
        at = y(number * step)
        kind = "grid" if number else "axis"
        parts.append(line(x(0), at, x(right), at, kind))
        parts.append(label(x(0) - 6, at + 4, f"{number * step:g}", "end"))
    for tick in np.arange(0, right + 1e-9, round_step(right / 5)):
        parts.append(label(x(tick), HEIGHT - BOTTOM + 16, f"{tick:g}", "middle"))
    parts.append(label(x(right / 2), HEIGHT - 1, "epochs", "middle"))
    for number, (name, curve) in enumerate(curves.items()):
        points = np.stack([x(curve[:, 0]), y(curve[:, 1])], axis=-1)
        parts.append(polyline(points, f"k{number}", name))
    return "".join(parts)


def draw(runs: Mapping[str, Path]) -> str:
    """The SVG of some trainings by name."""
    body = [
        panel(
            {name: smoothed(read_curve(folder, kind, of)) for name, folder in runs.items()},
            title,
            number * WIDTH,
        )
        for number, (kind, of, title) in enumerate(PANELS)
    ]
    at = LEFT
    for number, name in enumerate(runs):
        body.append(line(at, HEIGHT + 14, at + 22, HEIGHT + 14, f"k{number}"))
        body.append(label(at + 28, HEIGHT + 18, name, "start"))
        at += 60 + 7 * len(name)
    size = f"{WIDTH * len(PANELS)} {HEIGHT + 28}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}">'
        f"<style>{STYLE}</style>{''.join(body)}</svg>\n"
    )


def named(texts: Sequence[str]) -> dict[str, Path]:
    """Folders by the names that were given."""
    pairs = [text.partition("=") for text in texts]
    return {name: Path(folder or name) for name, _, folder in pairs}


def main(options: Options) -> None:
    options.out.write_text(draw(named(options.runs)))


if __name__ == "__main__":
    main(tyro.cli(Options))
