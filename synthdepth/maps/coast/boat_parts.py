"""What stands on boats' decks: cabins, wheelhouses, masts and rigging, outboards, fenders."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.coast.hulls import Hull, stations
from synthdepth.maps.coast.lofts import (
    between,
    both_sides,
    fan,
    lathe,
    pane,
    railing,
    sheet,
)
from synthdepth.maps.geometry import Geometry, Model, box, copies, join, quads, tube, yaw_matrix

LABEL = "vehicle"
BLACK = (0.02, 0.02, 0.022)
_RUBBER_COLOURS = ((0.62, 0.62, 0.6), (0.02, 0.035, 0.09), (0.03, 0.03, 0.032), (0.4, 0.1, 0.02))

Parts = dict[str, list[Geometry]]


def add(parts: Parts, material: str, *pieces: Geometry) -> None:
    """Puts pieces with the others of their material."""
    parts.setdefault(material, []).extend(pieces)


def finished(parts: Parts, label: str = LABEL) -> Model:
    """The parts as a model, all under one label."""
    return {(material, label): join(pieces) for material, pieces in parts.items()}


def cabin(
    parts: Parts, base, top, tint, *, panes=(), roof_m: float = 0.06, material: str = "paint"
) -> np.ndarray:
    """A superstructure between two half rings, mirrored, with a roof and windows.

    Args:
        parts: where it goes.
        base, top: (k, 3) left half rings from the stern's middle (or its corner) to the bow's [m].
        tint: (3,) of its walls and roof.
        panes: ((panel, u0, u1, v0, v1), ...) windows in wall panels, which are numbered from the
            stern along the left side; each comes on both sides.
        roof_m: rise of the roof's middle.
        material: of the walls.

    Returns:
        The roof's rim, (2k, 3).
    """
    low, high = np.asarray(base, np.float64), np.asarray(top, np.float64)
    walls = []
    for i in range(len(low) - 1):
        corner = np.stack([low[i + 1], low[i], high[i], high[i + 1]])
        walls.append(quads(corner[None], tint))
    add(parts, material, both_sides(join(walls)))
    # The walls of the ends that cross the middle.
    for i in (0, len(low) - 1):
        if low[i, 1] > 0.02:
            a, b = low[i], low[i] * [1, -1, 1]
            c, d = high[i] * [1, -1, 1], high[i]
            order = [a, b, c, d] if i == 0 else [b, a, d, c]
            add(parts, material, quads(np.stack(order)[None], tint))
    for panel, *shares in panes:
        if panel < len(low) - 1:
            corner = np.stack([low[panel + 1], low[panel], high[panel], high[panel + 1]])
            add(parts, "glass", both_sides(pane(corner, shares)))
        else:  # the front, across the middle
            i = len(low) - 1
            corner = np.stack([low[i] * [1, -1, 1], low[i], high[i], high[i] * [1, -1, 1]])
            add(parts, "glass", pane(corner, shares))
    rim = np.concatenate([high, high[::-1] * [1, -1, 1]])
    keep = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1) > 1e-3
    rim = rim[keep]
    lid = fan(rim[::-1], tint)
    lid.vertices[-1, 2] += roof_m
    add(parts, material, lid)
    return rim


def outboard(tint, size: float = 1.0) -> Parts:
    """An outboard motor: origin on the transom's top edge, screw towards -x, down in the water."""
    cowl = np.array([[0.05, 0.12], [0.03, 0.16], [-0.28, 0.16], [-0.36, 0.09]])
    out: Parts = {}
    low = np.column_stack([cowl, np.full(4, 0.12)])
    mid = np.column_stack([cowl * [1.05, 1.1], [0.42, 0.44, 0.42, 0.38]])
    top = np.column_stack([cowl * [0.7, 0.6], [0.5, 0.54, 0.5, 0.46]])
    grid = np.stack([low, mid, top])
    add(out, "car_paint", both_sides(sheet(grid[:, ::-1][:, ::-1], tint)))
    for ring in (low, top):
        lid = np.concatenate([ring, ring[::-1] * [1, -1, 1]])
        add(out, "paint", fan(lid, tint))
    leg = box((0.18, 0.07, 0.75), (-0.14, 0, -0.6), np.multiply(tint, 0.8))
    plate = box((0.34, 0.16, 0.02), (-0.18, 0, -0.42), np.multiply(tint, 0.8))
    torpedo = tube([[0.06, 0, -0.62], [-0.1, 0, -0.62], [-0.3, 0, -0.62]], [0.02, 0.055, 0.045], 8)
    blades = [
        quads(
            np.array(
                [[-0.3, -0.03, 0.0], [-0.26, 0.03, 0], [-0.26, 0.06, 0.13], [-0.31, -0.02, 0.13]]
            )[None]
        )
    ]
    screw = []
    for turn in np.arange(3) * 2 * np.pi / 3:
        c, s = np.cos(turn), np.sin(turn)
        spin = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        screw.append(copies(blades[0], [[0, 0, -0.62]], rotation=spin[None]))
    bracket = box((0.12, 0.24, 0.26), (0.0, 0, -0.2), BLACK)
    add(out, "paint", leg, plate, torpedo.tinted(np.multiply(tint, 0.8)), bracket)
    add(out, "metal", *screw)
    return {m: [copies(join(p), np.zeros((1, 3)), scale=np.full(1, size))] for m, p in out.items()}


