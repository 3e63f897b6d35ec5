"""A world as binary glTF, for any 3D viewer."""

from pathlib import Path

import numpy as np
import trimesh
from trimesh.visual.material import PBRMaterial

from synthdepth.errors import SynthdepthError
from synthdepth.maps.geometry import vertex_normals
from synthdepth.maps.world import Material, World

# glTF is Y up with -Z to the north; the world is Z up with +Y to the north.
GLTF_FROM_WORLD = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def world_to_glb(world: World) -> bytes:
    """The GLB file of a world: one mesh a material and label, textures and tints included.

    The node `world` turns Z up into glTF's Y up; below it, coordinates are the world's own.
    """
    scene = trimesh.Scene(base_frame="gltf")
    scene.graph.update("world", "gltf", matrix=GLTF_FROM_WORLD)
    materials = {name: _material(name, material) for name, material in world.materials.items()}
    for (material, label), part in world.surfaces.items():
        size = np.asarray(world.materials[material].size_m, np.float32)
        visual = trimesh.visual.TextureVisuals(uv=part.uv / size, material=materials[material])
        colours = np.concatenate([part.tint, np.ones((len(part.tint), 1), np.float32)], axis=1)
        visual.vertex_attributes["color"] = (np.clip(colours, 0, 1) * 255 + 0.5).astype(np.uint8)
        smooth = world.materials[material].smooth
        mesh = trimesh.Trimesh(
            part.vertices,
            part.faces,
            vertex_normals=vertex_normals(part.vertices, part.faces) if smooth else None,
            visual=visual,
            process=False,
        )
        name = f"{material}.{label}"
        scene.add_geometry(mesh, node_name=name, geom_name=name, parent_node_name="world")
    return scene.export(file_type="glb")


def _material(name: str, material: Material) -> PBRMaterial:
    from PIL import Image

    return PBRMaterial(
        name=name,
        baseColorTexture=Image.fromarray(material.texture),
        metallicFactor=1.0 if material.kind == "metal" else 0.0,
        roughnessFactor=1.0 if material.kind == "diffuse" else float(material.roughness) ** 0.5,
        doubleSided=True,
    )


def check_glb_path(out: Path) -> None:
    """Refuse a path that no GLB file can be written to, before a world is built for it.

    Raises:
        SynthdepthError: the name does not end in .glb, or its folder is not there.
    """
    if out.suffix.lower() != ".glb":
        raise SynthdepthError(f"--out {out}: allowed is a file name that ends in .glb")
    if not out.parent.is_dir():
        raise SynthdepthError(f"--out {out}: the folder {out.parent} does not exist")


def write_glb(world: World, out: Path) -> int:
    """Write a world as GLB; returns the number of bytes.

    Raises:
        SynthdepthError: see `check_glb_path`, or the file cannot be written.
    """
    check_glb_path(out)
    data = world_to_glb(world)
    try:
        out.write_bytes(data)
    except OSError as error:
        raise SynthdepthError(f"--out {out} cannot be written: {error.strerror}") from error
    return len(data)
