"""Depth by an independent ray caster: trimesh and Embree on the exported scene."""

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
        u, v = np.meshgrid(np.arange(meta["width"]), np.arange(meta["height"]))
        return self._cast(meta, u.ravel(), v.ravel()).reshape(u.shape)

    def _cast(self, meta, u, v) -> np.ndarray:
        """Planar depth (n,) [m] at pixel coordinates (n,)."""
        (fx, _, cx), (_, fy, cy), _ = meta["intrinsics"]
        rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(len(u))], axis=-1)
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
        return np.where(face < 0, limit, np.minimum(depth, limit))

    def differing(self, pair) -> tuple[int, int]:
        """How many pixels differ by more than 1 cm and 0.01 %, and how many of them on no edge.

        On an edge means: a ray a few hundredths of a pixel aside has the depth that the pair has.
        """
        wrong = ~np.isclose(pair.depth_m, self.depth_m(pair.meta), rtol=1e-4, atol=0.01)
        v, u = np.nonzero(wrong)
        turn = 2 * np.pi * np.arange(16) / 16
        ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        steps = np.concatenate([radius * ring for radius in (0.003, 0.01, 0.03)])
        around = [self._cast(pair.meta, u + dx, v + dy) for dx, dy in steps]
        near = np.isclose(np.array(around), pair.depth_m[wrong], rtol=2e-3, atol=0.02)
        return int(wrong.sum()), int((~near.any(axis=0)).sum())
