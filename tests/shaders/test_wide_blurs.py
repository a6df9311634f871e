"""Blurs by kernels that are not narrow, at texels of cubes. Oracles: sums over all texels in float64, and orders."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shaders import Environment, wide_blurs
from shaders.cube_texels import texel_directions
from shaders.kernel import COSINE, SATURATED, Kernel, nearest_kernel
from shaders.lamps import Lamps, find_lamps, find_strong_lamps, merge_lamps
from shaders.wide_blurs import blurred_pixels, blurred_texels

pytestmark = pytest.mark.usefixtures("nothing_kept")

KERNELS = [COSINE, SATURATED, *(nearest_kernel(*one) for one in ((2.0, 1.0), (2.0, 0.25), (1.5, 0.15), (np.inf, 0.08)))]


def _lit(sun: float) -> Environment:
    """Noise, and a sun of four texels beside the seam, this many times as bright."""
    pixels = np.random.default_rng(41).uniform(0, 1, (128, 256, 3))
    pixels[40:42, [0, 255]] += sun * np.array([1.0, 0.8, 0.6])
    return Environment(pixels.astype(np.float32), "lit")


def _direct_sum(environment: Environment, kernel: Kernel, w: NDArray[np.float64]) -> NDArray[np.float64]:
    height, width = environment.pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    u, polar = (np.arange(width) + 0.5) / width, (np.arange(height)[:, None] + 0.5) * np.pi / height
    azimuth, sine = 2 * np.pi * (u - 0.5), np.sin(polar)
    lights = np.stack([sine * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -sine * np.cos(azimuth)], axis=-1)
    weight = np.repeat((edges[:-1] - edges[1:]) * 2 * np.pi / width, width)
    cosine = w @ lights.reshape(-1, 3).T
    values = kernel.values((1 - cosine) / np.maximum(1 + cosine, 1e-12)) * weight
    return values @ environment.pixels.reshape(-1, 3) / values.sum(axis=1, keepdims=True)


@pytest.mark.parametrize("sun", [0.0, 3e2, 1e7])
@pytest.mark.parametrize("kernel", KERNELS, ids=lambda one: one.name)
def test_texels_hold_the_sum_over_all_lights(kernel: Kernel, sun: float):
    environment = _lit(sun)
    found = blurred_texels(environment, kernel)
    assert found.min() >= 0
    assert (found[..., 3] == 1).all()
    chosen = np.random.default_rng(42).integers(0, kernel.texels, (2, 200))
    faces = np.arange(200) % 6
    w = texel_directions(kernel.texels)[faces, *chosen].astype(np.float64)
    expected = _direct_sum(environment, kernel, w)
    # What is left above a kernel's degree, 1e-2 of its height, is spread over all directions; of a sun, and of the
    # kernels that are smooth, it is nothing. The sun's four texels are one to the widest kernels.
    error = np.sqrt(((found[faces, *chosen][:, :3] - expected) ** 2).mean() / (expected**2).mean())
    assert error < 2e-3


@pytest.mark.parametrize("kernel", [nearest_kernel(power, 0.25) for power in (1.5, 2.0, np.inf)], ids=lambda k: k.name)
def test_of_a_smooth_kernel_nothing_is_negative_below_a_hot_sun(kernel: Kernel):
    # A sun in the dark: before what is negative is cut off, as little of it as is left above the kernel's degree.
    assert kernel.is_smooth
    pixels = np.zeros((64, 128, 3), np.float32)
    pixels[20, 5] = 1e9
    environment = Environment(pixels, "sun")
    blurred = blurred_pixels(environment, kernel)
    height = float(kernel.values(np.zeros(1))[0])
    edges = np.cos(np.pi * np.array([20, 21]) / 64)
    energy = 1e9 * (edges[0] - edges[1]) * 2 * np.pi / 128
    assert blurred.max() == pytest.approx(height * energy, rel=5e-3)
    w = texel_directions(kernel.texels).reshape(-1, 3)[::97].astype(np.float64)
    found = blurred_texels(environment, kernel).reshape(-1, 4)[::97, :3]
    np.testing.assert_allclose(found, _sun(kernel, w, energy), atol=1e-3 * height * energy)


def _sun(kernel: Kernel, w: NDArray[np.float64], energy: float) -> NDArray[np.float64]:
    polar, azimuth = np.pi * 20.5 / 64, 2 * np.pi * (5.5 / 128 - 0.5)
    sun = np.array([np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)])
    cosine = w @ sun
    return np.repeat(energy * kernel.values((1 - cosine) / np.maximum(1 + cosine, 1e-12))[:, None], 3, axis=1)


def test_a_blur_does_not_depend_on_which_came_before():
    wide, narrow = nearest_kernel(2.0, 0.5), nearest_kernel(np.inf, 0.04)
    first, second = _lit(300.0), _lit(300.0)
    assert narrow.degree > wide.degree
    pairs = [(blurred_pixels(first, one), one) for one in (wide, narrow)]
    for found, kernel in reversed(pairs):
        # Texels are summed for few degrees: their places are off by half a texel at most.
        np.testing.assert_allclose(blurred_pixels(second, kernel), found, rtol=2e-3)


def test_weak_lamps_are_left_in_the_picture():
    # 64 texels are a hair above the next.
    pixels = np.ones((64, 128, 3), np.float32)
    pixels[30:38, 60:70] = 100 + np.linspace(0, 1e-2, 80).reshape(8, 10, 1)
    environment = Environment(pixels, "box")
    assert len(find_lamps(environment).directions) == 64
    assert find_strong_lamps(environment).limit == np.inf
    assert len(find_strong_lamps(_lit(300.0)).directions) > 0


def test_neighbouring_lamps_become_one_in_the_middle_of_their_light():
    near = np.array([[1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [0.0, 1.0, 0.0]])
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    fluxes = np.array([[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [1.0, 0.0, 0.0]])
    lamps = Lamps(2.0, near.astype(np.float32), fluxes.astype(np.float32), 0.5)
    merged = merge_lamps(lamps, 1.0)
    np.testing.assert_allclose(merged.directions, [[1, 0.0075, 0], [0, 1, 0]], atol=1e-4)
    np.testing.assert_allclose(merged.fluxes, [[4, 4, 4], [1, 0, 0]])
    assert len(merge_lamps(lamps, 0.1).directions) == 3


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda one: one.name)
def test_a_blur_that_was_made_is_read_and_not_made_again(kernel: Kernel, monkeypatch: pytest.MonkeyPatch):
    # Oracle: the round trip.
    made = blurred_texels(_lit(5.0), kernel)
    monkeypatch.setattr(wide_blurs, "_texels", lambda *_: pytest.fail("it is made although it was kept"))
    np.testing.assert_array_equal(blurred_texels(_lit(5.0), kernel), made)
