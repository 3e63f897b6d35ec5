"""The sections of the page: what each says of a dataset, as escaped HTML."""

import itertools
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
import pyarrow as pa

from synthdepth.charts.axes import linear_axis, log_axis, number_text
from synthdepth.charts.elements import bar_cell, card, chip, numeric, table
from synthdepth.charts.svg import depth_scale, histogram
from synthdepth.dataset.pair import Pair
from synthdepth.view.figures import ALTITUDE_STEPS_M, flight_map, map_span_m
from synthdepth.view.flights import Flight
from synthdepth.view.pictures import flow_wheel, label_colours, normal_colours, tiles

# Bands of the depth table [m]; the last one ends where the depth saturates.
_BANDS_M = (0, 5, 10, 25, 50, 100)
_MAPS_AT_MOST = 12


def depth_histogram(depth: np.ndarray, far: float) -> str:
    """Shares of pixels over the depth, of what is nearer than `far` [m]."""
    within = depth[depth < far]
    if not len(within):
        return ""
    low = min(max(float(within.min()), 0.1), 1.0)
    figure = histogram(within, log_axis(low, far), name="depth", unit="m", total=len(depth))
    return card(
        "Share of pixels",
        f"metres, logarithmic; the median is of what is nearer than {far:g} m",
        figure,
    )


def depth_bands(depth: np.ndarray, far: float) -> str:
    """A table of the shares of pixels in bands of depth [m]."""
    edges = [edge for edge in _BANDS_M if edge < far] + [far]
    bands = {
        f"{low:g} to {high:g} m": float(np.mean((depth >= low) & (depth < high)))
        for low, high in itertools.pairwise(edges)
    }
    bands[f"{far:g} m and beyond"] = float(np.mean(depth >= far))
    most = max(bands.values())
    rows = [
        [f"<th scope=row>{band}</th>", numeric(f"{100 * share:.1f} %"), bar_cell(share / most)]
        for band, share in bands.items()
    ]
    head = "<th>Depth</th><th class=number>Pixels</th><th></th>"
    return f'<div class="card">{table(head, rows)}</div>'


def flight_histograms(index: pa.Table, altitude: np.ndarray) -> str:
    """Altitude, speed and nearest depth of all pairs."""
    speed, nearest = (index[name].to_numpy() for name in ("speed_mps", "nearest_depth_m"))
    low = max(float(nearest.min()), 0.1)
    near_axis = log_axis(low, max(float(nearest.max()), low * 1.1), bins=24)
    drawn = (
        ("Altitude", "metres above the ground", altitude, linear_axis(altitude), "m"),
        ("Speed", "metres a second", speed, linear_axis(speed), "m/s"),
        ("Nearest depth", "metres, logarithmic", nearest, near_axis, "m"),
    )
    return "".join(
        card(title, note, histogram(values, axis, name=title.lower(), unit=unit))
        for title, note, values, axis, unit in drawn
    )


def conditions(index: pa.Table) -> str:
    """A table of light and weather."""
    condition = np.array(index["condition"].to_pylist())
    scene, sun, visible = (
        index[name].to_numpy() for name in ("scene_index", "sun_elevation_deg", "visibility_m")
    )
    totals = _totals(index)
    most, rows = max(totals.values()), []
    for name, total in totals.items():
        at = condition == name
        rows.append([
            f"<th scope=row>{escape(_plain(name))}</th>",
            numeric(f"{total:,}"),
            numeric(f"{100 * total / len(index):.1f} %"),
            numeric(f"{len(np.unique(scene[at])):,}"),
            numeric(f"{_range(sun[at])}°"),
            numeric(f"{_range(visible[at] / 1000)} km"),
            bar_cell(total / most),
        ])  # fmt: skip
    heads = ("Pairs", "Share", "Scenes", "Sun or moon", "Visibility")
    head = "<th>Condition</th>" + "".join(f"<th class=number>{h}</th>" for h in heads) + "<th></th>"
    return (
        '<div class="card scroll" role="region" aria-label="Light and weather" tabindex="0">'
        f"{table(head, rows)}</div>"
    )


def maps(flights: Sequence[Flight], altitude: np.ndarray) -> tuple[str, str]:
    """What to say of the maps, and a map of each scene, of the first ones where they are many.

    Args:
        flights: all of the dataset.
        altitude: (rows of the index,) above the ground [m].
    """
    by_scene: dict[str, list[Flight]] = {}
    for flight in flights:
        by_scene.setdefault(flight.scene, []).append(flight)
    shown = dict(itertools.islice(by_scene.items(), _MAPS_AT_MOST))
    span_m = map_span_m(list(shown.values()))
    maps = "".join(
        card(
            scene,
            f"{sum(len(flight.rows) for flight in found):,} pairs in {len(found)} flights",
            flight_map(found, lambda flight: altitude[flight.rows], span_m),
        )
        for scene, found in shown.items()
    )
    said = (
        "Where the cameras were, north (+Y) up, all maps to one scale. A ring marks where a "
        "flight's first pair is, with the flight's number; dashes join runs of frames, and are "
        "not where the drone flew between them."
    )
    if len(shown) < len(by_scene):
        said += f" The first {len(shown)} of {len(by_scene)} scenes."
    return said, maps


