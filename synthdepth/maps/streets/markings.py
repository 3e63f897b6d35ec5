"""What lies on a suburb's carriageways: paint, repairs, manhole covers and drains."""

import dataclasses

import numpy as np
from scipy import spatial

from synthdepth.maps.geometry import Geometry, Model, copies, geometry, join, quads
from synthdepth.maps.streets.graph import resampled
from synthdepth.maps.streets.plan import PAVEMENT_WIDTH_M, StreetPlan, along
from synthdepth.maps.streets.surface import KERB_HEIGHT_M
from synthdepth.maps.terrain import Terrain

PATCH_LIFT_M = 0.008
PAINT_LIFT_M = 0.015
COVER_LIFT_M = 0.018
DASH_M, DASH_GAP_M, LINE_WIDTH_M = 3.0, 9.0, 0.12  # of centre lines
STOP_LINE_M = 0.4
ZEBRA_M, ZEBRA_DEPTH_M = 0.5, 2.8  # width of bars and gaps; length of the bars


@dataclasses.dataclass(frozen=True, kw_only=True)
class StreetMarkings:
    """Rectangles on the carriageway: x, y [m], heading [rad], length along it and width [m].

    Attributes:
        paint: (n, 5).
        paint_tint: (n, 3) linear RGB reflectance.
        patches: (n, 5), repairs of the asphalt.
        patch_tint: (n,) lightness against the asphalt around them.
        drains: (n, 5).
        covers: (n, 2), centres of manhole covers [m].
        ramps: polygons (4, 2) [m] where pedestrian crossings pave the verge and drop the kerb;
            to be given to `street_surface` along with the driveways.
    """

    paint: np.ndarray
    paint_tint: np.ndarray
    patches: np.ndarray
    patch_tint: np.ndarray
    drains: np.ndarray
    covers: np.ndarray
    ramps: tuple[np.ndarray, ...]


