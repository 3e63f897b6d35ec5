"""Camera samples: radiance through haze, with the denoiser's guides, in one kernel.

Outdoors there are few lights, and each has one good way to be sampled: sun and moon are points,
found by a shadow ray at every hit; so are street lamps, of which one near by is drawn; the sky is
everywhere, found by the scattered ray that misses. A path has two hits. What would reach the second
one by way of a third is estimated: at 4 samples a pixel that is as near to the truth as tracing it
(tools/render_quality.py), for half the rays.

Every sample has its own moment while the shutter is open, which blurs what moves.

No film: samples of a pixel lie side by side and are summed in order, which takes no atomic
additions (they cost a quarter of the frame) and gives the same bits for any number of threads.
"""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import dataclasses

import drjit as dr
import mitsuba as mi

from synthdepth.camera import Intrinsics
from synthdepth.render.lamps import PER_CELL, Lamps
from synthdepth.render.sky import SUN_SLOPE

# Contrast at the meteorological visibility is 2 %: exp(-KOSCHMIEDER) (Koschmieder 1924).
KOSCHMIEDER = 3.912
# Thickness of the hazy layer seen from below: limits the haze in front of the sky.
HAZE_LAYER_M = 1000.0
# Where the air's own light is taken from the sky: sine of the elevation.
AIRLIGHT_SINE = 0.05
# A shadow ray to a lamp ends this far from its middle.
LAMP_RADIUS_M = 0.4
# What a second hit gets from beyond: share of the sky that it sees, and reflectance of the rest.
_SKY_SEEN, _REST_REFLECTS = 0.6, 0.1


@dataclasses.dataclass
class LampGrid:
    """`Lamps` as JIT values.

    Attributes:
        table, candidates, cumulative, corner, cells: as there, flattened.
        glow: radiance of every material's own light, as the camera sees it.
        indirect: likewise without that of lamps, which are sampled as such.
    """

    table: mi.Float
    candidates: mi.UInt32
    cumulative: mi.Float
    corner: mi.Point2f
    cells: mi.Vector2i
    glow: mi.Float
    indirect: mi.Float


def lamp_grid(lamps: Lamps, glow, indirect) -> LampGrid:
    """The JIT values of lamps."""
    return LampGrid(
        table=mi.Float(lamps.table.ravel()),
        candidates=mi.UInt32(lamps.candidates.ravel().astype("u4")),
        cumulative=mi.Float(lamps.cumulative.ravel()),
        corner=mi.Point2f(*lamps.corner.tolist()),
        cells=mi.Vector2i(*lamps.cells),
        glow=mi.Float(glow),
        indirect=mi.Float(indirect),
    )


@dataclasses.dataclass
class Lights:
    """The lights of a scene as JIT values, so that another scene compiles nothing.

    Attributes:
        sun: frame whose n points to the sun or moon.
        sun_irradiance: on a surface that faces it.
        sky_irradiance: on open level ground.
        visibility_m: meteorological visibility.
        limit: samples of more radiance are fireflies and are cut.
        lamps: at night.
    """

    sun: mi.Frame3f
    sun_irradiance: mi.Color3f
    sky_irradiance: mi.Color3f
    visibility_m: mi.Float
    limit: mi.Float
    lamps: LampGrid | None


@dataclasses.dataclass
class View:
    """Where the camera is and how it moves, as JIT values.

    Attributes:
        origin: its position at mid-exposure [m].
        right, down, forward: its axes.
        moved: how far it goes while the shutter is open [m].
        turned: and turns, as a rotation vector [rad].
    """

    origin: mi.Point3f
    right: mi.Vector3f
    down: mi.Vector3f
    forward: mi.Vector3f
    moved: mi.Vector3f
    turned: mi.Vector3f


