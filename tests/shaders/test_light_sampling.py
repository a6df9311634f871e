"""Light that one texel sends is all there, wherever it lies. Oracle: a closed integral over the texel in float64."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brdf
from shaders import Environment, Part, Scene, render

pytestmark = pytest.mark.gpu
_HEIGHT, _SIZE = 16, 33


def _irradiance(row: int, column: int, normal: np.ndarray) -> float:
    """Of one texel of radiance 1, interpolated linearly, held beyond the poles: midpoints over its tent."""
    nodes = (np.arange(600) + 0.5) / 300 - 1
    x, y = column + 0.5 + nodes[None, :], row + 0.5 + nodes[:, None]
    tent = (1 - np.abs(nodes[None, :])) * (1 - np.abs(nodes[:, None]))
    y = np.where(y < 0, -y, np.where(y > _HEIGHT, 2 * _HEIGHT - y, y))
    polar, azimuth = np.pi * y / _HEIGHT, 2 * np.pi * (x / (2 * _HEIGHT) - 0.5)
    w = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * x, -np.sin(polar) * np.cos(azimuth)], -1)
    area = (np.pi / _HEIGHT / 300) ** 2
    return float((tent * np.sin(polar) * np.maximum(w @ normal, 0)).sum() * area)


@pytest.mark.parametrize(("row", "column"), [(6, 28), (9, 0), (0, 5), (15, 30)])
def test_a_ball_lit_by_one_texel_reflects_its_irradiance(row: int, column: int):
    pixels = np.zeros((_HEIGHT, 2 * _HEIGHT, 3), np.float32)
    pixels[row, column] = 100
    environment = Environment(pixels, "one texel")
    part = Part(brdf.MODELS["lambert"](albedo=0.5))
    scene = Scene((part,), environment, width=_SIZE, height=_SIZE, samples=4096, sky="none", tone_map="none")
    image = render(scene).pixels
    half = math.tan(math.radians(15))
    found, expected = [], []
    for i, j in ((16, 16), (10, 20), (22, 9), (6, 16), (27, 18)):
        ray = np.array([((2 * j + 1) / _SIZE - 1) * half, (1 - (2 * i + 1) / _SIZE) * half, -1.0])
        ray /= np.linalg.norm(ray)
        along = -4.77 * ray[2] - math.sqrt((4.77 * ray[2]) ** 2 - (4.77**2 - 1))
        normal = np.array([0, 0, 4.77]) + along * ray
        found.append(image[i, j, 0])
        expected.append(0.5 / np.pi * 100 * _irradiance(row, column, normal))
    # The noise of 2048 directions to the light, and the pixel's extent where the horizon cuts the texel.
    np.testing.assert_allclose(found, expected, rtol=3e-3, atol=3e-3 * max(expected))
