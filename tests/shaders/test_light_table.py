"""The light table: texels are listed in proportion to their light. Oracle: the environment's own light in float64."""

from __future__ import annotations

import numpy as np
import pytest

from shaders.light_table import AXES, ENTRIES, SEGMENTS, SLOTS, WIDTHS, LightTable, light_table


def _sunny(height: int, width: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    pixels = rng.random((height, width, 3)).astype(np.float32)
    pixels[height // 3, width // 4] = 5000
    pixels[: height // 8] = 0
    return pixels


def _above_half_mean(pixels: np.ndarray) -> np.ndarray:
    """The part of all light above half of the mean luminance that each texel holds."""
    luminance = pixels.astype(np.float64) @ [0.2126, 0.7152, 0.0722]
    sine = np.sin(np.pi * (np.arange(len(pixels)) + 0.5) / len(pixels))[:, None]
    mean = (luminance * sine).sum() / (sine.sum() * pixels.shape[1])
    light = np.maximum(luminance - 0.5 * mean, 0) * sine
    return light / light.sum()


def _counts(table: LightTable) -> np.ndarray:
    """How many slots each segment has for each kernel and axis, shape (kernels axes, segments)."""
    return table.slots[:, SLOTS // 4 :] & 65535


def _listed(table: LightTable, segments: np.ndarray) -> np.ndarray:
    """How likely each texel is, for a table without blocks and these probabilities of segments."""
    assert table.block == 1
    found = np.zeros(table.density.shape)
    weight = np.repeat(segments[:, None] / ENTRIES, ENTRIES, axis=1)
    np.add.at(found, (table.cells >> 16, table.cells & 65535), weight)
    return found


def _density(table: LightTable, slots: np.ndarray) -> np.ndarray:
    """The density of an axis, as the shader takes it apart."""
    return table.density.astype(np.float64) * slots[table.density.view(np.uint32) & (SEGMENTS - 1)]


def _direction(v: float, u: float) -> np.ndarray:
    polar, azimuth = np.pi * v, 2 * np.pi * (u - 0.5)
    return np.array([np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)])


@pytest.mark.parametrize("shape", [(2, 4), (16, 32), (25, 50), (64, 128)])
def test_texels_are_listed_in_proportion_to_their_light_above_half_of_the_mean(shape: tuple[int, int]):
    pixels = _sunny(*shape)
    table, expected = light_table(pixels), _above_half_mean(pixels)
    segments = np.bincount((table.density.view(np.uint32) & (SEGMENTS - 1)).reshape(-1), expected.reshape(-1), SEGMENTS)
    # Each texel may round by one of 2^20 entries, or by half of one that its segment's others share.
    np.testing.assert_allclose(_listed(table, segments), expected, atol=2e-6)


@pytest.mark.parametrize("shape", [(1, 2), (25, 50), (2050, 4100)])
def test_the_density_integrates_to_one_for_every_kernel_and_axis(shape: tuple[int, int]):
    # Its interpolation over the picture has the mean of the texels' own, in units of 2 pi^2.
    table = light_table(_sunny(*shape))
    assert table.density.shape == shape
    numbers = (table.density.view(np.uint32) & (SEGMENTS - 1)).reshape(-1)
    of_segments = np.bincount(numbers, table.density.reshape(-1), SEGMENTS) / numbers.size
    # The lowest six bits of 24 are the segment's number.
    np.testing.assert_allclose(_counts(table) @ of_segments * 2 * np.pi**2, 1, rtol=2**-17)


def test_the_density_is_that_of_the_list_and_the_slots():
    table = light_table(_sunny(32, 64))
    for slots in _counts(table)[::97]:
        expected = _listed(table, slots / SLOTS) * table.density.size / (2 * np.pi**2)
        np.testing.assert_allclose(_density(table, slots), expected, rtol=2**-17, atol=1e-30)


def test_slots_of_a_segment_are_neighbours_and_it_is_said_where_and_how_many_they_are():
    table = light_table(_sunny(32, 64))
    counts, first = _counts(table), table.slots[:, SLOTS // 4 :] >> 16
    segment = np.ascontiguousarray(table.slots[:, : SLOTS // 4]).view("<u1")
    for row in range(0, len(segment), 97):
        np.testing.assert_array_equal(np.bincount(segment[row], minlength=SEGMENTS), counts[row])
        has_any = counts[row] > 0
        np.testing.assert_array_equal(first[row][has_any], np.searchsorted(segment[row], np.flatnonzero(has_any)))


def test_the_first_slots_are_in_proportion_to_light_times_cosine():
    pixels = np.zeros((90, 180, 3), np.float32)
    lamps = [(30, 40), (70, 60)]
    pixels[30, 40], pixels[70, 60] = 3, 10
    table = light_table(pixels)
    light = [_above_half_mean(pixels)[lamp] for lamp in lamps]
    numbers = [table.density.view(np.uint32)[lamp] & (SEGMENTS - 1) for lamp in lamps]
    for row, column in np.ndindex(24, 48):
        normal = _direction((row + 0.5) / 24, (column + 0.5) / 48)
        # 0.1 is added to every cosine.
        weight = [
            share * max(normal @ _direction((lamp[0] + 0.5) / 90, (lamp[1] + 0.5) / 180) + 0.1, 0)
            for share, lamp in zip(light, lamps, strict=True)
        ]
        found = _counts(table)[row * 48 + column, numbers] / SLOTS
        # One slot is rounded, and one is of each segment that is seen.
        np.testing.assert_allclose(found, np.divide(weight, sum(weight)) if sum(weight) else light, atol=3 / SLOTS)
        assert ((found > 0) == (np.array(weight) > 0)).all() or not sum(weight)


@pytest.mark.parametrize(("kernel", "width"), list(enumerate(WIDTHS, 1)))
def test_a_lobes_slots_are_in_proportion_to_light_times_ggx_about_any_axis_of_their_cell(kernel: int, width: float):
    pixels = np.zeros((90, 180, 3), np.float32)
    lamps = [(40, 40), (48, 52)]
    pixels[40, 40], pixels[48, 52] = 3, 10
    table = light_table(pixels)
    light = np.array([_above_half_mean(pixels)[lamp] for lamp in lamps])
    numbers = [table.density.view(np.uint32)[lamp] & (SEGMENTS - 1) for lamp in lamps]
    cells = [(10, 11), (12, 13), (11, 12), (15, 16)]
    nodes = (np.arange(16) + 0.5) / 16
    for row, column in cells:
        axes = np.stack([_direction((row + v) / AXES[0], (column + u) / AXES[1]) for v in nodes for u in nodes])
        weight = []
        for share, lamp in zip(light, lamps, strict=True):
            cosine = axes @ _direction((lamp[0] + 0.5) / 90, (lamp[1] + 0.5) / 180)
            # GGX seen along the normal (Walter 2007, eq. 33) times the cosine of the half vector to the fourth power.
            weight.append(share * np.mean((1 + (1 - cosine) / (1 + cosine) / width**2) ** -2.0))
        found = _counts(table)[(kernel * AXES[0] + row) * AXES[1] + column]
        # One slot of each is sure. The kernel is widened for its cell instead of averaged over it.
        expected = np.maximum(np.divide(weight, sum(weight)), 1 / SLOTS)
        np.testing.assert_allclose(found[numbers] / SLOTS, expected, rtol=0.25, atol=0.05)
        assert (found[numbers] > 0).all()


def test_a_sun_beside_the_dimmest_sky_leaves_a_table():
    pixels = np.full((16, 32, 3), 1e-9, np.float32)
    pixels[12, 3], pixels[3, 3] = 1e10, 1e8
    table = light_table(pixels)
    assert (_counts(table).sum(axis=1) == SLOTS).all()
    np.testing.assert_allclose(_density(table, _counts(table)[24 * 24])[[12, 3], 3].sum(), 512 / (2 * np.pi**2), 1e-4)


def test_an_axis_that_sees_no_light_has_slots_and_they_are_of_light():
    pixels = np.zeros((16, 32, 3), np.float32)
    pixels[1] = 5
    table = light_table(pixels)
    np.testing.assert_array_equal(_counts(table).sum(axis=1), SLOTS)
    lowest = _counts(table)[AXES[0] * AXES[1] - 1]
    assert _density(table, lowest)[1].min() > 0


def test_a_wide_picture_is_listed_in_blocks_each_texel_of_which_is_as_likely():
    # 4100 = 3 x 1366 + 2: the last column of blocks is incomplete.
    table = light_table(_sunny(2050, 4100))
    assert table.block == 3
    segment = table.density.view(np.uint32)[300, -1] & (SEGMENTS - 1)
    cells = table.cells[segment]
    own = ((cells >> 16) == 300) & ((cells & 65535) == 3 * 1366)
    assert ((table.cells >> 16) % 3 == 0).all()
    assert ((table.cells & 65535) % 3 == 0).all()
    expected = own.mean() / SLOTS / (3 * 2) * 2050 * 4100 / (2 * np.pi**2)
    np.testing.assert_allclose(table.density[300:303, -2:], expected, rtol=2**-17)


def test_neighbours_on_the_curve_are_neighbours_in_the_sky():
    cells = light_table(np.ones((64, 128, 3), np.float32)).cells.reshape(-1).astype(np.int64)
    steps = np.abs(np.diff(cells >> 16)) + np.abs(np.diff(cells & 65535))
    # Two squares of 64 x 64 lie in the square of 128 that the curve fills; it leaves them once.
    assert (steps > 1).sum() <= 1


@pytest.mark.parametrize("level", [0.0, 0.7])
def test_an_even_environment_is_known_and_sampled_evenly(level: float):
    table = light_table(np.full((8, 16, 3), level, np.float32))
    sine = np.sin(np.pi * (np.arange(8) + 0.5) / 8)[:, None]
    assert table.is_even
    # All segments as likely; two texels each, one of which its entries end with.
    segments = np.full(SEGMENTS, 1 / SEGMENTS)
    np.testing.assert_allclose(_listed(table, segments), sine / (16 * sine.sum()) + 0 * table.density, rtol=0.6)
    assert not light_table(_sunny(8, 16)).is_even
