"""Squares: patterned paving, trees in beds, cafés, a market, a fountain, strings of lights."""

import numpy as np
import shapely

from synthdepth.maps.bars import round_bars
from synthdepth.maps.downtown.fill import GROUND_M, Fill, block, flat, frame_of
from synthdepth.maps.furniture.poles import catenary, wires
from synthdepth.maps.geometry import box, copies
from synthdepth.maps.placement import points_along, points_within

_TREES = ("maple", "young", "oak", "birch", "fruit", "palm")


def fill_plaza(rng: np.random.Generator, fill: Fill, area: shapely.Polygon) -> None:
    """A square on an area: its ground and all that stands on it."""
    frame = frame_of(area)
    length, width = frame.length_m, frame.width_m
    inner = area.buffer(-2.2)
    layers = [(area, ("paving", "pavement"), _stone(rng))]
    layers += _pattern(rng, area, frame)
    taken = []
    middle = frame.origin
    if area.contains(shapely.Point(middle).buffer(5)):
        name = "fountain" if rng.random() < 0.55 else "statue"
        fill.add("furniture", name, middle, frame.yaw_rad)
        ring = shapely.Point(middle).buffer(6.5, quad_segs=8)
        layers.append((ring.intersection(area), ("concrete", "pavement"), _stone(rng)))
        taken.append(shapely.Point(middle).buffer(6.0))
        turn = np.arange(6) * np.pi / 3 + rng.uniform(0, 1)
        fill.add(
            "furniture", "bench", middle + 5.4 * np.column_stack([np.cos(turn), np.sin(turn)]), turn
        )
    taken += _beds(rng, fill, frame, inner)
    if rng.random() < 0.55:
        taken += _market(rng, fill, frame, inner, taken)
    taken += _cafe(rng, fill, frame, inner, taken)
    fill.ground(layers)
    posts = _lights(rng, fill, frame, inner, taken)
    taken.append(shapely.MultiPoint(posts).buffer(0.4) if len(posts) else shapely.Polygon())
    free = inner.difference(shapely.union_all(taken))
    for name, count, apart in (
        ("kiosk", 1, 6.0), ("advertising_column", 2, 15.0), ("bicycle_rack", 3, 9.0),
        ("litter_bin", 5, 9.0), ("planter", 5, 5.0), ("bench", 6, 5.0), ("phone_box", 1, 5.0),
    ):  # fmt: skip
        at = points_within(rng, free.buffer(-1.5), int(rng.integers(0, count + 1)), apart)
        fill.add("furniture", name, at, frame.yaw_rad + np.pi / 2 * rng.integers(0, 4, len(at)))
        if len(at):
            free = free.difference(shapely.MultiPoint(at).buffer(2.2))
    count = int(min(area.area / 38, 45) * rng.uniform(0.5, 1.2))
    crowd = points_within(rng, free, count, 0.9)
    fill.add("person", "any", crowd, rng.uniform(0, 2 * np.pi, len(crowd)))
    fill.add("furniture", "bollard", points_along(area.buffer(-0.5).exterior, 2.6, rng))
    lamps = points_within(rng, free, int(2 + area.area / 700), 9.0)
    fill.add("lamp", "lantern", lamps, rng.uniform(0, 6, len(lamps)))
    if length * width < 400:
        fill.add("tree", "maple", points_within(rng, free, 2, 5.0))


def _stone(rng) -> np.ndarray:
    """Tint of paving: grey, warm or dark."""
    return rng.uniform(0.75, 1.12) * np.array([1.03, 1.0, rng.uniform(0.88, 1.0)])


def _pattern(rng, area, frame) -> list:
    """Bands across the square, or a chequer of fields."""
    step = rng.uniform(5, 9)
    half = 0.5 * np.array([frame.length_m, frame.width_m])
    dark = _stone(rng) * rng.uniform(0.55, 0.8)
    surface = (("paving", "pavement"), ("concrete", "pavement"))[int(rng.integers(2))]
    fields = []
    if rng.random() < 0.6:
        band = rng.uniform(0.4, 0.9)
        fields = [
            frame.rectangle((x, 0), (band, 2 * half[1])) for x in np.arange(-half[0], half[0], step)
        ]
        if rng.random() < 0.6:
            rows = np.arange(-half[1], half[1], step)
            fields += [frame.rectangle((0, y), (2 * half[0], band)) for y in rows]
    else:
        for i, x in enumerate(np.arange(-half[0], half[0], step)):
            for j, y in enumerate(np.arange(-half[1], half[1], step)):
                if (i + j) % 2:
                    fields.append(frame.rectangle((x, y), (step, step)))
    return [(shapely.union_all(fields).intersection(area), surface, dark)]


