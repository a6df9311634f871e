"""An environment on the GPU: its texture and its light table, made once and kept as long as the `Environment` lives."""

from __future__ import annotations

import dataclasses
import weakref

import moderngl

from brdf.errors import UserError

from .environment import Environment
from .light_table import light_table


@dataclasses.dataclass(frozen=True)
class Lighting:
    """What the shaders read of an environment.

    - `radiance`: the picture, for the sampler of `glsl/environment.glsl`.
    - `buffers`: pdf, cells, cumulative and guide, in the order of their bindings in `glsl/light_table.glsl`.
    - `size`: of the light table in cells, width first.
    - `guide_shift`: how many lower bits of 32 do not index the guide.
    """

    radiance: moderngl.Texture
    buffers: tuple[moderngl.Buffer, ...]
    size: tuple[int, int]
    guide_shift: int


# A table takes longer than a frame: pictures that differ in their material alone share it.
_kept: weakref.WeakKeyDictionary[Environment, Lighting] = weakref.WeakKeyDictionary()


def lighting(ctx: moderngl.Context, environment: Environment) -> Lighting:
    """The environment on the GPU of this process's context, from an earlier call if there was one.

    Raises `UserError` when its picture is larger than the device's textures.
    """
    if environment not in _kept:
        _kept[environment] = _upload(ctx, environment)
    return _kept[environment]


def _upload(ctx: moderngl.Context, environment: Environment) -> Lighting:
    pixels = environment.pixels
    height, width = pixels.shape[:2]
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UserError(f"`{environment.name}` is larger than this device's {limit} texels a side. Resize it.")
    radiance = ctx.texture((width, height), 3, pixels.tobytes(), dtype="f4")
    radiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
    radiance.repeat_x, radiance.repeat_y = True, False
    table = light_table(pixels)
    buffers = tuple(ctx.buffer(one.tobytes()) for one in (table.pdf, table.cells, table.cumulative, table.guide))
    size = (table.pdf.shape[1], table.pdf.shape[0])
    return Lighting(radiance, buffers, size, 32 - (len(table.guide).bit_length() - 1))
