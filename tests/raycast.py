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

    def _cast_exactly(self, meta, u, v) -> np.ndarray:
        """As `_cast`, by every triangle on the pixel and in float64.

        Embree works in float32: between blades of grass it passes by triangles that a ray hits.
        """
        (fx, _, cx), (_, fy, cy), _ = meta["intrinsics"]
        view = np.array(meta["world_from_cam"])
        p = (self.mesh.triangles - view[:3, 3]) @ view[:3, :3]
        p = p[p[..., 2].max(axis=1) > 0]
        z = np.maximum(p[..., 2], 1e-9)
        x, y = p[..., 0] / z * fx + cx, p[..., 1] / z * fy + cy
        low, high = (
            np.stack([x.min(axis=1), y.min(axis=1)]),
            np.stack([x.max(axis=1), y.max(axis=1)]),
        )
        behind = p[..., 2].min(axis=1) <= 0
        low[:, behind], high[:, behind] = -np.inf, np.inf
        depth = np.full(len(u), float(meta["max_depth_m"]))
        for k, pixel in enumerate(np.stack([u, v], axis=1)[..., None]):
            a, b, c = p[((low <= pixel) & (pixel <= high)).all(axis=0)].swapaxes(0, 1)
            ray = np.array([(u[k] - cx) / fx, (v[k] - cy) / fy, 1.0])
            # Moeller and Trumbore, "Fast, minimum storage ray-triangle intersection" (1997).
            across, offset = np.cross(ray, c - a), np.cross(-a, b - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                scale = 1 / np.einsum("ij,ij->i", b - a, across)
                s = scale * np.einsum("ij,ij->i", -a, across)
                t = scale * (offset @ ray)
                far = scale * np.einsum("ij,ij->i", c - a, offset)
            hit = (s >= 0) & (t >= 0) & (s + t <= 1) & (far > 0)
            depth[k] = far[hit].min(initial=depth[k])
        return depth

    def differing(self, pair) -> tuple[int, int]:
        """How many pixels differ by more than 1 cm and 0.01 %, and how many of them on no edge.

        Where Embree differs, all triangles are tried in float64. On an edge means: a ray a few
        hundredths of a pixel aside has the depth that the pair has.
        """
        depth = pair.depth_m
        v, u = np.nonzero(~np.isclose(depth, self.depth_m(pair.meta), rtol=1e-4, atol=0.01))
        exact = self._cast_exactly(pair.meta, u, v)
        wrong = ~np.isclose(depth[v, u], exact, rtol=1e-4, atol=0.01)
        v, u = v[wrong], u[wrong]
        turn = 2 * np.pi * np.arange(16) / 16
        ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        steps = np.concatenate([radius * ring for radius in (0.003, 0.01, 0.03)])
        around = [self._cast(pair.meta, u + dx, v + dy) for dx, dy in steps]
        near = np.isclose(np.array(around), depth[v, u], rtol=2e-3, atol=0.02)
        return len(u), int((~near.any(axis=0)).sum())