def put(parts: Parts, other: Parts, position, yaw_rad: float = 0.0, rotation=None) -> None:
    """Sets other parts down among these."""
    turn = yaw_matrix(yaw_rad) if rotation is None else rotation
    at = np.asarray(position, np.float64)[None]
    for material, pieces in other.items():
        add(parts, material, copies(join(pieces), at, rotation=turn[None]))


def fenders(rng: np.random.Generator, parts: Parts, hull: Hull, count: int) -> None:
    """Inflated fenders that hang from the rail over the sides."""
    tint = _RUBBER_COLOURS[rng.integers(len(_RUBBER_COLOURS))]
    size = np.clip(hull.length_m / 10, 0.6, 1.3)
    r, high = 0.11 * size, 0.55 * size
    body = lathe(
        [0.3 * r, 0.8 * r, r, r, 0.8 * r, 0.3 * r],
        [0, 0.06 * high, 0.18 * high, 0.82 * high, 0.94 * high, high],
        8,
        tint,
    )
    for side in (1, -1):
        if rng.random() < 0.35:
            continue
        s = np.linspace(0.18, 0.66, count) + rng.normal(0, 0.015, count)
        at = hull.edge(s)
        at[:, 1] += r * 1.02
        low = at - [0, 0, high + 0.12]
        low[:, 2] = np.maximum(low[:, 2], 0.03)
        low[:, 1] *= side
        high_end = at * [1, side, 1]
        add(parts, "paint", copies(body, low))
        hook = hull.edge(s, 0.05, 0.04) * [1, side, 1]
        add(
            parts,
            "paint",
            round_bars(low + [0, 0, high], high_end + [0, 0, 0.02], 0.006, (0.5, 0.5, 0.48), 3),
            round_bars(high_end + [0, 0, 0.02], hook, 0.006, (0.5, 0.5, 0.48), 3),
        )


def cleats(hull: Hull, shares, lift_m: float = 0.03, inset_m: float = 0.12) -> Geometry:
    """Mooring cleats on both side decks."""
    one = join(
        [
            box((0.22, 0.025, 0.025), (0, 0, 0.035)),
            box((0.04, 0.03, 0.05), (0.04, 0, -0.01)),
            box((0.04, 0.03, 0.05), (-0.04, 0, -0.01)),
        ]
    )
    at = hull.edge(np.asarray(shares, np.float64), inset_m, lift_m)
    return both_sides(copies(one, at))


def side_rails(
    hull: Hull,
    s0: float,
    s1: float,
    high_m: float,
    *,
    inset_m=0.05,
    lift_m=0.0,
    wires=1,
    tint=(1.0, 1.0, 1.0),
    spacing_m=1.6,
) -> Geometry:
    """A railing of 25 mm tube and wires on both edges; at the bow (`s1` = 1) a closed pulpit."""
    s = np.linspace(s0, min(s1, 0.985), 12)
    left = hull.edge(s, inset_m, lift_m)
    if s1 < 1:
        return both_sides(railing(left, high_m, tint, spacing_m=spacing_m, wires=wires))
    path = np.concatenate([left, left[::-1] * [1, -1, 1]])
    return railing(path, high_m, tint, spacing_m=spacing_m, wires=wires)


def windscreen(plan, high_m: float, rake_m: float, frame=(1.0, 1.0, 1.0)) -> Parts:
    """Panes in a frame over a half outline (k, 3), from the middle of the front to the side."""
    low = np.asarray(plan, np.float64)
    inward = low.copy()
    inward[:, 0] -= rake_m
    inward[:, 1] *= 0.9
    high = inward + [0, 0, high_m]
    # It slopes down to its ends.
    high[-1] = low[-1] + (high[-1] - low[-1]) * 0.55
    out: Parts = {}
    glass = []
    for i in range(len(low) - 1):
        glass.append(quads(np.stack([low[i], low[i + 1], high[i + 1], high[i]])[None]))
    add(out, "glass", both_sides(join(glass)))
    rods = [round_bars(low, high, 0.014, frame, 4), tube(high, 0.016, 4, frame)]
    add(out, "metal", both_sides(join(rods)))
    return out