def map_legend() -> str:
    """The colours of the altitudes on the maps."""
    names = [f"{low} to {high} m" for low, high in itertools.pairwise(ALTITUDE_STEPS_M)]
    names.append(f"{ALTITUDE_STEPS_M[-1]} m and more")
    chips = "".join(
        f'<li><span class="swatch s{step}"></span>{name}</li>' for step, name in enumerate(names)
    )
    return (
        '<div class="card maps-legend"><h3>Altitude above the ground</h3>'
        f'<ul class="chips">{chips}</ul></div>'
    )


def legends(manifest: Mapping, pairs: Sequence[Pair], far: float) -> str:
    """What the colours of the pictures mean."""
    parts = [f'<div class="scale-of-depth"><h3>Depth, in metres</h3>{depth_scale(far)}</div>']
    if pairs[0].flow is not None:
        parts.append(
            f'<div><h3>Flow</h3><p class="wheel">{flow_wheel().img()}'
            "<span>Where a pixel of frame t was in frame t-1; full colour where it is longest in "
            "the picture.</span></p></div>"
        )
    if pairs[0].normal is not None:
        chips = "".join(chip(colour, side) for side, colour in normal_colours().items())
        parts.append(f'<div><h3>Normals face</h3><ul class="chips">{chips}</ul></div>')
    if pairs[0].seg is not None:
        labels = manifest["labels"]
        counts = sum(np.bincount(pair.seg.ravel(), minlength=256) for pair in pairs)
        shares = counts / counts.sum()
        chips = "".join(
            chip(colour, name.replace("_", " "), _share(shares[labels[name]]))
            for name, colour in label_colours(labels).items()
        )
        parts.append(
            '<div class="wide"><h3>Labels, and their share of these pictures</h3>'
            f'<ul class="chips">{chips}</ul></div>'
        )
    return f'<div class="card legends">{"".join(parts)}</div>'


def pairs_by_condition(index: pa.Table, pairs: Sequence[Pair]) -> str:
    """The pairs with their pictures, the commonest condition first."""
    totals = _totals(index)
    parts = []
    for condition in totals:
        chosen = [pair for pair in pairs if pair.meta["condition"] == condition]
        if not chosen:
            continue
        wide = len(tiles(chosen[0])) > 4
        few = f"{len(chosen)} of {totals[condition]:,} pairs"
        parts.append(
            f"<h3>{escape(_plain(condition))} <small>{few}</small></h3>"
            f'<div class="pairs" style="--pair:{900 if wide else 460}px">'
            f"{''.join(_pair(pair) for pair in chosen)}</div>"
        )
    return "".join(parts)


def _pair(pair: Pair) -> str:
    shown, meta = tiles(pair), pair.meta
    facts = (
        _plain(meta["condition"]),
        f"{meta['altitude_m']:.1f} m up",
        f"{meta['speed_mps']:.1f} m/s",
        f"nearest {meta['nearest_depth_m']:.1f} m",
        meta["split"],
    )
    caption = "".join(f"<span>{escape(fact)}</span>" for fact in facts)
    pictures = "".join(f"<li>{tile.img()}<span>{tile.name}</span></li>" for tile in shown)
    narrow = 3 if len(shown) % 3 == 0 else 2
    return (
        f'<figure class="pair"><figcaption><code>{escape(pair.key)}</code>{caption}</figcaption>'
        f'<ul style="--n:{len(shown)};--narrow:{narrow}">{pictures}</ul></figure>'
    )


def _totals(index: pa.Table) -> dict[str, int]:
    """Pairs of each condition in the dataset, the commonest first."""
    counted = index["condition"].value_counts().to_pylist()
    ranked = sorted(counted, key=lambda entry: (-entry["counts"], entry["values"]))
    return {entry["values"]: entry["counts"] for entry in ranked}


def _plain(word: str) -> str:
    return word.replace("_", " ").capitalize()


def _range(values: np.ndarray) -> str:
    low, high = (number_text(float(value)) for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _share(share: float) -> str:
    if not share:
        return "none"
    return f"{100 * share:.1f} %" if share >= 0.0005 else "&lt; 0.1 %"
