"""Environments blurred by round kernels, as cube maps: what the round lobes of materials look up.

A wide kernel is a product in spherical harmonics (`harmonics`), exact and cheap; a narrow one, which would need too
many of them, is sampled from the environment's own cube map; one that is narrower than a texel is that cube map itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import moderngl
import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .harmonics import analyse, synthesise
from .kept_tables import kept
from .kernel import WIDTH_MIN, WIDTH_SAMPLED, Kernel
from .lighting import UNIT, upload_radiance
from .program import Programs, set_uniforms

_GROUP = 8  # local_size_x and local_size_y in the compute shaders
# Edges of the environment's own cube, which has the texels of its picture at the horizon.
_TEXELS_MIN, _TEXELS_MAX = 16, 512
# Points of a texel of that cube, a side: a sun of one texel must not slip through.
_SIDE = 3
# Points of a narrow kernel, an even number.
_POINTS = 64
_GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))
# Wider pictures are averaged for the harmonics, which cannot tell.
_WIDTH_MAX = 1024
# Rows of a picture per degree: with fewer, its texels, which count as points, are told from an even light.
_ROWS_PER_DEGREE = 4
# Names the way in which pictures are blurred: another one must not find what this one kept.
_KIND = "blur-3"


def needs_sky_cube(kernels: Iterable[Kernel]) -> bool:
    """Whether any of the kernels is sampled from the environment's cube, or is that cube."""
    return any(_is_narrow(kernel) for kernel in kernels)


def blur_name(environment: Environment, kernel: Kernel) -> str:
    """The resource of the environment blurred by a kernel."""
    return (
        "sky_cube"
        if _is_narrow(kernel) and kernel.width < WIDTH_MIN
        else f"blur[{environment.digest[:8]} {kernel.name}]"
    )


def _is_narrow(kernel: Kernel) -> bool:
    return kernel.power > 0 and kernel.width < WIDTH_SAMPLED


def make_sky_cube(ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture) -> moderngl.TextureCube:
    """The environment's own cube map with all its levels."""
    texels = int(np.clip(2 ** math.ceil(math.log2(radiance.width / 4)), _TEXELS_MIN, _TEXELS_MAX))
    cube = _cube(ctx, programs, radiance, texels, _SIDE)
    cube.build_mipmaps()
    cube.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    return cube


def make_blur(
    ctx: moderngl.Context,
    programs: Programs,
    environment: Environment,
    kernel: Kernel,
    sky_cube: moderngl.TextureCube | None,
) -> moderngl.TextureCube:
    """The environment blurred by a kernel; `sky_cube` is read for a narrow one."""
    if not _is_narrow(kernel):
        picture = Environment(blurred_pixels(environment, kernel), environment.name)
        return _cube(ctx, programs, upload_radiance(ctx, picture), kernel.texels, 1)
    assert sky_cube is not None
    program = programs.compute("pass/blur.comp", {"POINTS": str(_POINTS)}, {})
    cube = _empty(ctx, kernel.texels)
    points = ctx.buffer(_points(kernel, sky_cube.size[0]).tobytes())
    points.bind_to_storage_buffer(0)
    sky_cube.use(UNIT)
    set_uniforms(program, {"sky_cube": UNIT})
    _run(ctx, program, cube)
    return cube


def blurred_pixels(environment: Environment, kernel: Kernel) -> NDArray[np.float32]:
    """The environment blurred by a kernel that is not narrow, as a latitude-longitude picture: shape (h, 2 h, 3)."""

    def make() -> dict[str, NDArray[np.generic]]:
        pixels = _resampled(environment.pixels, _ROWS_PER_DEGREE * kernel.degree)
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


def _cube(
    ctx: moderngl.Context, programs: Programs, radiance: moderngl.Texture, texels: int, side: int
) -> moderngl.TextureCube:
    program = programs.compute("pass/sky_cube.comp", {"SIDE": str(side)}, {})
    cube = _empty(ctx, texels)
    radiance.use(UNIT)
    set_uniforms(program, {"radiance": UNIT})
    _run(ctx, program, cube)
    return cube


def _empty(ctx: moderngl.Context, texels: int) -> moderngl.TextureCube:
    cube = ctx.texture_cube((texels, texels), 4, dtype="f4")
    cube.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return cube


def _run(ctx: moderngl.Context, program: moderngl.ComputeShader, cube: moderngl.TextureCube) -> None:
    cube.bind_to_image(0, read=False, write=True)
    groups = -(-cube.size[0] // _GROUP)
    program.run(groups, groups, 6)
    ctx.memory_barrier()