def _frames(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points 1 m apart along a polyline, and unit tangents there."""
    points = resampled(line, 1.0)
    tangent = np.gradient(points, axis=0)
    return points, tangent / np.linalg.norm(tangent, axis=1, keepdims=True)


def _arms(plan: StreetPlan) -> list[tuple[np.ndarray, float, float]]:
    """Ways into junctions: centreline away from the junction, width, the other's half width."""
    arms = []
    for x, y, street, end in plan.approaches:
        own = plan.streets[int(street)]
        line = own.centreline if end == 0 else own.centreline[::-1]
        others = [
            s.width_m
            for i, s in enumerate(plan.streets)
            if i != int(street) and np.linalg.norm(s.centreline - (x, y), axis=1).min() < 5
        ]
        arms.append((line, own.width_m, max(others, default=own.width_m) / 2))
    for point in plan.crossings:
        for street in plan.streets:
            d = np.linalg.norm(street.centreline - point, axis=1)
            if street.kind == "collector" and d.min() < 5:
                i = int(d.argmin())
                for part in (street.centreline[i:], street.centreline[i::-1]):
                    if len(part) > 12:
                        arms.append((part, street.width_m, street.width_m / 2))
    return arms


def _rectangles(xy, along_xy, length, width) -> np.ndarray:
    """(n, 5) rectangles at `xy` (n, 2) along unit vectors `along_xy` (n, 2)."""
    n = len(xy)
    heading = np.arctan2(along_xy[:, 1], along_xy[:, 0])
    return np.column_stack([xy, heading, np.broadcast_to(length, n), np.broadcast_to(width, n)])


def _corners(rectangles: np.ndarray) -> np.ndarray:
    """Corners (n, 4, 2) of rectangles (n, 5), counter-clockwise."""
    x, y, heading, length, width = rectangles.T
    a = np.stack([np.cos(heading), np.sin(heading)], 1) * (length / 2)[:, None]
    b = np.stack([-np.sin(heading), np.cos(heading)], 1) * (width / 2)[:, None]
    c = np.stack([x, y], 1)
    return np.stack([c - a - b, c + a - b, c + a + b, c - a + b], 1)


def _at_junctions(rng, plan: StreetPlan, crossing_share: float):
    """Stop lines, zebra bars and the ramps beside them."""
    paint, ramps = [], []
    for line, width, other_half in _arms(plan):
        points, tangent = _frames(line)
        setback = other_half + 5.0
        if len(points) < setback + 14:
            continue
        main = other_half > 4.2
        zebra = main and rng.random() < crossing_share
        stop = main or rng.random() < 0.25
        if zebra:
            i = int(setback + ZEBRA_DEPTH_M / 2 - 0.5)
            across = np.array([-tangent[i, 1], tangent[i, 0]])
            bars = np.arange(-width / 2 + 0.6, width / 2 - 0.3, 2 * ZEBRA_M)
            at = points[i] + bars[:, None] * across
            paint.append(_rectangles(at, np.tile(tangent[i], (len(at), 1)), ZEBRA_DEPTH_M, ZEBRA_M))
            reach = plan.verge_m + 0.5 * PAVEMENT_WIDTH_M + 0.6
            for side in (-1, 1):
                middle = points[i] + side * (width / 2 + reach / 2 - 0.2) * across
                ramps.append(_corners(_rectangles(middle[None], across[None], reach + 0.4, 1.5))[0])
            setback += ZEBRA_DEPTH_M + 1.2
        if stop:
            i = int(setback)
            # Traffic towards the junction keeps right, that is left of the outward direction.
            left = np.array([-tangent[i, 1], tangent[i, 0]])
            middle = points[i] + left * (width / 4)
            paint.append(_rectangles(middle[None], left[None], width / 2 - 0.4, STOP_LINE_M))
    empty = np.zeros((0, 5))
    return np.concatenate([empty, *paint]), tuple(ramps)


def _centre_lines(plan: StreetPlan) -> np.ndarray:
    dashes = []
    for street in plan.streets:
        if street.kind == "collector":
            points, tangent = _frames(street.centreline)
            i = np.arange(4, len(points) - 4, int(DASH_M + DASH_GAP_M))
            dashes.append(_rectangles(points[i], tangent[i], DASH_M, LINE_WIDTH_M))
    dashes = np.concatenate([np.zeros((0, 5)), *dashes])
    far = spatial.cKDTree(plan.junctions).query(dashes[:, :2])[0] > 13
    inside = np.abs(dashes[:, :2]).max(axis=1) < plan.half_size_m - 3
    return dashes[far & inside]


def _patches(rng, plan: StreetPlan, spacing_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Utility cuts along the lanes and trenches across the street."""
    xy, heading = along(
        rng,
        plan,
        spacing_m=spacing_m,
        kerb_offset_m=-1.9,
        jitter_m=spacing_m / 2,
        junction_clear_m=3.0,
    )
    n = len(xy)
    keep = rng.random(n) < 0.6
    length, width = rng.uniform(1.2, 5.0, n), rng.uniform(0.7, 2.2, n)
    trench = rng.random(n) < 0.22
    left = np.stack([-np.sin(heading), np.cos(heading)], 1)
    # A trench runs from the kerb to the middle, or past it.
    xy = np.where(trench[:, None], xy + 0.25 * left, xy + rng.uniform(-0.5, 0.7, (n, 1)) * left)
    length = np.where(trench, rng.uniform(0.5, 0.9, n), length)
    width = np.where(trench, 3.0, width)
    heading = heading + rng.normal(0, 0.02, n)
    tint = np.where(rng.random(n) < 0.75, rng.uniform(0.55, 0.85, n), rng.uniform(1.1, 1.25, n))
    return np.column_stack([xy, heading, length, width])[keep], tint[keep]


def draw_street_markings(
    rng: np.random.Generator,
    plan: StreetPlan,
    *,
    crossing_share: float = 0.45,
    patch_spacing_m: float = 55.0,
) -> StreetMarkings:
    """Paint, repairs and covers of the plan's streets."""
    lines, ramps = _at_junctions(rng, plan, crossing_share)
    dashes = _centre_lines(plan)
    white = np.array([0.58, 0.58, 0.55])
    centre = white if rng.random() < 0.4 else np.array([0.52, 0.36, 0.07])
    tint = np.concatenate([np.tile(white, (len(lines), 1)), np.tile(centre, (len(dashes), 1))])
    tint = tint * rng.uniform(0.7, 1.05, (len(tint), 1))  # worn
    patches, patch_tint = _patches(rng, plan, patch_spacing_m)
    drains, heading = along(
        rng, plan, spacing_m=48, kerb_offset_m=-0.24, jitter_m=14, junction_clear_m=5
    )
    size = np.broadcast_to([0.55, 0.38], (len(drains), 2))
    covers, _ = along(rng, plan, spacing_m=62, kerb_offset_m=-2.6, jitter_m=25, sides="one")
    return StreetMarkings(
        paint=np.concatenate([lines, dashes]),
        paint_tint=tint,
        patches=patches,
        patch_tint=patch_tint,
        drains=np.column_stack([drains, heading, size]),
        covers=covers,
        ramps=ramps,
    )


def _laid(rectangles: np.ndarray, terrain: Terrain, lift_m: float, tint) -> Geometry:
    xy = _corners(rectangles)
    z = terrain.height_m(xy.reshape(-1, 2)).reshape(-1, 4, 1) - KERB_HEIGHT_M + lift_m
    return quads(np.concatenate([xy, z], 2), tint)


def street_markings(markings: StreetMarkings, terrain: Terrain) -> Model:
    """Meshes of the markings, millimetres above the carriageway of `street_surface`."""
    turn = 2 * np.pi * np.arange(12) / 12
    rim = np.column_stack([0.31 * np.cos(turn), 0.31 * np.sin(turn), np.zeros(12)])
    fan = np.stack([np.zeros(10, int), np.arange(1, 11), np.arange(2, 12)], 1)
    z = terrain.height_m(markings.covers) - KERB_HEIGHT_M + COVER_LIFT_M
    discs = copies(geometry(rim, fan), np.column_stack([markings.covers, z]))
    drains = _laid(markings.drains, terrain, COVER_LIFT_M, (0.8, 0.8, 0.8))
    patch = np.repeat(markings.patch_tint[:, None], 3, axis=1)
    return {
        ("road_paint", "road"): _laid(markings.paint, terrain, PAINT_LIFT_M, markings.paint_tint),
        ("asphalt", "road"): _laid(markings.patches, terrain, PATCH_LIFT_M, patch),
        ("metal", "road"): join([discs, drains]),
    }