def camera_samples(
    scene, sampler, seed, camera: Intrinsics, spp: int, lights: Lights, view: View
) -> list:
    """Mean radiance, guide albedo and guide normal of every pixel: 9 arrays of width * height.

    The guides are those of the first hit, faded by the haze as the radiance is, so that the
    denoiser does not look for texture where the air hides it.

    Args:
        scene: with the sky without its sun as environment.
        sampler: an independent sampler.
        seed: UInt32, opaque.
        camera: intrinsics.
        spp: samples a pixel.
        lights: sun, sky, air and lamps.
        view: where the camera is.
    """
    count = camera.width * camera.height * spp
    sampler = sampler.fork()
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(seed, count)
    number = dr.arange(mi.UInt32, count)
    pixel = number // spp
    # The samples of a pixel share the exposure out among them.
    moment = (mi.Float(number % spp) + sampler.next_1d()) / spp - 0.5
    shake = sampler.next_2d()
    # An integer coordinate is a pixel's centre.
    x = (mi.Float(pixel % camera.width) + (shake.x - 0.5 - camera.cx)) / camera.fx
    y = (mi.Float(pixel // camera.width) + (shake.y - 0.5 - camera.cy)) / camera.fy
    toward = view.forward + view.right * x + view.down * y
    toward += dr.cross(view.turned, toward) * moment
    ray = mi.Ray3f(view.origin + view.moved * moment, dr.normalize(toward))

    hit = scene.ray_intersect_preliminary(ray, coherent=True)
    si = hit.compute_surface_interaction(ray, mi.RayFlags.All)
    found = si.is_valid()
    bsdf = si.bsdf()
    albedo = bsdf.eval_diffuse_reflectance(si, found)
    radiance = _sun_at(scene, sampler, si, bsdf, lights, found)
    radiance += _scattered(scene, sampler, si, bsdf, lights, found)
    if lights.lamps is not None:
        radiance += _lamps_at(scene, sampler, si, bsdf, lights.lamps, found)
        radiance += _glow(si, albedo, lights.lamps.glow, found)
    radiance = dr.select(found, radiance, scene.environment().eval(si) + _sun_disc(ray.d, lights))
    # A grazing glossy bounce can divide by zero: one such sample would blacken a denoised patch.
    usable = dr.all(dr.isfinite(radiance))
    radiance = dr.select(usable, dr.minimum(radiance, lights.limit), 0.0)

    sky_m = HAZE_LAYER_M / dr.maximum(ray.d.z, 0.01)
    clear = dr.exp(-KOSCHMIEDER / lights.visibility_m * dr.select(found, si.t, sky_m))
    # Airlight: the sky just above the horizon in the same direction.
    horizon = dr.zeros(mi.SurfaceInteraction3f)
    horizon.wi = -dr.normalize(mi.Vector3f(ray.d.x, ray.d.y + 1e-6, AIRLIGHT_SINE))
    air = scene.environment().eval(horizon)

    radiance = dr.lerp(air, radiance, clear)
    guide = dr.select(found, dr.lerp(1.0, albedo, clear), 1.0)
    normal = dr.select(found, si.sh_frame.n * clear, 0.0)
    channels = [*radiance, *guide, *normal]
    # One evaluation for all nine; each sum alone would trace the paths again.
    dr.eval(channels)
    return [dr.block_sum(channel, spp) / spp for channel in channels]


def _sun_at(scene, sampler, si, bsdf, lights, active):
    """Sunlight that a hit reflects: one shadow ray to a point of the sun's disc."""
    disc = mi.warp.square_to_uniform_disk_concentric(sampler.next_2d()) * SUN_SLOPE
    toward = dr.normalize(lights.sun.to_world(mi.Vector3f(disc.x, disc.y, 1.0)))
    value = bsdf.eval(mi.BSDFContext(), si, si.to_local(toward), active)
    lit = active & dr.any(value > 0)
    shadow = scene.ray_test(si.spawn_ray(toward), lit)
    return dr.select(lit & ~shadow, value * lights.sun_irradiance, 0.0)


def _lamps_at(scene, sampler, si, bsdf, lamps: LampGrid, active):
    """Lamplight that a hit reflects: one shadow ray to one of the lamps that matter there."""
    cell = mi.Vector2i(dr.floor((mi.Point2f(si.p.x, si.p.y) - lamps.corner) / Lamps.cell_m))
    inside = dr.all((cell >= 0) & (cell < lamps.cells))
    active = active & inside
    first = mi.UInt32(cell.x * lamps.cells.y + cell.y) * PER_CELL
    dice = sampler.next_1d(active)
    slot, below = mi.UInt32(0), mi.Float(0)
    share = dr.gather(mi.Float, lamps.cumulative, first, active)
    for k in range(1, PER_CELL):
        upto = dr.gather(mi.Float, lamps.cumulative, first + (k - 1), active)
        beyond = dice >= upto
        slot = dr.select(beyond, k, slot)
        below = dr.select(beyond, upto, below)
        share = dr.select(beyond, dr.gather(mi.Float, lamps.cumulative, first + k, active), share)
    chance = share - below
    row = dr.gather(mi.UInt32, lamps.candidates, first + slot, active) * 12

    def part(offset):
        return mi.Vector3f(
            *(dr.gather(mi.Float, lamps.table, row + (offset + k), active) for k in range(3))
        )

    toward = part(0) - si.p
    distance = dr.norm(toward)
    toward /= distance
    a, b = part(6), part(9)
    d = -toward
    level = dr.maximum(d.x, 0) * a.x + dr.maximum(-d.x, 0) * a.y
    level += dr.maximum(d.y, 0) * a.z + dr.maximum(-d.y, 0) * b.x
    level += dr.maximum(d.z, 0) * b.y + dr.maximum(-d.z, 0) * b.z
    value = bsdf.eval(mi.BSDFContext(), si, si.to_local(toward), active)
    lit = active & dr.any(value > 0) & (chance > 0)
    shadow_ray = si.spawn_ray(toward)
    # Short of the lamp's own glass and hood.
    shadow_ray.maxt = dr.maximum(distance - LAMP_RADIUS_M, 0)
    shadow = scene.ray_test(shadow_ray, lit)
    level /= dr.square(dr.maximum(distance, LAMP_RADIUS_M)) * chance
    return dr.select(lit & ~shadow, value * mi.Color3f(part(3)) * level, 0.0)


def _glow(si, colour, table, active):
    """A surface's own light, on the side that its normal points to."""
    material = mi.UInt32(si.shape.eval_attribute_1("face_material", si, active))
    front = active & (dr.dot(si.n, si.to_world(si.wi)) > 0)
    return dr.select(front, colour * dr.gather(mi.Float, table, material, front), 0.0)


def _scattered(scene, sampler, si, bsdf, lights, active):
    """Light by way of one scattered ray: the sky where it misses, a lit surface where it hits."""
    sample, weight = bsdf.sample(
        mi.BSDFContext(), si, sampler.next_1d(active), sampler.next_2d(active), active
    )
    active = active & dr.any(weight > 0)
    second = scene.ray_intersect(si.spawn_ray(si.to_world(sample.wo)), active)
    found = second.is_valid() & active
    there = second.bsdf()
    light = _sun_at(scene, sampler, second, there, lights, found)
    colour = there.eval_diffuse_reflectance(second, found)
    if lights.lamps is not None:
        light += _lamps_at(scene, sampler, second, there, lights.lamps, found)
        light += _glow(second, colour, lights.lamps.indirect, found)
    up = 0.5 + 0.5 * second.sh_frame.n.z * dr.sign(second.wi.z)
    sky = lights.sky_irradiance * (_SKY_SEEN * up)
    sun = lights.sun_irradiance * dr.maximum(lights.sun.n.z, 0)
    rest = (lights.sky_irradiance + sun) * (_REST_REFLECTS * (1 - up))
    light += colour * (sky + rest) * dr.inv_pi
    miss = active & ~found
    return weight * dr.select(found, light, scene.environment().eval(second, miss))


def _sun_disc(direction, lights):
    """The sun itself, for those who look into it."""
    inside = dr.dot(direction, lights.sun.n) > dr.rsqrt(1 + SUN_SLOPE**2)
    return dr.select(inside, lights.sun_irradiance / (dr.pi * SUN_SLOPE**2), 0.0)
