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

    environment: str
    kernel: str
    texels: int
    ours_ms: float
    theirs_ms: float
    ours_error: float
    theirs_error: float


def measure_tables(names: Sequence[str], rounds: int, say: Callable[[str], None]) -> list[TableRow]:
    """Irradiance and the blurs of GGX of roughness 0.5 and more, built by turns; medians of `rounds`."""
    rows = []
    kernels = [COSINE, *dict.fromkeys(nearest_kernel(2.0, r**2) for r in _ROUGHNESS)]
    for light in [load_environment(name) for name in names]:
        for kernel in kernels:
            say(f"tables: {light.name}, {kernel.name}")
            rows.append(_row(light, kernel, rounds))
    return rows


def _row(light: Environment, kernel: Kernel, rounds: int) -> TableRow:
    gpu, kept = device(), programs()
    sky_cube = make_sky_cube(gpu.ctx, kept, upload_radiance(gpu.ctx, light))
    makers = {
        "ours": lambda: make_blur(gpu.ctx, kept, light, kernel, None),
        "theirs": lambda: _sampled(gpu.ctx, kept, kernel, sky_cube),
    }
    times: dict[str, list[float]] = {name: [] for name in makers}
    cubes: dict[str, moderngl.TextureCube] = {}
    with _without_kept_tables():
        for number in range(rounds + 1):
            for name, make in makers.items():
                milliseconds, cubes[name] = _timed(gpu, make)
                if number:
                    times[name].append(milliseconds)
    directions = np.random.default_rng(_SEED).normal(size=(_DIRECTIONS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    exact = direct_sum(light, kernel, directions)
    error = {name: _relative(look_up(gpu.ctx, kept, cube, directions), exact) for name, cube in cubes.items()}
    return TableRow(
        light.name,
        kernel.name,
        kernel.texels,
        statistics.median(times["ours"]),
        statistics.median(times["theirs"]),
        error["ours"],
        error["theirs"],
    )


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
