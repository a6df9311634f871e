"""MERL tables. Most use a small table, which the reader takes like the full one."""

from __future__ import annotations

import numpy as np
import pytest

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.formats import merl
from fitter.rusinkiewicz import directions

SMALL = (9, 10, 12)


def smooth(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """A reciprocal BRDF without azimuth trouble, unequal in its channels, 1/sr."""
    half = wi + wo
    cosine = half[:, 2] / np.linalg.norm(half, axis=1)
    return np.stack([cosine**20 + 0.1, 0.5 * cosine**20 + 0.2, wi[:, 2] * wo[:, 2]], 1)


@pytest.fixture
def small(tmp_path):
    merl.write_function(smooth, tmp_path / "small.binary", SMALL)
    return tmp_path / "small.binary"


def poke(path, cell: tuple[int, int, int, int], raw: float) -> None:
    """Overwrites one raw number, at (channel, theta_h, theta_d, phi_d)."""
    with open(path, "r+b") as file:
        file.seek(12 + 8 * int(np.ravel_multi_index(cell, (3, *SMALL))))
        file.write(np.array(raw, "<f8").tobytes())


def test_bytes_have_the_published_layout_and_scales(tmp_path):
    # Oracle: the format's definition, packed by hand: cell (1, 2, 3) of channel c is 100 c + 23.
    raw = np.full((3, *SMALL), 1.0)
    raw[:, 1, 2, 3] = [23.0, 123.0, 223.0]
    path = tmp_path / "hand.binary"
    path.write_bytes(np.array(SMALL, "<i4").tobytes() + raw.astype("<f8").tobytes())
    data = fitter.formats.read(path)
    assert data.grid is not None
    row = np.flatnonzero(data.grid.index == np.ravel_multi_index((1, 2, 3), SMALL))[0]
    np.testing.assert_allclose(data.value[row], [23 / 1500, 123 * 1.15 / 1500, 223 * 1.66 / 1500])
    wi, wo = directions((1 / 9) ** 2 * np.pi / 2, 2 / 10 * np.pi / 2, 3 / 12 * np.pi)
    np.testing.assert_allclose(data.wi[row], wi, atol=1e-15)
    np.testing.assert_allclose(data.wo[row], wo, atol=1e-15)


@pytest.mark.parametrize(("cells", "shift"), [("edge", 0.0), ("centre", 0.5)])
def test_cells_stand_for_their_edge_or_centre(small, cells, shift):
    # Oracle: the definition of the axes.
    data = fitter.formats.read(small, {"cells": cells})
    assert data.grid is not None
    assert cells in data.source
    np.testing.assert_allclose(data.grid.axes["theta_h"], ((np.arange(9) + shift) / 9) ** 2 * np.pi / 2)
    np.testing.assert_allclose(data.grid.axes["theta_d"], (np.arange(10) + shift) / 10 * np.pi / 2)
    np.testing.assert_allclose(data.grid.axes["phi_d"], (np.arange(12) + shift) / 12 * np.pi)


@pytest.mark.parametrize("cells", ["edge", "centre"])
def test_samples_are_those_of_the_function_that_was_tabulated(tmp_path, cells):
    # Oracle: the closed form; 1e-14 for a dozen roundings.
    merl.write_function(smooth, tmp_path / "a.binary", SMALL, cells)
    data = fitter.formats.read(tmp_path / "a.binary", {"cells": cells})
    np.testing.assert_allclose(data.value, smooth(data.wi, data.wo), rtol=1e-14)
    assert len(data) + sum(data.dropped.values()) == np.prod(SMALL)
    assert set(data.dropped) == {"below horizon"}


@pytest.mark.parametrize("cells", ["edge", "centre"])
def test_evaluating_at_a_cell_gives_exactly_its_value(tmp_path, cells):
    # Oracle: the stored numbers, which here differ from cell to cell at random.
    noise = np.random.default_rng(3)
    merl.write_function(
        lambda wi, wo: noise.uniform(0.1, 9, (len(wi), 3)),
        tmp_path / "a.binary",
        cells=cells,
        size=(30, 30, 60),
    )
    data = fitter.formats.read(tmp_path / "a.binary", {"cells": cells})
    assert data.grid is not None
    # At theta_d = 0 all cells of a row are the same pair of directions.
    theta_d = np.unravel_index(data.grid.index, data.grid.shape)[1]
    one = data.grid.axes["theta_d"][theta_d] > 0
    np.testing.assert_array_equal(data.evaluate(data.wi, data.wo)[one], data.value[one])
    turn = np.array([[np.cos(1), -np.sin(1), 0], [np.sin(1), np.cos(1), 0], [0, 0, 1]])
    turned = data.evaluate(data.wi @ turn.T, data.wo @ turn.T)
    inside = one & (np.hypot(data.wi + data.wo, 0)[:, :2].max(1) > 1e-9)
    np.testing.assert_array_equal(turned[inside], data.value[inside])


def test_evaluation_between_cells_is_the_trilinear_mean(small):
    # Oracle: a loop over the eight corners in the file's own coordinates.
    data = fitter.formats.read(small)
    assert data.grid is not None
    table = data.grid.scatter(data.value)
    for i, j, k in [(2.25, 3.5, 4.75), (0.5, 0.5, 11.5), (3.0, 2.75, 0.25)]:
        pair = directions((i / 9) ** 2 * np.pi / 2, j / 10 * np.pi / 2, k / 12 * np.pi)
        expected = np.zeros(3)
        for corner in np.ndindex(2, 2, 2):
            cell = np.floor([i, j, k]).astype(int) + corner
            weight = np.prod(1 - np.abs(np.array([i, j, k]) - cell))
            expected += weight * table[cell[0], cell[1], cell[2] % 12] if weight else 0
        found = data.evaluate(*(direction[None] for direction in pair))
        np.testing.assert_allclose(found[0], expected, rtol=1e-12)


def test_evaluation_is_reciprocal_across_the_seam_of_phi_d(small):
    # Oracle: a law: phi_d and phi_d + pi are the same cell.
    data = fitter.formats.read(small)
    phi_d = np.linspace(-np.pi, np.pi, 97)
    wi, wo = directions(0.2, 0.3, phi_d)
    np.testing.assert_allclose(data.evaluate(wi, wo), data.evaluate(wo, wi), rtol=1e-12)


def test_cell_with_any_negative_channel_is_left_out_of_samples_and_means(small):
    # Oracle: the cell's neighbours; half-way between the two, only the valid one counts.
    before = fitter.formats.read(small)
    poke(small, (1, 2, 3, 4), -0.5)
    data = fitter.formats.read(small)
    assert data.dropped["marked invalid"] == 1
    assert len(data) == len(before) - 1
    assert data.grid is not None
    assert np.isnan(data.grid.scatter(data.value)[2, 3, 4]).all()
    theta_h, theta_d = (2 / 9) ** 2 * np.pi / 2, 3 / 10 * np.pi / 2
    wi, wo = directions(theta_h, theta_d, np.array([4.0, 4.5, 5.0]) / 12 * np.pi)
    value = data.evaluate(wi, wo)
    assert np.isnan(value[0]).all()
    np.testing.assert_array_equal(value[1], value[2])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_cell_that_is_not_finite_is_dropped_and_counted(small, bad):
    poke(small, (2, 1, 1, 1), bad)
    assert fitter.formats.read(small).dropped["not finite"] == 1


@pytest.mark.parametrize("fill", [np.nan, -1.0])
def test_table_without_a_valid_cell_is_refused(tmp_path, fill):
    path = tmp_path / "empty.binary"
    path.write_bytes(np.array(SMALL, "<i4").tobytes() + np.full(3 * np.prod(SMALL), fill, "<f8").tobytes())
    with pytest.raises(FileError, match="no valid cell"):
        fitter.formats.read(path)


@pytest.mark.parametrize(
    ("length", "message"),
    [(5, "byte 5, inside the header"), (12, "is 12 bytes long"), (4000, "is 4000 bytes long")],
)
def test_truncated_tables_are_refused_with_the_byte(small, length, message):
    small.write_bytes(small.read_bytes()[:length])
    with pytest.raises(FileError, match=message) as caught:
        fitter.formats.read(small)
    assert str(small) in str(caught.value)


@pytest.mark.parametrize("header", [(90, 90, 180), (2**31 - 1,) * 3, (30000, 30000, 30000), (-9, -10, 12), (0, 0, 0)])
def test_header_that_does_not_fit_the_length_is_refused_before_allocating(small, header):
    # A table of 30000^3 would take 648 TB: an attempt to allocate it would fail otherwise.
    small.write_bytes(np.array(header, "<i4").tobytes() + small.read_bytes()[12:])
    with pytest.raises(FileError, match=r"bytes\s0-11"):
        fitter.formats.read(small)


def test_text_with_the_suffix_of_a_table_is_refused(tmp_path):
    path = tmp_path / "page.binary"
    path.write_text("<html>404 not found, with enough text to pass for a header</html>")
    with pytest.raises(FileError, match="MERL"):
        fitter.formats.read(path)


def test_table_is_written_back_equal(small, tmp_path):
    # Oracle: the round trip; the scale is divided out again, hence two roundings.
    poke(small, (0, 2, 3, 4), -1.0)
    data = fitter.formats.read(small)
    fitter.formats.write(data, tmp_path / "copy.binary")
    again = fitter.formats.read(tmp_path / "copy.binary")
    np.testing.assert_allclose(again.value, data.value, rtol=5e-16)
    np.testing.assert_array_equal(again.wi, data.wi)
    with pytest.raises(FileError, match="--force"):
        fitter.formats.write(data, tmp_path / "copy.binary")


def test_measurement_of_another_layout_is_not_written_as_a_table(tmp_path):
    (tmp_path / "a.csv").write_text("theta_i,theta_o,phi_o,value\n10,20,0,0.5\n")
    with pytest.raises(UserError, match=r"not laid out as a MERL table.*write_function"):
        fitter.formats.write(fitter.formats.read(tmp_path / "a.csv"), tmp_path / "a.binary")


def test_full_table_is_read_and_evaluated(tmp_path):
    # Oracle: the closed form that was tabulated. Between cells the error is that of linear
    # interpolation, largest in the lobe, where theta_h runs in steps of up to 2 degrees.
    merl.write_function(smooth, tmp_path / "full.binary")
    assert (tmp_path / "full.binary").stat().st_size == 12 + 24 * 90 * 90 * 180
    data = fitter.formats.read(tmp_path / "full.binary")
    assert 1.0e6 < len(data) < 1.3e6
    pairs = np.random.default_rng(7).normal(size=(2, 2000, 3))
    pairs[..., 2] = np.abs(pairs[..., 2]) + 0.3
    wi, wo = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    np.testing.assert_allclose(data.evaluate(wi, wo), smooth(wi, wo), atol=2e-3)
