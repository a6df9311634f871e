"""Blurred environments: time and error of ours against filtered importance sampling of the same cubes."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..blurs import make_blur, make_sky_cube
from ..context import Device, device
from ..environment import Environment, load_environment
from ..kernel import COSINE, Kernel, nearest_kernel
from ..lighting import UNIT, upload_radiance
from ..program import Programs, programs, set_uniforms
from .filtered import cosine_points, filter_cube, kernel_points

# Of GGX; those of roughness 0.5 and more.
_ROUGHNESS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
_SAMPLES = 64
_DIRECTIONS, _SEED = 50, 20

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class TableRow:
    """A blur of an environment: milliseconds and relative RMS error of ours and of the samples'."""

    kernel: str
    texels: int
    ours_ms: float
    theirs_ms: float
    ours_error: float
    theirs_error: float


@dataclasses.dataclass(frozen=True)
class Tables:
    """All blurs of an environment.

    - `cube_ms`: of the environment's own cube map, which the samples are read from; in none of the rows.
    - `ours_ms`, `theirs_ms`, `ratio`: of all blurs together, and the median of ours over theirs.
    """

    environment: str
    rows: tuple[TableRow, ...]
    cube_ms: float
    ours_ms: float
    theirs_ms: float
    ratio: float


def measure_tables(names: Sequence[str], rounds: int, say: Callable[[str], None]) -> list[Tables]:
    """Irradiance and the blurs of GGX of roughness 0.5 and more, built by turns; medians of `rounds`.

    Every round has an environment that was never seen: what ours finds out about it for all blurs counts as the
    first one's, irradiance.
    """
    kernels = [COSINE, *dict.fromkeys(nearest_kernel(2.0, r**2) for r in _ROUGHNESS)]
    found = []
    for name in names:
        say(f"tables: {name}")
        found.append(_tables(load_environment(name), kernels, rounds))
    return found


def _tables(light: Environment, kernels: Sequence[Kernel], rounds: int) -> Tables:
    gpu, kept = device(), programs()
    radiance = upload_radiance(gpu.ctx, light)
    times: list[NDArray[np.float64]] = []
    cube_times = []
    cubes: list[list[moderngl.TextureCube]] = []
    with _without_kept_tables():
        for number in range(rounds + 1):
            fresh = dataclasses.replace(light)
            assert fresh.digest  # by which every pass knows it, whatever it does with it
            milliseconds, sky_cube = _timed(gpu, lambda: make_sky_cube(gpu.ctx, kept, radiance))
            pairs = [
                [
                    _timed(gpu, lambda kernel=kernel, one=fresh: make_blur(gpu.ctx, kept, one, kernel, None)),
                    _timed(gpu, lambda kernel=kernel, one=sky_cube: _sampled(gpu.ctx, kept, kernel, one)),
                ]
                for kernel in kernels
            ]
            if number:  # the first compiles
                cube_times.append(milliseconds)
                times.append(np.array([[one[0] for one in pair] for pair in pairs]))
            cubes = [[one[1] for one in pair] for pair in pairs]
    directions = np.random.default_rng(_SEED).normal(size=(_DIRECTIONS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    medians = np.median(times, axis=0)
    rows = []
    for kernel, pair, (ours, theirs) in zip(kernels, cubes, medians, strict=True):
        exact = direct_sum(light, kernel, directions)
        errors = [_relative(look_up(gpu.ctx, kept, cube, directions), exact) for cube in pair]
        rows.append(TableRow(kernel.name, kernel.texels, float(ours), float(theirs), *errors))
    sums = np.sum(times, axis=1)
    ours, theirs = np.median(sums, axis=0)
    ratio = float(np.median(sums[:, 0] / sums[:, 1]))
    return Tables(light.name, tuple(rows), statistics.median(cube_times), float(ours), float(theirs), ratio)


def _sampled(
    ctx: moderngl.Context, kept: Programs, kernel: Kernel, sky_cube: moderngl.TextureCube
) -> moderngl.TextureCube:
    texels = sky_cube.size[0]
    is_cosine = kernel == COSINE
    points = cosine_points(_SAMPLES, texels, 0.0) if is_cosine else kernel_points(kernel, _SAMPLES, texels, 0.0)
    cube = ctx.texture_cube((kernel.texels, kernel.texels), 4, dtype="f4")
    cube.filter = (moderngl.LINEAR, moderngl.LINEAR)
    filter_cube(ctx, kept, sky_cube, points, False, cube)
    return cube


def _timed(gpu: Device, make: Callable[[], moderngl.TextureCube]) -> tuple[float, moderngl.TextureCube]:
    gpu.ctx.finish()
    began = time.perf_counter()
    cube = make()
    gpu.ctx.finish()
    return 1e3 * (time.perf_counter() - began), cube


@contextlib.contextmanager
def _without_kept_tables() -> Iterator[None]:
    """Inside, no table is read from disk or written to it: the cache's folder lies below a file."""
    before = os.environ.get("BRDF_CACHE_DIR")
    with tempfile.NamedTemporaryFile() as file:
        os.environ["BRDF_CACHE_DIR"] = os.path.join(file.name, "none")
        try:
            yield
        finally:
            if before is None:
                del os.environ["BRDF_CACHE_DIR"]
            else:
                os.environ["BRDF_CACHE_DIR"] = before


def direct_sum(light: Environment, kernel: Kernel, directions: Array) -> Array:
    """The blur in float64, a texel at a time as a point with its solid angle: shape (n, 3).

    The kernel is divided by its own sum over a grid, as fine, so that a constant stays what it is.
    """
    height, width = light.pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    polar, azimuth = np.pi * (np.arange(height) + 0.5) / height, 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    solid_angle = np.repeat((edges[:-1] - edges[1:]) * (2 * np.pi / width), width)
    sine = np.sin(polar)[:, None]
    texels = np.stack(
        np.broadcast_arrays(sine * np.sin(azimuth), np.cos(polar)[:, None], -sine * np.cos(azimuth)), axis=-1
    ).reshape(-1, 3)
    radiance = light.pixels.reshape(-1, 3).astype(np.float64)
    found = np.empty((len(directions), 3))
    for i, direction in enumerate(directions):
        cosine = texels @ direction
        weight = kernel.values((1 - cosine) / np.maximum(1 + cosine, 1e-12)) * solid_angle
        found[i] = weight @ radiance / weight.sum()
    return found


def look_up(ctx: moderngl.Context, kept: Programs, cube: moderngl.TextureCube, directions: Array) -> Array:
    """What a cube map holds in these directions, shape (n, 3)."""
    padded = np.pad(directions, ((0, 0), (0, 1))).astype(np.float32)
    first, second = ctx.buffer(padded.tobytes()), ctx.buffer(reserve=padded.nbytes)
    first.bind_to_storage_buffer(0)
    second.bind_to_storage_buffer(1)
    cube.use(UNIT)
    program = kept.compute("bench/look_up.comp", {}, {})
    set_uniforms(program, {"cube": UNIT})
    program.run(math.ceil(len(padded) / 64))
    ctx.memory_barrier()
    return np.frombuffer(second.read(), np.float32).reshape(-1, 4)[:, :3].astype(np.float64)


def _relative(found: Array, exact: Array) -> float:
    return float(np.sqrt(((found - exact) ** 2).mean() / (exact**2).mean()))