def _beds(rng, fill: Fill, frame, inner) -> list:
    """Rows of trees along the longer sides, each in a raised bed with a seat before it."""
    spacing, offset = rng.uniform(7, 10), rng.uniform(4.5, 6.5)
    size = rng.uniform(1.5, 2.3)
    raised = rng.random() < 0.6
    species = str(rng.choice(_TREES))
    taken, kerbs, soils = [], [], []
    for side in (-1, 1):
        y = side * (frame.width_m / 2 - offset)
        for x in np.arange(-frame.length_m / 2 + 5, frame.length_m / 2 - 4, spacing):
            bed = frame.rectangle((x, y), (size, size))
            if not inner.contains(bed) or rng.random() < 0.1:
                continue
            at = frame.out((x, y))
            fill.add("tree", species, at)
            fill.add("bush", "any", at + rng.uniform(-0.35, 0.35, (2, 2)) * size)
            kerbs.append(bed.difference(bed.buffer(-0.12, join_style="mitre")))
            soils.append(bed.buffer(-0.12, join_style="mitre"))
            taken.append(bed.buffer(0.9))
            if rng.random() < 0.6:
                out = frame.out((x, y - side * (size / 2 + 0.6)))
                fill.add("furniture", "bench", out, frame.yaw_rad - side * np.pi / 2)
    if kerbs:
        high = GROUND_M + (rng.uniform(0.3, 0.5) if raised else 0.05)
        fill.models.append(
            {
                ("concrete", "street_furniture"): block(
                    shapely.MultiPolygon(kerbs), GROUND_M - 0.1, high, _stone(rng)
                ),
                ("soil", "ground"): flat(shapely.MultiPolygon(soils), high - 0.04),
            }
        )
    return taken


def _fits(place, inner, taken: list) -> bool:
    return inner.contains(place) and not any(place.intersects(t) for t in taken)


def _market(rng, fill: Fill, frame, inner, taken: list) -> list:
    """Two rows of stalls that face each other."""
    new, side = [], float(rng.choice([-1, 1])) * rng.uniform(0.1, 0.2) * frame.width_m
    for row in (-1, 1):
        for x in np.arange(-frame.length_m / 2 + 6, 0.1 * frame.length_m, 3.9):
            y = side + row * 3.4
            spot = frame.rectangle((x, y), (3.2, 2.6))
            if len(new) < 9 and _fits(spot, inner, taken + new):
                yaw = frame.yaw_rad - row * np.pi / 2
                fill.add("furniture", "market_stall", frame.out((x, y)), yaw)
                new.append(spot)
                if rng.random() < 0.7:
                    fill.add("person", "standing", frame.out((x, y - row * 2.1)), yaw + np.pi)
    return new


def _cafe(rng, fill: Fill, frame, inner, taken: list) -> list:
    """Tables in front of a café at one end, with people on their feet between them."""
    end = float(rng.choice([-1, 1]))
    new = []
    for i in range(4):
        for j in range(5):
            x = end * (frame.length_m / 2 - 4.5 - 3.0 * i)
            y = (j - 2) * 3.0
            spot = frame.rectangle((x, y), (2.4, 2.4))
            if rng.random() < 0.75 and _fits(spot, inner, taken + new):
                fill.add("furniture", "cafe_table", frame.out((x, y)), rng.uniform(0, 6))
                new.append(spot)
    return new


def _lights(rng, fill: Fill, frame, inner, taken: list) -> np.ndarray:
    """Bulbs on wires between two rows of poles; returns the poles' feet (k, 2)."""
    if rng.random() < 0.25 or not fill.near(inner, 80.0):
        return np.zeros((0, 2))
    spacing, half, high = rng.uniform(7, 10), min(0.3 * frame.width_m, 9.0), rng.uniform(4.4, 5.8)
    xs = np.arange(-frame.length_m / 2 + 7, frame.length_m / 2 - 6, spacing)
    feet = np.array([frame.out([(x, -half), (x, half)]) for x in xs]).reshape(-1, 2, 2)
    ok = [
        bool(shapely.contains_xy(inner, *f.T).all())
        and not any(shapely.intersects_xy(t, *f.T).any() for t in taken)
        for f in feet
    ]
    feet = feet[np.array(ok, bool)]
    if len(feet) < 2:
        return np.zeros((0, 2))
    tops = np.concatenate([feet, np.full((*feet.shape[:2], 1), GROUND_M + high)], axis=-1)
    base = tops - [0, 0, high + 0.1]
    a = np.concatenate([tops[:, 0], tops[:-1, 0], tops[:-1, 1]])
    b = np.concatenate([tops[:, 1], tops[1:, 1], tops[1:, 0]])
    lines = catenary(a - [0, 0, 0.08], b - [0, 0, 0.08], 0.05, 12)
    bulbs = lines[:, 1:-1].reshape(-1, 3)
    bulb = box((0.07, 0.07, 0.1), (0, 0, -0.12), (0.6, 0.55, 0.42))
    fill.models.append(
        {
            ("paint", "pole"): round_bars(
                base.reshape(-1, 3), tops.reshape(-1, 3), 0.055, (0.05, 0.05, 0.055)
            ),
            ("paint", "wire"): wires(lines, 0.012, (0.02, 0.02, 0.02)),
            ("paint", "street_furniture"): copies(bulb, bulbs),
        }
    )
    return feet.reshape(-1, 2)
