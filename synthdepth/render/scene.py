"""World -> Mitsuba scene: meshes, materials, sky, camera. The one place that creates meshes."""

import mitsuba as mi
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.maps.geometry import Geometry, vertex_normals
from synthdepth.maps.world import Material, World
from synthdepth.render.plugins import register_plugins

# Mitsuba's camera looks along +Z with x left and y up; OpenCV's has x right and y down.
_OPENCV_FROM_MITSUBA = np.diag([-1.0, -1.0, 1.0, 1.0])
_FAR_CLIP_M = 5e4


def to_world(world_from_cam: np.ndarray) -> mi.Transform4f:
    """Mitsuba's `to_world` of a camera from a pose (4, 4) in OpenCV axes."""
    return mi.Transform4f(np.asarray(world_from_cam, np.float64) @ _OPENCV_FROM_MITSUBA)


def build_scene(world: World, camera: Intrinsics) -> mi.Scene:
    """The scene of a world with a `sunsky` light and a pinhole camera (pose still to be set).

    Meshes are one per material and label, never instances: tracing instances in the JIT variants
    costs seconds a frame. Vertex normals only where the material is smooth.
    """
    register_plugins()
    bsdfs = {name: _bsdf(material) for name, material in world.materials.items()}
    scene = {
        "type": "scene",
        "sky": _sky(world),
        "camera": _camera(camera),
    }
    for number, ((material, label), part) in enumerate(world.surfaces.items()):
        scene[f"surface_{number:03d}"] = _mesh(
            f"{material}.{label}", part, bsdfs[material], world.materials[material]
        )
    return mi.load_dict(scene)


def _mesh(name: str, part: Geometry, bsdf: mi.BSDF, material: Material) -> mi.Mesh:
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    mesh = mi.Mesh(
        name,
        vertex_count=len(part.vertices),
        face_count=len(part.faces),
        props=properties,
        has_vertex_normals=material.smooth,
        has_vertex_texcoords=True,
    )
    mesh.add_attribute("vertex_tint", 3, np.ascontiguousarray(part.tint, np.float32).ravel())
    # Metres -> repeats of the texture; v flipped, because its first row is the top.
    uv = part.uv / np.asarray(material.size_m, np.float32) * np.float32([1, -1])
    params = mi.traverse(mesh)
    params["vertex_positions"] = np.ascontiguousarray(part.vertices, np.float32).ravel()
    params["faces"] = np.ascontiguousarray(part.faces, np.uint32).ravel()
    params["vertex_texcoords"] = np.ascontiguousarray(uv, np.float32).ravel()
    if material.smooth:
        params["vertex_normals"] = vertex_normals(part.vertices, part.faces).ravel()
    params.update()
    return mesh


def _bsdf(material: Material) -> mi.BSDF:
    reflectance = {
        "type": "tinted",
        "base": {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(material.texture)),
            "wrap_mode": "repeat",
        },
        "tint": {"type": "mesh_attribute", "name": "vertex_tint"},
    }
    alpha = max(material.roughness, 0.02)
    nested = {
        "diffuse": {"type": "diffuse", "reflectance": reflectance},
        "plastic": {"type": "roughplastic", "diffuse_reflectance": reflectance, "alpha": alpha},
        "glass": {"type": "roughplastic", "diffuse_reflectance": reflectance, "alpha": alpha},
        "metal": {
            "type": "roughconductor",
            "material": "Al",
            "specular_reflectance": reflectance,
            "alpha": alpha,
        },
    }
    return mi.load_dict({"type": "twosided", "inside": nested[material.kind]})


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
