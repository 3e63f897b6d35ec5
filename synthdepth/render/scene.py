"""World -> Mitsuba scene: meshes, materials, sky, camera. The one place that creates meshes."""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

from collections.abc import Mapping

import mitsuba as mi
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.maps.geometry import join, vertex_normals
from synthdepth.maps.world import LABELS, World
from synthdepth.render.atlas import pack
from synthdepth.render.plugins import atlas_texture

# Mitsuba's camera looks along +Z with x left and y up; OpenCV's has x right and y down.
_OPENCV_FROM_MITSUBA = np.diag([-1.0, -1.0, 1.0, 1.0])
_FAR_CLIP_M = 5e4


def to_world(world_from_cam: np.ndarray) -> mi.Transform4f:
    """Mitsuba's `to_world` of a camera from a pose (4, 4) in OpenCV axes."""
    return mi.Transform4f(np.asarray(world_from_cam, np.float64) @ _OPENCV_FROM_MITSUBA)


def build_scene(world: World, camera: Intrinsics) -> mi.Scene:
    """The scene of a world with a `sunsky` light and a pinhole camera (pose still to be set).

    Meshes are one per way of reflecting light, never instances: tracing instances in the JIT
    variants costs seconds a frame. What material and label a face has are attributes of the mesh.
    """
    texture = atlas_texture(atlas := pack(world.materials))
    groups: dict[tuple, list[tuple[str, str]]] = {}
    for key in world.surfaces:
        material = world.materials[key[0]]
        look = (material.kind, material.roughness if material.kind != "diffuse" else 0.0)
        groups.setdefault((*look, material.smooth), []).append(key)
    bsdfs = {look[:2]: _bsdf(*look[:2], texture) for look in groups}
    scene = {"type": "scene", "sky": _sky(world), "camera": _camera(camera)}
    for number, (look, keys) in enumerate(groups.items()):
        scene[f"surface_{number:02d}"] = _mesh(
            f"surface_{number:02d}", world, keys, atlas.index, bsdfs[look[:2]], smooth=look[2]
        )
    return mi.load_dict(scene)


def _mesh(
    name: str,
    world: World,
    keys: list[tuple[str, str]],
    index: Mapping[str, int],
    bsdf: mi.BSDF,
    smooth: bool,
) -> mi.Mesh:
    """One mesh of some of the world's surfaces, (material, label) each."""
    parts = [world.surfaces[key] for key in keys]
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
        "face_material": (1, np.repeat(np.float32([index[m] for m, _ in keys]), counts)),
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


def _bsdf(kind: str, roughness: float, texture: mi.Texture) -> mi.BSDF:
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


def _sky(world: World) -> dict:
    # One emitter for sun and sky: emitters are picked uniformly, so two would waste samples.
    return {
        "type": "sunsky",
        "sun_direction": [float(x) for x in world.light.sun_direction],
        "turbidity": world.light.turbidity,
        "albedo": 0.15,
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
