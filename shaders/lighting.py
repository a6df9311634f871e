"""An environment on the GPU: its texture, and what directions are chosen from by their light."""

from __future__ import annotations

import dataclasses

import moderngl
import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .environment import Environment
from .light_table import light_table

# The texture unit of an environment's picture.
UNIT = 0


@dataclasses.dataclass(frozen=True)
class Light:
    """An environment with its light table, as `glsl/light_table.glsl` reads it.

    - `radiance`: the picture, for the sampler of `glsl/environment.glsl`; its alpha is the table's density.
    - `cells`, `slots`: the table's list and its slots, for bindings 0 and 1.
    - `size`: of the picture in texels, width first.
    - `block`: texels a side of the list's blocks.
    - `is_even`: whether drawing directions by their light is of no use.
    - `bytes_uploaded`: of the picture and the table.
    """

    radiance: moderngl.Texture
    cells: moderngl.Buffer
    slots: moderngl.Buffer
    size: tuple[int, int]
    block: int
    is_even: bool
    bytes_uploaded: int

    @property
    def techniques(self) -> int:
        """How many directions each point draws: one that the material proposes and, if it is of use, one to a light."""
        return 1 if self.is_even else 2


def upload_radiance(ctx: moderngl.Context, environment: Environment) -> moderngl.Texture:
    """The picture alone, for the sampler of `glsl/environment.glsl`.

    Raises `UserError` when it is larger than the device's textures.
    """
    return _upload(ctx, environment, environment.pixels)


def upload_light(ctx: moderngl.Context, environment: Environment) -> Light:
    """The picture with its light table.

    Raises `UserError` when it is larger than the device's textures.
    """
    table = light_table(environment.pixels)
    pixels = np.concatenate([environment.pixels, table.density[..., None]], axis=-1)
    return Light(
        radiance=_upload(ctx, environment, pixels),
        cells=ctx.buffer(table.cells.tobytes()),
        slots=ctx.buffer(table.slots.tobytes()),
        size=(pixels.shape[1], pixels.shape[0]),
        block=table.block,
        is_even=table.is_even,
        bytes_uploaded=pixels.nbytes + table.cells.nbytes + table.slots.nbytes,
    )


def _upload(ctx: moderngl.Context, environment: Environment, pixels: NDArray[np.float32]) -> moderngl.Texture:
    height, width, components = pixels.shape
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    if max(width, height) > limit:
        raise UserError(f"`{environment.name}` is larger than this device's {limit} texels a side. Resize it.")
    radiance = ctx.texture((width, height), components, np.ascontiguousarray(pixels).tobytes(), dtype="f4")
    radiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
    radiance.repeat_x, radiance.repeat_y = True, False
    return radiance
