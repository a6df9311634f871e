"""Environments blurred by round kernels, as cube maps: what the round lobes of materials look up.

Wide kernels are a matter of the processor (`wide_blurs`), exact and cheap. Narrow ones are sampled on the device from
the environment's cube map, but for the brightest texels (`lamps`), which are weighed by the kernel itself. A kernel
that is narrower than a texel is the environment's own cube map.
"""

from __future__ import annotations

import math

import moderngl
import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .kernel import WIDTH_MIN, WIDTH_SAMPLED, Kernel
from .lamps import find_lamps
from .lighting import UNIT
from .program import Programs, set_uniforms
from .wide_blurs import blurred_texels

_GROUP = 8  # local_size_x and local_size_y in the compute shaders
# Edges of the environment's own cube, which has the texels of its picture at the horizon.
_TEXELS_MIN, _TEXELS_MAX = 16, 512
# Points of a texel of that cube, a side: a sun of one texel must not slip through.
_SIDE = 3
# Points of a narrow kernel, an even number.
_POINTS = 64
# Above all radiance.
_RADIANCE_MAX = 3e38
_GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def blur_name(environment: Environment, kernel: Kernel) -> str:
    """The resource of the environment blurred by a kernel that is not sharp."""
    return f"blur[{environment.digest[:8]} {kernel.name}]"


def dim_name(environment: Environment) -> str:
    """The resource of the environment's cube map without its lamps."""
    return f"dim_cube[{environment.digest[:8]}]"


def is_sampled(kernel: Kernel) -> bool:
    """Whether a blur by this kernel reads the cube map without lamps."""
    return kernel.power > 0 and WIDTH_MIN <= kernel.width < WIDTH_SAMPLED


def is_sharp(kernel: Kernel) -> bool:
    """Whether a kernel is narrower than a texel: its blur is the environment's own cube map."""
    return kernel.power > 0 and kernel.width < WIDTH_MIN


def make_sky_cube(ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture) -> moderngl.TextureCube:
    """The environment's own cube map with all its levels."""
    return _levels(ctx, programs, radiance, math.inf)


def make_dim_cube(
    ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture, environment: Environment
) -> moderngl.TextureCube:
    """An environment's cube map without its lamps, which narrow kernels are sampled from; `radiance` is its picture."""
    return _levels(ctx, programs, radiance, find_lamps(environment).limit)


def _levels(
    ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture, limit: float
) -> moderngl.TextureCube:
    texels = int(np.clip(2 ** math.ceil(math.log2(radiance.width / 4)), _TEXELS_MIN, _TEXELS_MAX))
    program = programs.compute("pass/sky_cube.comp", {"SIDE": str(_SIDE)}, {})
    cube = _empty(ctx, texels)
    radiance.use(UNIT)
    set_uniforms(program, {"radiance": UNIT, "limit": min(limit, _RADIANCE_MAX)})
    _run(ctx, program, cube)
    cube.build_mipmaps()
    cube.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    return cube


def make_blur(
    ctx: moderngl.Context,
    programs: Programs,
    environment: Environment,
    kernel: Kernel,
    dim_cube: moderngl.TextureCube | None,
) -> moderngl.TextureCube:
    """The environment blurred by a kernel; `dim_cube` is read if it is sampled."""
    if not is_sampled(kernel):
        cube = _empty(ctx, kernel.texels)
        for face, values in enumerate(blurred_texels(environment, kernel)):
            cube.write(face, values.tobytes())
        return cube
    assert dim_cube is not None
    defines = {"POINTS": str(_POINTS), "TWICE_POWER": str(_twice_power(kernel))}
    program = programs.compute("pass/blur.comp", defines, {})
    cube = _empty(ctx, kernel.texels)
    lamps = find_lamps(environment)
    count = len(lamps.directions)
    pairs = np.zeros((max(count, 1), 2, 4), np.float32)
    pairs[:count, 0, :3], pairs[:count, 1, :3] = lamps.directions, lamps.fluxes
    buffers = [ctx.buffer(one.tobytes()) for one in (_points(kernel, dim_cube.size[0]), pairs)]
    for binding, buffer in enumerate(buffers):
        buffer.bind_to_storage_buffer(binding)
    dim_cube.use(UNIT)
    height = float(kernel.values(np.zeros(1))[0])
    values = {"dim_cube": UNIT, "lamp_count": count, "kernel_width": kernel.width, "kernel_height": height}
    set_uniforms(program, values)
    _run(ctx, program, cube)
    return cube


def _twice_power(kernel: Kernel) -> int:
    """As `glsl/pass/blur.comp` has it."""
    return 0 if math.isinf(kernel.power) else round(2 * kernel.power)


def _points(kernel: Kernel, texels: int) -> NDArray[np.float32]:
    """Points about +z as dense as the kernel is high, with the level of a cube map for each: on a spiral, two by two on
    opposite sides, so that their mean is the middle."""
    theta = np.pi * (np.arange(8193) / 8192) ** 4
    value = kernel.values(np.tan(0.5 * theta) ** 2)
    shell = 0.5 * ((value * np.sin(theta))[1:] + (value * np.sin(theta))[:-1]) * np.diff(theta)
    before = np.concatenate([[0.0], np.cumsum(shell)])
    pair, side = np.divmod(np.arange(_POINTS), 2)
    at = np.interp((pair + 0.5) / (_POINTS // 2), before / before[-1], theta)
    density = np.interp(at, theta, value)
    share, texel = 1 / (_POINTS * density), 4 * np.pi / (6 * texels**2)
    level = np.clip(0.5 * np.log2(share / texel), 0, math.log2(texels))
    turn = _GOLDEN_ANGLE * pair + np.pi * side
    return np.stack([np.sin(at) * np.cos(turn), np.sin(at) * np.sin(turn), np.cos(at), level], axis=-1).astype(
        np.float32
    )


def _empty(ctx: moderngl.Context, texels: int) -> moderngl.TextureCube:
    cube = ctx.texture_cube((texels, texels), 4, dtype="f4")
    cube.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return cube


def _run(ctx: moderngl.Context, program: moderngl.ComputeShader, cube: moderngl.TextureCube) -> None:
    cube.bind_to_image(0, read=False, write=True)
    groups = -(-cube.size[0] // _GROUP)
    program.run(groups, groups, 6)
    ctx.memory_barrier()
