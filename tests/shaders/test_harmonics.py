"""Spherical harmonics and the blurs made with them. Oracles: closed forms, and sums over all texels in float64."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shaders.harmonics import analyse, kernel_coefficients, synthesise
from shaders.kernel import COSINE, SATURATED, Kernel, nearest_kernel


def _directions(height: int, width: int) -> NDArray[np.float64]:
    """The direction of every texel, by the documented orientation: its inverse, written out independently."""
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height)[:, None] + 0.5) / height
    azimuth, polar = 2 * np.pi * (u - 0.5), np.pi * v
    sine = np.sin(polar)
    return np.stack([sine * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -sine * np.cos(azimuth)], axis=-1)


def _solid_angles(height: int, width: int) -> NDArray[np.float64]:
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return np.broadcast_to(((edges[:-1] - edges[1:]) * 2 * np.pi / width)[:, None], (height, width))


def _harsh(height: int) -> NDArray[np.float32]:
    """Noise over six decades with a sun of one texel."""
    rng = np.random.default_rng(12)
    pixels = np.exp(rng.normal(0, 2, (height, 2 * height, 3)))
    pixels[height // 4, 3] = 1e5
    return pixels.astype(np.float32)


def _blurred(pixels: NDArray[np.float32], kernel: Kernel, degree: int, height: int) -> NDArray[np.float32]:
    factors = kernel.coefficients()[: degree + 1]
    return synthesise(analyse(pixels, degree)[:, : len(factors)][: len(factors)] * factors[:, None], height)


def test_a_smooth_picture_is_found_again():
    # Of degree 2 at most; the midpoint rule over rows, with exact solid angles, is off by the square of their height.
    w = _directions(96, 192)
    picture = np.stack([1 + 0 * w[..., 0], w[..., 1], w[..., 0] * w[..., 2]], axis=-1)
    again = synthesise(analyse(picture.astype(np.float32), 8), 20)
    w = _directions(20, 40)
    expected = np.stack([1 + 0 * w[..., 0], w[..., 1], w[..., 0] * w[..., 2]], axis=-1)
    np.testing.assert_allclose(again, expected, atol=2e-3)


def test_the_coefficients_of_a_constant_and_of_the_height_are_the_closed_forms():
    w = _directions(256, 512)
    picture = np.stack([1 + 0 * w[..., 1], w[..., 1], w[..., 0]], axis=-1).astype(np.float32)
    found = analyse(picture, 3)
    # sqrt(4 pi) for 1, sqrt(4 pi / 3) for y: the integral of Y^2 is 1. x = sin(polar) sin(azimuth) is of order 1.
    assert found[0, 0, 0] == pytest.approx(np.sqrt(4 * np.pi), rel=1e-5)
    assert found[0, 1, 1] == pytest.approx(np.sqrt(4 * np.pi / 3), rel=1e-4)
    assert abs(found[1, 1, 2]) == pytest.approx(np.sqrt(2 * np.pi / 3), rel=1e-4)
    found[0, 0, 0] = found[0, 1, 1] = found[1, 1, 2] = 0
    assert np.abs(found).max() < 1e-3


@pytest.mark.parametrize("width", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("power", [1.5, 2.0, np.inf])
def test_a_blur_is_the_sum_over_all_texels(power: float, width: float):
    # The kernel to 2.5 times its degree: what it leaves out beyond is tested by itself.
    kernel = nearest_kernel(power, width)
    degree = int(2.5 * kernel.degree)
    height = max(degree, 64)
    pixels = _harsh(height)
    factors = kernel_coefficients(kernel.values, degree)
    picture = synthesise(analyse(pixels, degree) * factors[:, None], degree)
    rng = np.random.default_rng(13)
    rows, columns = rng.integers(0, degree, 40), rng.integers(0, 2 * degree, 40)
    wanted = _directions(degree, 2 * degree)[rows, columns]
    w = _directions(height, 2 * height).reshape(-1, 3)
    near, far = (((w[None] - s * wanted[:, None]) ** 2).sum(axis=-1) for s in (1, -1))
    weight = kernel.values(near / np.maximum(far, 1e-30)) * _solid_angles(height, 2 * height).ravel()
    expected = weight @ pixels.reshape(-1, 3).astype(np.float64)
    np.testing.assert_allclose(picture[rows, columns], expected, rtol=1e-4, atol=1e-4 * np.median(expected))


@pytest.mark.parametrize("kernel", [COSINE, SATURATED, nearest_kernel(2.0, 0.3)], ids=lambda one: one.name)
def test_a_blur_keeps_the_energy(kernel: Kernel):
    pixels = _harsh(48)
    blurred = _blurred(pixels, kernel, kernel.degree, 128)
    energy = [
        np.einsum("hw,hwc->c", _solid_angles(*one.shape[:2]), one.astype(np.float64)) for one in (pixels, blurred)
    ]
    # The rule over the rows of the smooth result is off by the square of their height.
    np.testing.assert_allclose(energy[1], energy[0], rtol=1e-3)


def test_a_sun_of_one_texel_becomes_the_kernel():
    kernel, height = nearest_kernel(np.inf, 0.2), 32
    pixels = np.zeros((height, 2 * height, 3), np.float32)
    pixels[9, 60] = 1000.0
    blurred = _blurred(pixels, kernel, kernel.degree, 64)
    sun, w = _directions(height, 2 * height)[9, 60], _directions(64, 128)
    near, far = ((w - sun) ** 2).sum(axis=-1), ((w + sun) ** 2).sum(axis=-1)
    expected = 1000 * _solid_angles(height, 2 * height)[9, 60] * kernel.values(near / far)
    # Of the height, where the kernel's degree ends.
    np.testing.assert_allclose(blurred[..., 0], expected, atol=1e-3 * expected.max())


@pytest.mark.parametrize("shape", [(1, 2), (2, 4), (3, 5), (7, 13), (1, 1)])
def test_pictures_of_any_size_are_taken(shape: tuple[int, int]):
    # Oracle: the sum of point lights, by Legendre's polynomials of the angle between them (the addition theorem).
    pixels = np.random.default_rng(14).random((*shape, 3)).astype(np.float32)
    degree = shape[0]
    picture = synthesise(analyse(pixels, degree), 8)
    cosine = _directions(8, 16) @ _directions(*shape).reshape(-1, 3).T
    orders = shape[1] // 2
    assert picture.shape == (8, 16, 3)
    if orders >= degree:
        density = sum(
            (2 * n + 1) / (4 * np.pi) * np.polynomial.legendre.legval(cosine, np.eye(degree + 1)[n])
            for n in range(degree + 1)
        )
        expected = density @ (_solid_angles(*shape).reshape(-1, 1) * pixels.reshape(-1, 3))
        np.testing.assert_allclose(picture, expected, atol=1e-5)


def test_a_cosine_is_that_of_ramamoorthi_and_hanrahan():
    # A_l / pi of their clamped cosine: 1, 2/3, 1/4, 0 for the odd ones above 1, and by their closed form for the even.
    found = kernel_coefficients(lambda x: np.maximum((1 - x) / (1 + x), 0.0), 12)
    expected = np.zeros(13)
    expected[:2] = 1, 2 / 3
    for n in range(2, 13, 2):
        factorials = np.prod(np.arange(1, n + 1.0)) / (2**n * np.prod(np.arange(1, n // 2 + 1.0)) ** 2)
        expected[n] = 2 * (-1) ** (n // 2 - 1) / ((n + 2) * (n - 1)) * factorials
    np.testing.assert_allclose(found, expected, atol=2e-6)
