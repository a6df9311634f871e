"""An environment on the GPU: its texture and its light table."""

from __future__ import annotations

import dataclasses

import moderngl

from brdf.errors import UserError

from .environment import Environment
from .light_table import light_table

# The texture unit of an environment's picture.
UNIT = 0


@dataclasses.dataclass(frozen=True)
class LightBuffers:
    """The light table as shaders read it.

    - `buffers`: pdf, cells, cumulative and guide, in the order of their bindings in `glsl/light_table.glsl`.
    - `size`: in cells, width first.
    - `guide_shift`: how many lower bits of 32 do not index the guide.
    - `bytes_uploaded`: of all buffers.
    """

    buffers: tuple[moderngl.Buffer, ...]
    size: tuple[int, int]
    guide_shift: int
    bytes_uploaded: int


def upload_radiance(ctx: moderngl.Context, environment: Environment) -> moderngl.Texture:
    """The picture, for the sampler of `glsl/environment.glsl`.

    Raises `UserError` when it is larger than the device's textures.
    """
    height, width = environment.pixels.shape[:2]
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UserError(f"`{environment.name}` is larger than this device's {limit} texels a side. Resize it.")
    radiance = ctx.texture((width, height), 3, environment.pixels.tobytes(), dtype="f4")
    radiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
    radiance.repeat_x, radiance.repeat_y = True, False
    return radiance


def upload_light_table(ctx: moderngl.Context, environment: Environment) -> LightBuffers:
    """The table that `glsl/light_table.glsl` samples."""
    table = light_table(environment.pixels)
    arrays = (table.pdf, table.cells, table.cumulative, table.guide)
    size = (table.pdf.shape[1], table.pdf.shape[0])
    buffers = tuple(ctx.buffer(one.tobytes()) for one in arrays)
    return LightBuffers(buffers, size, 32 - (len(table.guide).bit_length() - 1), sum(one.nbytes for one in arrays))
