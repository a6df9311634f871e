"""An environment on the GPU: its texture and its light table, made once and kept as long as the `Environment` lives."""

from __future__ import annotations

import dataclasses
import weakref

import moderngl
import numpy as np

from brdf.errors import UserError

from .environment import Environment
from .light_table import light_table


@dataclasses.dataclass(frozen=True)
class Lighting:
    """What the shaders read of an environment.

    - `radiance`: the picture, for the sampler of `glsl/environment.glsl`; its alpha is the light table's density.
    - `cells`: the light table's list, for binding 0 of `glsl/light_table.glsl`.
    - `size`: of the picture in texels, width first.
    - `shift`: how many lower bits of 32 do not index the list.
    - `block`: texels a side of the list's blocks.
    - `is_even`: whether drawing directions by their light is of no use.
    """

    radiance: moderngl.Texture
    cells: moderngl.Buffer
    size: tuple[int, int]
    shift: int
    block: int
    is_even: bool


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
    table = light_table(pixels)
    light = np.concatenate([pixels, table.density[..., None]], axis=-1)
    radiance = ctx.texture((width, height), 4, np.ascontiguousarray(light, np.float32).tobytes(), dtype="f4")
    radiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
    radiance.repeat_x, radiance.repeat_y = True, False
    shift = 32 - (len(table.cells).bit_length() - 1)
    return Lighting(radiance, ctx.buffer(table.cells.tobytes()), (width, height), shift, table.block, table.is_even)
