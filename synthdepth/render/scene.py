"""World -> Mitsuba scene: meshes, materials, camera. The one place that creates meshes."""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.maps.geometry import join, vertex_normals
from synthdepth.maps.world import LABELS, World
from synthdepth.render.atlas import Atlas
from synthdepth.render.plugins import atlas_texture
from synthdepth.render.sky import Sky

# Mitsuba's camera looks along +Z with x left and y up; OpenCV's has x right and y down.
_OPENCV_FROM_MITSUBA = np.diag([-1.0, -1.0, 1.0, 1.0])
_FAR_CLIP_M = 5e4
# Larger meshes are slower to fill than several smaller ones, and their arrays live twice meanwhile.
_BATCH_VERTICES = 1_000_000


def to_world(world_from_cam: np.ndarray) -> mi.Transform4f:
    """Mitsuba's `to_world` of a camera from a pose (4, 4) in OpenCV axes."""
    return mi.Transform4f(np.asarray(world_from_cam, np.float64) @ _OPENCV_FROM_MITSUBA)


def build_scene(world: World, camera: Intrinsics, atlas: Atlas, emitters: dict) -> mi.Scene:
    """The scene of a world with a pinhole camera (pose still to be set).

    Args:
        world: the generated world.
        camera: intrinsics.
        atlas: of the world's materials.
        emitters: what lights it from above, as Mitsuba's dictionaries by name.

    Meshes are one per way of reflecting light, never instances: tracing instances in the JIT
    variants costs seconds a frame. What material and label a face has are attributes of the mesh.
    """
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
    scene = {"type": "scene", "camera": _camera(camera)} | emitters
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
        # Arrays are taken in by way of Python floats, 15 times slower than a list of one float.
        mesh.add_attribute(attribute, channels, [0.0] * len(values))
    params = mi.traverse(mesh)
    for attribute, (_, values) in attributes.items():
        params[attribute] = values
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
        # A metal film of the thickness that office panes have mirrors 15 %: as this index does.
        "coated_glass": {
            "type": "roughplastic",
            "diffuse_reflectance": texture,
            "alpha": alpha,
            "int_ior": 2.26,
        },
        "water": {
            "type": "roughplastic",
            "diffuse_reflectance": texture,
            "alpha": alpha,
            "int_ior": 1.333,
        },
        "metal": {
            "type": "roughconductor",
            "material": "Al",
            "specular_reflectance": texture,
            "alpha": alpha,
        },
    }
    return mi.load_dict({"type": "twosided", "inside": nested[kind]})


def sky_emitter(sky: Sky) -> dict:
    """The environment that shows a sky."""
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(sky.image),
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
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