def mast_and_rigging(
    parts: Parts,
    hull: Hull,
    foot,
    high_m: float,
    *,
    boom_m: float,
    spreaders: int = 1,
    tint=(0.9, 0.9, 0.92),
    chain_y: float | None = None,
    backstay: bool = True,
) -> np.ndarray:
    """A mast with boom, spreaders, shrouds and stays as true thin wires.

    Args:
        parts: where it goes.
        hull: for the ends of the wires.
        foot: (3,) foot of the mast [m].
        high_m: length of the mast.
        boom_m: length of the boom.
        spreaders: pairs of spreaders.
        tint: of the spars.
        chain_y: y of the shrouds' feet, or at the hull's edge.
        backstay: one runs from the masthead to the stern.

    Returns:
        The gooseneck, (3,), where the boom is hinged.
    """
    foot = np.asarray(foot, np.float64)
    head = foot + [-0.012 * high_m, 0, high_m]
    r = 0.0055 * high_m + 0.02
    add(parts, "metal", tube(between(foot, head, [0, 0.6, 1]), [r, r, 0.7 * r], 8, tint))
    s = hull.share_at(foot[0] - 0.25)
    chain = hull.edge(np.array([s]), 0.06)[0]
    if chain_y is not None:
        chain = np.array([foot[0] - 0.25, chain_y, foot[2]])
    bow = hull.edge(np.array([0.97]))[0] * [1, 0, 1]
    stern = hull.edge(np.array([0.01]))[0] * [1, 0, 1]
    stay_top = between(foot, head, [0.92])[0]
    wires_a, wires_b = [stay_top], [bow]
    if backstay:
        wires_a.append(head)
        wires_b.append(stern)
    for side in (1, -1):
        at = [chain * [1, side, 1]]
        for k in range(spreaders):
            level = between(foot, head, [(k + 1) / (spreaders + 1.15)])[0]
            tip = level + np.array([-0.12, side * (0.075 * high_m / (k + 1) + 0.1), 0.03])
            tip[1] = np.sign(side) * min(abs(tip[1]), abs(chain[1]) * 0.92)
            add(parts, "metal", tube([level, tip], [0.022, 0.012], 4, tint))
            at.append(tip)
            # Lower shrouds, to the root of the spreaders.
            wires_a.append(at[-2] + [0.12, 0, 0] if k == 0 else at[-2])
            wires_b.append(level - [0, 0, 0.1])
        at.append(stay_top)
        wires_a += at[:-1]
        wires_b += at[1:]
    add(parts, "metal", round_bars(wires_a, wires_b, 0.004, (0.7, 0.7, 0.7), 4))
    gooseneck = foot + [-r, 0, min(0.13 * high_m, 1.0) + 0.1]
    end = gooseneck + [-boom_m, 0, 0.02 * boom_m]
    add(parts, "metal", tube([gooseneck, end], 0.045 if high_m > 8 else 0.03, 6, tint))
    # Topping lift and mainsheet.
    add(
        parts,
        "paint",
        round_bars(
            [end, between(gooseneck, end, [0.7])[0]],
            [head, between(gooseneck, end, [0.7])[0] * [1, 0, 0] + [0, 0, foot[2] - 0.25]],
            0.005,
            (0.55, 0.54, 0.5),
            3,
        ),
    )
    # Masthead: wind vane and aerial.
    add(
        parts,
        "paint",
        round_bars([head], [head + [0, 0, 0.07 * high_m]], 0.004, BLACK, 3),
        box((0.32, 0.012, 0.03), head + [0.05, 0, 0.1], BLACK),
    )
    return gooseneck


def furled_main(gooseneck, boom_m: float, tint) -> Geometry:
    """A mainsail stowed along the boom under its cover."""
    t = np.linspace(0, 1, 7)
    path = between(gooseneck + [-0.05, 0, 0.14], gooseneck + [-0.95 * boom_m, 0, 0.1], t)
    path[:, 2] += 0.03 * np.sin(9 * t)
    return tube(path, np.interp(t, [0, 0.15, 1], [0.1, 0.16, 0.06]) * (0.6 + boom_m / 10), 8, tint)


def set_sail(
    tack, clew, head, belly_m: float, tint, *, roach: float = 0.0, seams: int = 9
) -> Geometry:
    """A sail between three corners (3,), bellied towards +y, its panels in two tones.

    `roach` bows the leech out, as a share of the foot.
    """
    rows, columns = seams + 1, 7
    v = np.linspace(0, 1, rows)[:, None, None]
    u = np.linspace(0, 1, columns)[None, :, None]
    tack, clew, head = (np.asarray(x, np.float64) for x in (tack, clew, head))
    luff = tack + v * (head - tack)
    leech = clew + v * (head - clew)
    leech = leech + roach * np.sin(np.pi * v) * (clew - tack)
    p = luff + u * (leech - luff)
    depth = belly_m * np.sin(np.pi * np.clip(u, 0, 1) ** 0.75) * (1 - 0.75 * v) * (v + 0.12) ** 0.2
    p = p + depth * np.array([0, 1.0, 0])
    pieces = []
    for k in range(rows - 1):
        tone = 1.0 - 0.05 * (k % 2)
        pieces.append(sheet(p[k : k + 2], np.multiply(tint, tone)))
    return join(pieces)


def hull_line(hull: Hull, count: int = 14) -> np.ndarray:
    """Left sheer points from stern to bow, (count, 3)."""
    return hull.edge(stations(count))
