"""Our Mitsuba texture: looks a surface's colour up in the world's atlas.

It is defined inside a function because its base class exists only once a variant is set.
"""

import functools

import drjit as dr
import mitsuba as mi

from synthdepth.render.atlas import Atlas


@functools.cache
def atlas_texture_class() -> type:
    """The texture class, for the active variant."""

    class AtlasTexture(mi.Texture):
        """The face's tile of the atlas, repeated, times the vertices' tint."""

        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.image = self.tiles = None

        def load(self, atlas: Atlas) -> None:
            """Give the texture its atlas."""
            self.image = mi.Texture2f(
                mi.TensorXf(atlas.image),
                wrap_mode=dr.WrapMode.Clamp,
                filter_mode=dr.FilterMode.Linear,
            )
            self.tiles = mi.Float(atlas.tiles.ravel())

        def eval(self, si, active=True):
            number = mi.UInt32(si.shape.eval_attribute_1("face_material", si, active))
            tint = si.shape.eval_attribute_3("vertex_tint", si, active)
            tile = dr.gather(mi.Vector4f, self.tiles, number, active)
            repeat = si.uv - dr.floor(si.uv)
            at = mi.Point2f(tile.x + repeat.x * tile.z, tile.y + repeat.y * tile.w)
            colour = self.image.eval(at, active)
            return mi.Color3f(colour[0], colour[1], colour[2]) * mi.Color3f(tint)

        def mean(self):
            return mi.Float(0.5)

        def is_spatially_varying(self):
            return True

    mi.register_texture("synthdepth_atlas", AtlasTexture)
    return AtlasTexture


def atlas_texture(atlas: Atlas) -> "mi.Texture":
    """A texture that shows an atlas."""
    atlas_texture_class()
    texture = mi.load_dict({"type": "synthdepth_atlas"})
    texture.load(atlas)
    return texture
