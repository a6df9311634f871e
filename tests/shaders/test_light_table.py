"""The light table: texels are listed in proportion to their light. Oracle: the environment's own light in float64."""

from __future__ import annotations

import numpy as np
import pytest

from shaders.light_table import light_table


def _sunny(height: int, width: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    pixels = rng.random((height, width, 3)).astype(np.float32)
    pixels[height // 3, width // 4] = 5000
    pixels[: height // 8] = 0
    return pixels


def _above_half_mean(pixels: np.ndarray) -> np.ndarray:
    """The part of all light above half the mean luminance that each texel holds."""
    luminance = pixels.astype(np.float64) @ [0.2126, 0.7152, 0.0722]
    sine = np.sin(np.pi * (np.arange(len(pixels)) + 0.5) / len(pixels))[:, None]
    mean = (luminance * sine).sum() / (sine.sum() * pixels.shape[1])
    light = np.maximum(luminance - 0.5 * mean, 0) * sine
    return light / light.sum()


def _listed(pixels: np.ndarray) -> np.ndarray:
    """How often each texel is listed, as a part of all, for a table without blocks."""
    table = light_table(pixels)
    assert table.block == 1
    counts = np.zeros(pixels.shape[:2])
    np.add.at(counts, (table.cells >> 16, table.cells & 65535), 1)
    return counts / len(table.cells)


@pytest.mark.parametrize("shape", [(2, 4), (16, 32), (25, 50), (64, 128)])
def test_texels_are_listed_in_proportion_to_their_light_above_half_the_mean(shape: tuple[int, int]):
    pixels = _sunny(*shape)
    # Of 2^21 entries each texel may round by one half; the heaviest take what is left over.
    np.testing.assert_allclose(_listed(pixels), _above_half_mean(pixels), atol=2e-6)


@pytest.mark.parametrize("shape", [(1, 2), (25, 50), (2050, 4100)])
def test_the_density_integrates_to_one(shape: tuple[int, int]):
    # Its interpolation over the picture has the mean of the texels' own, in units of 2 pi^2.
    table = light_table(_sunny(*shape))
    assert table.density.shape == shape
    np.testing.assert_allclose(table.density.mean(dtype=np.float64) * 2 * np.pi**2, 1, rtol=1e-6)


def test_the_density_is_that_of_the_list():
    pixels = _sunny(32, 64)
    np.testing.assert_allclose(
        light_table(pixels).density, _listed(pixels) * pixels[..., 0].size / (2 * np.pi**2), rtol=1e-6
    )


def test_a_wide_picture_is_listed_in_blocks_each_texel_of_which_is_as_likely():
    # 4100 = 3 x 1366 + 2: the last column of blocks is incomplete.
    table = light_table(_sunny(2050, 4100))
    assert table.block == 3
    counts = np.zeros((684, 1367))
    np.add.at(counts, ((table.cells >> 16) // 3, (table.cells & 65535) // 3), 1)
    assert ((table.cells >> 16) % 3 == 0).all()
    assert ((table.cells & 65535) % 3 == 0).all()
    share = counts[100, -1] / len(table.cells) / (3 * 2)
    np.testing.assert_allclose(table.density[300:303, -2:], share * 2050 * 4100 / (2 * np.pi**2), rtol=1e-6)


def test_neighbours_on_the_curve_are_neighbours_in_the_sky():
    cells = light_table(np.ones((64, 128, 3), np.float32)).cells.astype(np.int64)
    steps = np.abs(np.diff(cells >> 16)) + np.abs(np.diff(cells & 65535))
    # Two squares of 64 x 64 lie in the square of 128 that the curve fills; it leaves them once.
    assert (steps > 1).sum() <= 1


@pytest.mark.parametrize("level", [0.0, 0.7])
def test_an_even_environment_is_known_and_sampled_evenly(level: float):
    table = light_table(np.full((8, 16, 3), level, np.float32))
    sine = np.sin(np.pi * (np.arange(8) + 0.5) / 8)[:, None]
    assert table.is_even
    np.testing.assert_allclose(table.density / sine, 128 / (2 * np.pi**2 * 16 * sine.sum()) + 0 * table.density, 1e-4)
    assert not light_table(_sunny(8, 16)).is_even
