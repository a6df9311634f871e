"""npz slices at phi_d = 90 degrees."""

from __future__ import annotations

import numpy as np
import pytest

import fitter.formats
from brdf.errors import FileError
from fitter.formats import slices
from fitter.rusinkiewicz import directions


@pytest.fixture
def made_up(tmp_path):
    values = np.random.default_rng(0).uniform(0.1, 5, (4, 6, 3))
    np.savez(tmp_path / "slices.npz", gold=values, brass=2 * values)
    return tmp_path / "slices.npz", values


def test_rows_are_theta_d_and_columns_quadratic_theta_h(made_up):
    # Oracle: the layout as documented, cell by cell.
    path, values = made_up
    data = fitter.formats.read(f"{path}:brass")
    assert "brass" in data.source
    assert data.grid is not None
    assert data.grid.shape == (4, 6)
    np.testing.assert_array_equal(data.grid.scatter(data.value), 2 * values)
    wi, wo = directions((5 / 6) ** 2 * np.pi / 2, 3 / 4 * np.pi / 2, np.pi / 2)
    np.testing.assert_allclose(data.wi[-1], wi, atol=1e-15)
    np.testing.assert_allclose(data.wo[-1], wo, atol=1e-15)


def test_evaluation_is_exact_at_cells_and_ignores_phi_d(made_up):
    # Oracle: the stored numbers, at three values of phi_d.
    data = fitter.formats.read(f"{made_up[0]}:gold")
    np.testing.assert_array_equal(data.evaluate(data.wi, data.wo), data.value)
    wi, wo = directions(0.2, 0.3, np.array([0.0, 1.0, 3.0]))
    value = data.evaluate(wi, wo)
    np.testing.assert_allclose(value, np.repeat(value[:1], 3, 0), rtol=1e-12)


def test_evaluation_between_cells_is_the_bilinear_mean(made_up):
    # Oracle: the four corners, weighted by hand.
    path, values = made_up
    data = fitter.formats.read(f"{path}:gold")
    wi, wo = directions(np.array([(2.25 / 6) ** 2 * np.pi / 2]), 1.5 / 4 * np.pi / 2, 0.7)
    expected = 0.5 * (0.75 * (values[1, 2] + values[2, 2]) + 0.25 * (values[1, 3] + values[2, 3]))
    np.testing.assert_allclose(data.evaluate(wi, wo)[0], expected, rtol=1e-12)


def test_invalid_cells_are_dropped_counted_and_not_interpolated(tmp_path):
    values = np.ones((4, 6, 3))
    values[1, 2, 0] = -1
    values[2, 2, 1] = np.nan
    np.savez(tmp_path / "one.npz", only=values)
    data = fitter.formats.read(tmp_path / "one.npz")  # one member needs no name
    assert dict(data.dropped) == {"not finite": 1, "marked invalid": 1}
    assert len(data) == 22
    wi, wo = directions(np.array([(2.25 / 6) ** 2 * np.pi / 2]), 1.5 / 4 * np.pi / 2, 0.7)
    np.testing.assert_allclose(data.evaluate(wi, wo), 1.0, rtol=1e-12)


def test_measured_slices_are_all_read_whole(shared):
    # Oracle: the arrays themselves; none of the 70 has an invalid cell.
    path = shared / "data" / "merl_slices" / "merl_phid90_slices.npz"
    names = slices.members(path)
    assert len(names) == 70
    with np.load(path) as archive:
        for name in names:
            data = fitter.formats.read(f"{path}:{name}")
            assert len(data) == 8100
            assert not data.dropped
            np.testing.assert_array_equal(data.value, archive[name].reshape(-1, 3))


def test_missing_member_names_the_nearest_ones(made_up):
    with pytest.raises(FileError, match=r"no member `bras`.*`brass`"):
        fitter.formats.read(f"{made_up[0]}:bras")
    with pytest.raises(FileError, match=r"holds 2 materials: gold, brass.*slices.npz:gold"):
        fitter.formats.read(made_up[0])


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.ones((4, 6)), r"float64 of the shape \(4, 6\)"),
        (np.ones((0, 6, 3)), r"shape \(0, 6, 3\)"),
        (np.ones((4, 6, 3), complex), "complex128"),
        (np.array([["x"]]), "<U1"),
        (np.array([{"a": 1}, None], dtype=object), "member `only` cannot be read.*plain array"),
        (np.full((4, 6, 3), np.nan), "no valid cell: of 24 24 are not finite"),
        (np.full((4, 6, 3), -1.0), "no valid cell.*24 negative"),
    ],
)
def test_members_that_are_no_slice_are_refused(tmp_path, array, message):
    np.savez(tmp_path / "bad.npz", only=array)
    with pytest.raises(FileError, match=message):
        fitter.formats.read(tmp_path / "bad.npz")


@pytest.mark.parametrize("part", [0.001, 0.3, 0.9, 0.99])
def test_truncated_archives_are_refused(made_up, part):
    path = made_up[0]
    whole = path.read_bytes()
    path.write_bytes(whole[: max(3, int(len(whole) * part))])
    with pytest.raises(FileError, match="truncated"):
        fitter.formats.read(f"{path}:gold")


def test_damaged_member_is_named(made_up):
    path = made_up[0]
    whole = bytearray(path.read_bytes())
    whole[300:310] = b"\xff" * 10  # inside the numbers of the first member
    path.write_bytes(whole)
    with pytest.raises(FileError, match="member `gold` cannot be read"):
        fitter.formats.read(f"{path}:gold")


@pytest.mark.parametrize("content", [b"tensor_file\0", b"hello, world", b"\x80\x04K\x01."])
def test_files_that_are_no_archive_are_refused(tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)
    with pytest.raises(FileError, match="no npz archive"):
        fitter.formats.read(tmp_path / "bad.npz")


def test_bare_array_and_empty_archive_are_refused(tmp_path):
    np.save(tmp_path / "bare.npy", np.ones((4, 6, 3)))
    (tmp_path / "bare.npy").rename(tmp_path / "bare.npz")
    with pytest.raises(FileError, match="one bare array"):
        fitter.formats.read(tmp_path / "bare.npz")
    np.savez(tmp_path / "none.npz")
    with pytest.raises(FileError, match="holds no member"):
        fitter.formats.read(tmp_path / "none.npz")
