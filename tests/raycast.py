"""Depth by an independent ray caster: trimesh and Embree on the exported scene."""

import cv2
import numpy as np
import trimesh

from synthdepth.maps.gltf import GLTF_FROM_WORLD, world_to_glb


class Recaster:
    """Casts the rays of a pair again, knowing only the GLB file and `meta.json`."""

    def __init__(self, world):
        stream = trimesh.util.wrap_as_stream(world_to_glb(world))
        self.mesh = trimesh.load(stream, file_type="glb").to_mesh()
        self.mesh.apply_transform(np.linalg.inv(GLTF_FROM_WORLD))
        self.caster = trimesh.ray.ray_pyembree.RayMeshIntersector(self.mesh, scale_to_box=False)

    def depth_m(self, meta) -> np.ndarray:
        """Planar depth (H, W) [m], saturated."""
        (fx, _, cx), (_, fy, cy), _ = meta["intrinsics"]
        u, v = np.meshgrid(np.arange(meta["width"]), np.arange(meta["height"]))
        rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(u.shape)], -1).reshape(-1, 3)
        view = np.array(meta["world_from_cam"])
        rays = rays @ view[:3, :3].T
        origins = np.broadcast_to(view[:3, 3], rays.shape)
        length = np.linalg.norm(rays, axis=1, keepdims=True)
        face = self.caster.intersects_first(origins, rays / length)
        corners = self.mesh.triangles[face]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.einsum("ij,ij->i", corners[:, 0] - origins, normal)
            depth = along / np.einsum("ij,ij->i", rays, normal)
        limit = meta["max_depth_m"]
        return np.where(face < 0, limit, np.minimum(depth, limit)).reshape(u.shape)


def differing(ours: np.ndarray, theirs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where two depth images differ by more than 1 cm and 0.01 %, and where that is no silhouette.

    At a silhouette the other depth is found within one pixel.

    Returns:
        Two masks (H, W).
    """
    wrong = ~np.isclose(ours, theirs, rtol=1e-4, atol=0.01)
    low, high = cv2.erode(ours, np.ones((3, 3))), cv2.dilate(ours, np.ones((3, 3)))
    silhouette = (theirs >= low - 0.5) & (theirs <= high + 0.5)
    return wrong, wrong & ~silhouette
