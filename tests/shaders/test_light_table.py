"""The light table: cells are found with their probabilities. Oracle: the environment's own light in float64."""

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


def _solid_angles(height: int, width: int) -> np.ndarray:
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return np.repeat(((edges[:-1] - edges[1:]) * 2 * np.pi / width)[:, None], width, axis=1)


@pytest.mark.parametrize("shape", [(1, 2), (16, 32), (25, 50), (64, 128)])
def test_the_density_integrates_to_one_and_is_nowhere_zero(shape: tuple[int, int]):
    table = light_table(_sunny(*shape))
    np.testing.assert_allclose((table.pdf * _solid_angles(*shape)).sum(), 1, rtol=1e-5)
    assert (table.pdf > 0).all()


def test_only_cells_of_less_light_than_can_be_counted_are_never_drawn():
    height, width = 512, 1024
    table = light_table(_sunny(height, width))
    never = np.diff(np.append(table.cumulative.astype(np.int64), 2**32)) == 0
    share = (table.pdf * _solid_angles(height, width))[table.cells >> 16, table.cells & 65535]
    assert never.any()
    assert share[never].max() <= 2.0**-32
    # Their light goes to neighbours on the curve: at no place of it is more than one unit astray.
    astray = np.cumsum(share.astype(np.float64))[:-1] - table.cumulative[1:] / 2.0**32
    np.testing.assert_allclose(astray, 0, atol=1e-6)


def test_cells_are_found_as_often_as_the_density_says():
    height, width = 32, 64
    table = light_table(_sunny(height, width))
    row, column = table.cells >> 16, table.cells & 65535
    length = np.diff(np.append(table.cumulative.astype(np.float64), 2.0**32)) / 2.0**32
    expected = (table.pdf * _solid_angles(height, width))[row, column]
    # Units of 2^-32 for the one, float32 for the other.
    np.testing.assert_allclose(length, expected, rtol=1e-5, atol=1e-9)
    assert len(np.unique(table.cells)) == height * width


def test_the_guide_brackets_every_part_of_the_light():
    table = light_table(_sunny(32, 64))
    parts = np.random.default_rng(5).integers(0, 2**32, 20000, dtype=np.int64)
    found = np.searchsorted(table.cumulative, parts, side="right") - 1
    guide = table.guide[parts >> (32 - (len(table.guide).bit_length() - 1))]
    assert (guide[:, 0] <= found).all()
    assert (found <= guide[:, 1]).all()


def test_neighbours_on_the_curve_are_neighbours_in_the_sky():
    cells = light_table(np.ones((64, 128, 3), np.float32)).cells.astype(np.int64)
    steps = np.abs(np.diff(cells >> 16)) + np.abs(np.diff(cells & 65535))
    # Two squares of 64 x 64 lie in the square of 128 that the curve fills; it leaves them once.
    assert (steps == 1).sum() >= len(steps) - 1


def test_a_black_environment_is_sampled_evenly():
    np.testing.assert_allclose(light_table(np.zeros((8, 16, 3), np.float32)).pdf, 1 / (4 * np.pi), rtol=1e-6)


def test_a_wide_environment_is_averaged_to_a_table_of_bounded_size():
    pixels = np.ones((2050, 4100, 3), np.float32)
    table = light_table(pixels)
    assert table.pdf.shape[1] <= 2048
    np.testing.assert_allclose(table.pdf, 1 / (4 * np.pi), rtol=1e-5)
