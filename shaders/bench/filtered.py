"""A peer: cube maps by filtered importance sampling on the device, from an environment's own cube map.

- Colbert, Krivanek 2007, "GPU-Based Importance Sampling", GPU Gems 3, chapter 20: the level of a sample.

A sample is read at the level whose texels are as large as its share of the sphere, or `raised` by some levels: with
many samples of a small sun that is more exact, since the squares that texels are do not show; with few it is not.
"""

from __future__ import annotations

import math

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..kernel import Kernel
from ..lighting import UNIT
from ..program import Programs, set_uniforms

_GROUP = 8  # local_size_x and local_size_y in the shader
_ALPHA_MIN = 1e-3

Array = NDArray[np.float64]


def hammersley(count: int) -> tuple[Array, Array]:
    """Points of [0, 1)^2: the second coordinates are the bits of the index mirrored (van der Corput)."""
    index = np.arange(count)
    bits = max((count - 1).bit_length(), 1)
    mirrored = sum(((index >> i) & 1) << (bits - 1 - i) for i in range(bits))
    return (index + 0.5) / count, np.asarray(mirrored, np.float64) / 2**bits


def cosine_points(count: int, texels: int, raised: float) -> NDArray[np.float32]:
    """Directions about +z with density cos / pi, and the levels at which a cube of `texels` a side is read."""
    u, v = hammersley(count)
    cosine = np.sqrt(1 - u)
    return _points(cosine, v, cosine / np.pi, len(v), texels, raised)


def ggx_points(alpha: float, count: int, texels: int, raised: float) -> NDArray[np.float32]:
    """Mirror directions of facets seen along the normal, drawn from GGX; those below the horizon left out."""
    u, v = hammersley(count)
    a2 = max(alpha, _ALPHA_MIN) ** 2
    cos2 = (1 - u) / (1 + (a2 - 1) * u)
    density = a2 / (np.pi * (1 + (a2 - 1) * cos2) ** 2)
    above = 2 * cos2 - 1 > 0
    return _points((2 * cos2 - 1)[above], v[above], density[above] / 4, count, texels, raised)


def kernel_points(kernel: Kernel, count: int, texels: int, raised: float) -> NDArray[np.float32]:
    """Directions about +z with exactly the density of a round kernel, by inverting its sum over angles."""
    u, v = hammersley(count)
    theta = np.pi * (np.arange(8193) / 8192) ** 4
    value = kernel.values(np.tan(0.5 * theta) ** 2)
    shell = 0.5 * ((value * np.sin(theta))[1:] + (value * np.sin(theta))[:-1]) * np.diff(theta)
    before = np.concatenate([[0.0], np.cumsum(shell)])
    at = np.interp(u, before / before[-1], theta)
    return _points(np.cos(at), v, np.interp(at, theta, value), count, texels, raised)


def _points(cosine: Array, v: Array, density: Array, drawn: int, texels: int, raised: float) -> NDArray[np.float32]:
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0.0))
    share = 1 / (drawn * np.maximum(density, 1e-30))
    level = np.clip(0.5 * np.log2(share * 6 * texels**2 / (4 * np.pi)) + raised, 0, math.log2(texels))
    phi = 2 * np.pi * v
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine, level], axis=-1).astype(np.float32)


def filter_cube(
    ctx: moderngl.Context,
    programs: Programs,
    sky_cube: moderngl.TextureCube,
    points: NDArray[np.float32],
    is_weighted: bool,
    cube: moderngl.TextureCube,
    level: int = 0,
) -> None:
    """Fills a level of a cube map with the mean of `sky_cube` at the points, weighted by their cosine or not."""
    defines = {"POINTS": str(len(points)), "WEIGHTED": str(int(is_weighted))}
    program = programs.compute("bench/filtered.comp", defines, {})
    buffer = ctx.buffer(points.tobytes())
    buffer.bind_to_storage_buffer(0)
    sky_cube.use(UNIT)
    set_uniforms(program, {"sky_cube": UNIT})
    cube.bind_to_image(0, read=False, write=True, level=level)
    groups = -(-(cube.size[0] >> level) // _GROUP)
    program.run(groups, groups, 6)
    ctx.memory_barrier()
