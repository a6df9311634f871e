"""Environments blurred by round kernels, as cube maps: what the round lobes of materials look up.

The brightest texels (`lamps`) are weighed by the kernel itself. The rest is blurred by a product in spherical harmonics
(`harmonics`), exact and cheap, or, by a narrow kernel, which would need too many of them, sampled from a cube map. A
kernel that is narrower than a texel is the environment's own cube map.
"""

from __future__ import annotations

import math

import moderngl
import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .harmonics import analyse, synthesise
from .kept_tables import kept
from .kernel import COSINE, WIDTH_MIN, WIDTH_SAMPLED, Kernel
from .lamps import find_lamps
from .lighting import UNIT, upload_radiance
from .program import Programs, set_uniforms

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
# Wider pictures are averaged for the harmonics, which cannot tell.
_WIDTH_MAX = 1024
# Rows of a picture per degree: with fewer, its texels, which count as points, are told from an even light.
_ROWS_PER_DEGREE = 4
# Names the way in which pictures are blurred: another one must not find what this one kept.
_KIND = "blur-4"


def blur_name(environment: Environment, kernel: Kernel) -> str:
    """The resource of the environment blurred by a kernel."""
    if _is_sharp(kernel):
        return "sky_cube"
    return f"blur[{environment.digest[:8]} {kernel.name}]"


def is_sampled(kernel: Kernel) -> bool:
    """Whether a blur by this kernel reads `DimCube`."""
    return kernel.power > 0 and WIDTH_MIN <= kernel.width < WIDTH_SAMPLED


def _is_sharp(kernel: Kernel) -> bool:
    return kernel.power > 0 and kernel.width < WIDTH_MIN


def make_sky_cube(ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture) -> moderngl.TextureCube:
    """The environment's own cube map with all its levels."""
    return _levels(ctx, programs, radiance, math.inf)


def make_dim_cube(
    ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture, environment: Environment
) -> moderngl.TextureCube:
    """The environment's cube map without its lamps, which narrow kernels are sampled from."""
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
    points = _POINTS if is_sampled(kernel) else 0
    defines = {"POINTS": str(points), "TWICE_POWER": str(_twice_power(kernel))}
    program = programs.compute("pass/blur.comp", defines, {})
    cube = _empty(ctx, kernel.texels)
    lamps = find_lamps(environment)
    count = len(lamps.directions)
    pairs = np.zeros((max(count, 1), 2, 4), np.float32)
    pairs[:count, 0, :3], pairs[:count, 1, :3] = lamps.directions, lamps.fluxes
    buffers = [ctx.buffer(pairs.tobytes())]
    buffers[0].bind_to_storage_buffer(1)
    if points:
        assert dim_cube is not None
        buffers.append(ctx.buffer(_points(kernel, dim_cube.size[0]).tobytes()))
        buffers[1].bind_to_storage_buffer(0)
        dim_cube.use(UNIT)
    else:
        picture = upload_radiance(ctx, Environment(blurred_pixels(environment, kernel), environment.name))
        picture.use(UNIT)
    height = float(kernel.values(np.zeros(1))[0])
    values = {"dim_cube": UNIT, "radiance": UNIT, "lamp_count": count, "kernel_width": kernel.width}
    set_uniforms(program, values | {"kernel_height": height})
    _run(ctx, program, cube)
    return cube


def _twice_power(kernel: Kernel) -> int:
    """As `glsl/pass/blur.comp` has it."""
    if kernel.power == 0:
        return -1 if kernel == COSINE else -2
    return 0 if math.isinf(kernel.power) else round(2 * kernel.power)


def blurred_pixels(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    """The environment without its lamps, blurred by a kernel that is not narrow, as a latitude-longitude picture.

    **Returns:** shape (h, 2 h, 3).
    """

    def make() -> dict[str, NDArray[np.generic]]:
        dim = np.minimum(environment.pixels, np.float32(find_lamps(environment).limit))
        pixels = _resampled(dim, _ROWS_PER_DEGREE * kernel.degree)
        degree = min(kernel.degree, len(pixels))
        coefficients = analyse(pixels, degree) * kernel.coefficients()[: degree + 1, None]
        height = max(2 * kernel.texels, degree)
        return {"pixels": np.maximum(synthesise(coefficients, height), 0)}

    ingredients = (environment.digest.encode(), kernel.name.encode())
    return np.asarray(kept(_KIND, ingredients, make)["pixels"], np.float32)


def _resampled(pixels: NDArray[np.float32], rows: int) -> NDArray[np.float32]:
    """The picture no wider than the limit, and below it with this many rows or more."""
    height, width = pixels.shape[:2]
    if width > _WIDTH_MAX:
        return _reduced(pixels, -(-width // _WIDTH_MAX))
    times = min(-(-rows // height), _WIDTH_MAX // width)
    if times <= 1:
        return pixels
    padded = np.pad(pixels, ((1, 1), (0, 0), (0, 0)), mode="edge")
    taller = _between(padded, times)
    return _between(np.pad(taller, ((0, 0), (1, 1), (0, 0)), mode="wrap").swapaxes(0, 1), times).swapaxes(0, 1)


def _between(rows: NDArray[np.float32], times: int) -> NDArray[np.float32]:
    """As many rows in place of each but the first and the last, interpolated linearly as a texture's are."""
    place = (np.arange((len(rows) - 2) * times) + 0.5) / times + 0.5
    before = place.astype(int)
    part = (place - before).astype(np.float32)[:, None, None]
    return ((1 - part) * rows[before] + part * rows[before + 1]).astype(np.float32)


def _reduced(pixels: NDArray[np.float32], block: int) -> NDArray[np.float32]:
    """The mean over square blocks, by solid angle."""
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    padding = (0, -height % block), (0, -width % block)
    padded = np.pad(pixels, (*padding, (0, 0)), mode="edge")
    weight = np.pad(edges[:-1] - edges[1:], padding[0], mode="edge").astype(np.float32).reshape(-1, block, 1)
    across = padded.reshape(len(padded), -1, block, 3).mean(axis=2)
    sums = (across.reshape(len(weight), block, -1) * weight).sum(axis=1) / weight.sum(axis=1)
    return sums.reshape(len(weight), -1, 3).astype(np.float32)


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
