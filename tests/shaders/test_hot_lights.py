"""The hot lights of an environment. Oracle: sums over its texels in float64, by the definition."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shaders import Environment, load_environment
from shaders.hot_lights import IN_FRAME, HotLights, find_hot_lights

_FRAMES = 16


def _sky(height: int) -> NDArray[np.float32]:
    return np.full((height, 2 * height, 3), 0.25, np.float32)


def _solid_angle(height: int) -> NDArray[np.float64]:
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return (edges[:-1] - edges[1:]) * (np.pi / height)


def _direction(row: int, column: int, height: int) -> NDArray[np.float64]:
    polar, azimuth = np.pi * (row + 0.5) / height, np.pi * ((column + 0.5) / height - 1)
    return np.array([np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)])


def _found(pixels: NDArray[np.float32]) -> HotLights:
    lights = find_hot_lights(Environment(pixels, "sky"), _FRAMES)
    assert lights is not None
    assert len(lights.directions) == IN_FRAME * _FRAMES
    np.testing.assert_allclose(np.linalg.norm(lights.directions, axis=1), 1, rtol=1e-12)
    return lights


@pytest.mark.parametrize("name", ["clear_sky", "night", "studio"])
def test_the_lights_hold_all_that_is_above_the_limit(name: str):
    pixels = load_environment(name).pixels
    lights = _found(pixels)
    solid_angle = _solid_angle(len(pixels))
    above = (np.maximum(pixels.astype(np.float64) - lights.limit, 0) * solid_angle[:, None, None]).sum(axis=(0, 1))
    np.testing.assert_allclose(lights.fluxes.sum(axis=0), above, rtol=1e-9)
    mean = (pixels.max(axis=2).astype(np.float64) * solid_angle[:, None]).sum() / (4 * np.pi)
    assert lights.limit == pytest.approx(mean, rel=1e-5)


# Above 512 texels of width several are one block, whose place is that of its light.
@pytest.mark.parametrize("height", [64, 515])
def test_a_sun_of_one_texel_stands_in_its_middle(height: int):
    pixels, row, column = _sky(height), height // 3, height // 5
    pixels[row, column] = 1e6, 5e5, 1e5
    lights = _found(pixels)
    np.testing.assert_allclose(
        lights.directions, np.tile(_direction(row, column, height), (len(lights.fluxes), 1)), atol=1e-4
    )
    np.testing.assert_allclose(
        lights.fluxes / lights.fluxes[:, :1], np.tile([1, 0.5, 0.1], (len(lights.fluxes), 1)), rtol=1e-2
    )
    assert 0 < lights.solid_angle <= _solid_angle(height)[row]


def test_two_suns_are_not_mixed_and_share_the_lights_by_flux():
    pixels, height = _sky(64), 64
    pixels[20, 30], pixels[40, 100] = 3e4, 1e4
    lights = _found(pixels)
    fluxes = []
    for row, column in ((20, 30), (40, 100)):
        near = lights.directions @ _direction(row, column, height) > 1 - 1e-6
        fluxes.append(lights.fluxes[near].sum(axis=0))
        share = lights.fluxes[near].sum() / lights.fluxes.sum()
        assert near.sum() == pytest.approx(len(near) * share, abs=1)
    np.testing.assert_allclose(fluxes[0] / fluxes[1], 3 * _solid_angle(64)[20] / _solid_angle(64)[40], rtol=1e-3)


def test_an_even_light_and_a_dark_one_have_none():
    assert find_hot_lights(load_environment("furnace"), _FRAMES) is None
    assert find_hot_lights(Environment(np.zeros((8, 16, 3), np.float32), "dark"), _FRAMES) is None
