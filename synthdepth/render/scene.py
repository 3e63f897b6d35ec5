"""World -> Mitsuba scene: meshes, materials, sky, camera. The one place that creates meshes."""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.maps.geometry import join, vertex_normals
from synthdepth.maps.world import LABELS, Light, World
from synthdepth.render.atlas import Atlas, pack
from synthdepth.render.plugins import atlas_texture

# Mitsuba's camera looks along +Z with x left and y up; OpenCV's has x right and y down.
_OPENCV_FROM_MITSUBA = np.diag([-1.0, -1.0, 1.0, 1.0])
_FAR_CLIP_M = 5e4
# Mitsuba takes an attribute in by way of a list of Python floats: smaller meshes, lower peak.
_BATCH_VERTICES = 1_000_000


def to_world(world_from_cam: np.ndarray) -> mi.Transform4f:
    """Mitsuba's `to_world` of a camera from a pose (4, 4) in OpenCV axes."""
    return mi.Transform4f(np.asarray(world_from_cam, np.float64) @ _OPENCV_FROM_MITSUBA)


def build_scene(world: World, camera: Intrinsics, *, with_sun: bool) -> mi.Scene:
    """The scene of a world with its sky and a pinhole camera (pose still to be set).

    Args:
        world: the generated world.
        camera: intrinsics.
        with_sun: let the sky emit the sun's light too; our integrator adds it itself.

    Meshes are one per way of reflecting light, never instances: tracing instances in the JIT
    variants costs seconds a frame. What material and label a face has are attributes of the mesh.
    """
    atlas = pack(world.materials)
    # Without a JIT compiler a texture written in Python is called sample by sample: one colour a
    # vertex has to do.
    jit = dr.is_jit_v(mi.Float)
    texture = atlas_texture(atlas) if jit else {"type": "mesh_attribute", "name": "vertex_tint"}
    groups: dict[tuple, list[tuple[str, str]]] = {}
    for key in world.surfaces:
        material = world.materials[key[0]]
        look = (material.kind, material.roughness if material.kind != "diffuse" else 0.0)
        groups.setdefault((*look, material.smooth), []).append(key)
    bsdfs = {look[:2]: _bsdf(*look[:2], texture) for look in groups}
    scene = {"type": "scene", "sky": sunsky(world.light, with_sun=with_sun)}
    scene["camera"] = _camera(camera)
    for look, group in groups.items():
        for keys in _batches(world, group):
            name = f"surface_{len(scene):03d}"
            scene[name] = _mesh(
                name, world, keys, atlas, bsdfs[look[:2]], smooth=look[2], flat=not jit
            )
    return mi.load_dict(scene)


def _batches(world: World, keys: list[tuple[str, str]]) -> list[list[tuple[str, str]]]:
    """Surfaces in batches of about `_BATCH_VERTICES`; one that is larger is a batch of its own."""
    batches, size = [[]], 0
    for key in keys:
        count = len(world.surfaces[key].vertices)
        if batches[-1] and size + count > _BATCH_VERTICES:
            batches.append([])
            size = 0
        batches[-1].append(key)
        size += count
    return batches


def _mesh(
    name: str,
    world: World,
    keys: list[tuple[str, str]],
    atlas: Atlas,
    bsdf: mi.BSDF,
    *,
    smooth: bool,
    flat: bool,
) -> mi.Mesh:
    """One mesh of some of the world's surfaces, (material, label) each.

    With `flat` the tint takes in the texture's mean colour.
    """
    parts = [world.surfaces[key] for key in keys]
    if flat:
        parts = [
            part.tinted(atlas.mean(material))
            for (material, _), part in zip(keys, parts, strict=True)
        ]
    counts = [len(part.faces) for part in parts]
    whole = join(parts)
    # Metres -> repeats of the texture; v flipped, because its first row is the top.
    repeats = [1 / np.asarray(world.materials[material].size_m) for material, _ in keys]
    scale = np.repeat(np.float32(repeats), [len(part.vertices) for part in parts], axis=0)
    uv = whole.uv * scale * np.float32([1, -1])
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    mesh = mi.Mesh(
        name,
        vertex_count=len(whole.vertices),
        face_count=len(whole.faces),
        props=properties,
        has_vertex_normals=smooth,
        has_vertex_texcoords=True,
    )
    attributes = {
        "vertex_tint": (3, whole.tint.ravel()),
        "face_material": (1, np.repeat(np.float32([atlas.index[m] for m, _ in keys]), counts)),
        "face_label": (1, np.repeat(np.float32([LABELS[label] for _, label in keys]), counts)),
    }
    for attribute, (channels, values) in attributes.items():
        mesh.add_attribute(attribute, channels, values)
    params = mi.traverse(mesh)
    params["vertex_positions"] = whole.vertices.ravel()
    params["faces"] = whole.faces.astype(np.uint32).ravel()
    params["vertex_texcoords"] = uv.ravel()
    if smooth:
        params["vertex_normals"] = vertex_normals(whole.vertices, whole.faces).ravel()
    params.update()
    return mesh


def _bsdf(kind: str, roughness: float, texture: mi.Texture | dict) -> mi.BSDF:
    alpha = max(roughness, 0.02)
    nested = {
        "diffuse": {"type": "diffuse", "reflectance": texture},
        "plastic": {"type": "roughplastic", "diffuse_reflectance": texture, "alpha": alpha},
        "glass": {"type": "roughplastic", "diffuse_reflectance": texture, "alpha": alpha},
        "metal": {
            "type": "roughconductor",
            "material": "Al",
            "specular_reflectance": texture,
            "alpha": alpha,
        },
    }
    return mi.load_dict({"type": "twosided", "inside": nested[kind]})


def sunsky(light: Light, *, with_sun: bool) -> dict:
    """Mitsuba's clear-sky model with or without the sun's disc."""
    return {
        "type": "sunsky",
        "sun_direction": [float(x) for x in light.sun_direction],
        "turbidity": light.turbidity,
        "albedo": 0.15,
        "sun_scale": 1.0 if with_sun else 0.0,
    }


def _camera(camera: Intrinsics) -> dict:
    return {
        "type": "perspective",
        "fov": camera.fov_deg,
        "fov_axis": "x",
        "near_clip": 0.01,
        "far_clip": _FAR_CLIP_M,
        # Mitsuba's offsets are relative to the film's size and move the picture's frame, not the
        # principal point: their sign is the opposite of cx's and cy's.
        "principal_point_offset_x": ((camera.width - 1) / 2 - camera.cx) / camera.width,
        "principal_point_offset_y": ((camera.height - 1) / 2 - camera.cy) / camera.height,
        "sampler": {"type": "independent"},
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }
