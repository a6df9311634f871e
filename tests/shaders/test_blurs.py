"""Blurred environments as cube maps. Oracles: closed forms of smooth pictures, and the exact blur of harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shaders import Environment
from shaders.blurs import is_sampled, is_sharp, make_blur, make_dim_cube, make_sky_cube
from shaders.context import device
from shaders.harmonics import analyse, synthesise
from shaders.kernel import COSINE, SATURATED, Kernel, nearest_kernel
from shaders.lighting import upload_radiance
from shaders.program import programs
from shaders.wide_blurs import blurred_pixels

pytestmark = pytest.mark.usefixtures("nothing_kept")

MIRROR = nearest_kernel(2.0, 0.002)
NARROW = nearest_kernel(2.0, 0.02)
WIDE = nearest_kernel(2.0, 0.5)

_LOOK_UP = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Directions { vec4 directions[]; };
layout(std430, binding = 1) buffer Found { vec4 found[]; };
uniform samplerCube cube;
uniform int count;
void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i < count) { found[i] = textureLod(cube, directions[i].xyz, 0.0); }
}
"""


def _directions(height: int, width: int) -> NDArray[np.float64]:
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height)[:, None] + 0.5) / height
    azimuth, polar = 2 * np.pi * (u - 0.5), np.pi * v
    sine = np.sin(polar)
    return np.stack([sine * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -sine * np.cos(azimuth)], axis=-1)


def _linear() -> Environment:
    """Each channel rises along one axis: a blur multiplies that rise by its coefficient of degree 1."""
    return Environment((2 + _directions(64, 128)).astype(np.float32), "linear")


def _look_up(environment: Environment, kernel: Kernel, w: NDArray[np.float64]) -> NDArray[np.float32]:
    """The environment blurred by a kernel, as shaders see it in some directions."""
    ctx = device().ctx
    radiance = upload_radiance(ctx, environment)
    if is_sharp(kernel):
        cube = make_sky_cube(ctx, programs(), radiance)
    else:
        dim = make_dim_cube(ctx, programs(), radiance, environment) if is_sampled(kernel) else None
        cube = make_blur(ctx, programs(), environment, kernel, dim)
    program = ctx.compute_shader(_LOOK_UP)
    buffers = [ctx.buffer(np.pad(w, ((0, 0), (0, 1))).astype(np.float32).tobytes()), ctx.buffer(reserve=16 * len(w))]
    for binding, buffer in enumerate(buffers):
        buffer.bind_to_storage_buffer(binding)
    cube.use(0)
    program["cube"], program["count"] = 0, len(w)
    program.run(-(-len(w) // 64))
    ctx.memory_barrier()
    return np.frombuffer(buffers[1].read(), np.float32).reshape(-1, 4)[:, :3]


@pytest.mark.gpu
@pytest.mark.parametrize("kernel", [MIRROR, NARROW, WIDE, COSINE, SATURATED], ids=lambda one: one.name)
def test_faces_are_oriented_and_joined_as_directions_are(kernel: Kernel):
    # The axes, the corners, the middles of edges and a path across one, where seams would be steps.
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    corners = np.array(
        [[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if abs(x) + abs(y) + abs(z) > 1]
    )
    turn = np.linspace(0.6, 0.97, 75)
    path = np.stack([np.cos(turn), 0.1 + 0 * turn, np.sin(turn)], axis=-1)
    w = np.concatenate([axes, corners, path])
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    found = _look_up(_linear(), kernel, w)
    slope = kernel.coefficients()[1]
    # Linear between texels, of which the widest has 16 a side: half their square over eight.
    np.testing.assert_allclose(found, 2 + slope * w, atol=6e-3)
    assert np.abs(np.diff(found[-75:] - slope * path, axis=0)).max() < 1.5e-3


@pytest.mark.gpu
def test_a_sampled_blur_is_that_of_harmonics():
    # The widest that is sampled, of a picture that has something to blur in its width.
    kernel = nearest_kernel(np.inf, 0.025)
    w = _directions(512, 1024)
    pixels = (1 + 0.5 * np.sin(20 * w) * np.cos(13 * w[..., [1, 2, 0]])).astype(np.float32)
    environment = Environment(pixels, "waves")
    places = np.random.default_rng(5).normal(size=(200, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    degree = 120
    exact = synthesise(analyse(pixels, degree) * kernel.coefficients()[: degree + 1, None], 2 * degree)
    plain = Environment(exact, "exact")
    expected = _look_up(plain, MIRROR, places)
    # Texels of the sampled cube are up to 0.016 wide: of waves of 20 to 33 per radian an eighth of the square is lost.
    np.testing.assert_allclose(_look_up(environment, kernel, places), expected, atol=0.018)
    assert np.abs(_look_up(environment, MIRROR, places) - expected).max() > 0.08


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 4), (3, 5), (7, 13), (16, 32), (600, 1200), (1023, 2047)])
@pytest.mark.parametrize("kernel", [COSINE, WIDE, nearest_kernel(2.0, 0.1)], ids=lambda one: one.name)
def test_an_even_light_stays_even_whatever_its_size(shape: tuple[int, int], kernel: Kernel):
    pixels = np.full((*shape, 3), 3.0, np.float32)
    # The rows' points tell at the poles, by the square of degree over rows.
    np.testing.assert_allclose(blurred_pixels(Environment(pixels, "even"), kernel), 3, rtol=1.5e-3)


@pytest.mark.parametrize("shape", [(1, 2), (3, 5), (40, 80)])
def test_a_small_picture_is_blurred_as_it_is_looked_up(shape: tuple[int, int]):
    # Oracle: the bilinear picture, written out, on a fine grid; its cosine blur by summation.
    pixels = np.random.default_rng(6).random((*shape, 3)).astype(np.float32)
    w = _directions(200, 400)
    x = ((np.arange(400) + 0.5) / 400) * shape[1] - 0.5
    y = ((np.arange(200) + 0.5) / 200) * shape[0] - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fine = np.zeros((200, 400, 3))
    for column, across in ((left, 1 - (x - left)), (left + 1, x - left)):
        for row, down in ((top, 1 - (y - top)), (top + 1, y - top)):
            rows = pixels[np.clip(row, 0, shape[0] - 1)]
            fine += rows[:, column % shape[1]] * (down[:, None] * across)[..., None]
    edges = np.cos(np.pi * np.arange(201) / 200)
    weight = np.broadcast_to(((edges[:-1] - edges[1:]) * 2 * np.pi / 400)[:, None], (200, 400))
    blurred = blurred_pixels(Environment(pixels, "small"), COSINE)
    wanted = _directions(*blurred.shape[:2])[::37, ::29].reshape(-1, 3)
    cosine = np.maximum(wanted @ w.reshape(-1, 3).T, 0) * weight.ravel() / np.pi
    np.testing.assert_allclose(blurred[::37, ::29].reshape(-1, 3), cosine @ fine.reshape(-1, 3), rtol=3e-3)


def test_a_large_picture_keeps_its_energy():
    # A sun of one texel between the poles and near one; the cosine blur at the sun is its energy over pi.
    for row in (3, 300, 511):
        pixels = np.zeros((1024, 2048, 3), np.float32)
        pixels[row, 77] = 1e6
        polar, azimuth = np.pi * (row + 0.5) / 1024, 2 * np.pi * (77.5 / 2048 - 0.5)
        sun = np.array([[np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)]])
        blurred = _look_up(Environment(pixels, "sun"), COSINE, sun)
        energy = 1e6 * (np.cos(np.pi * row / 1024) - np.cos(np.pi * (row + 1) / 1024)) * 2 * np.pi / 2048
        assert float(blurred[0, 0]) == pytest.approx(energy / np.pi, rel=3e-3)


def test_only_narrow_kernels_need_the_environment_itself():
    assert is_sampled(NARROW)
    assert is_sharp(MIRROR)
    for kernel in (COSINE, SATURATED, WIDE):
        assert not is_sampled(kernel)
        assert not is_sharp(kernel)
