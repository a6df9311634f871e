"""`Reflectance`, the registry of formats and the summary."""

from __future__ import annotations

import json

import numpy as np
import pytest

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.reflectance import Grid, Reflectance
from fitter.summary import summarise

UP = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
GREY = np.full((2, 3), 0.25)


def make(**changes) -> Reflectance:
    return Reflectance(**({"wi": UP, "wo": UP, "value": GREY, "source": "a test"} | changes))


def test_arrays_are_read_only_and_the_caller_keeps_his():
    value = GREY.copy()
    data = make(value=value)
    with pytest.raises(ValueError, match="read-only"):
        data.value[0] = 1
    value[0] = 1
    assert len(data) == 2
    np.testing.assert_array_equal(data.weight, [1, 1])


def test_nearly_unit_directions_are_normalised_and_exact_ones_kept():
    # Oracle: 0.577 in all three is 0.06 % short of unit length.
    wi = np.array([[0.577, 0.577, 0.577], [0.6, 0.0, 0.8]])
    data = make(wi=wi)
    np.testing.assert_allclose(np.linalg.norm(data.wi, axis=1), 1.0, rtol=1e-15)
    np.testing.assert_array_equal(data.wi[1], wi[1])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wi": UP * 2}, r"length of `wi` is not 1 .*`2`.*Pass unit vectors"),
        ({"wo": UP * [1, 1, -1]}, "`wo` z lies below the horizon"),
        ({"wi": np.full((2, 3), np.nan)}, "length of `wi`"),
        ({"wi": np.zeros((2, 2))}, r"shape \(2, 2\).*Pass \(n, 3\)"),
        ({"value": GREY * np.nan}, "`value` is not finite in 6 places"),
        ({"value": -GREY}, r"`value` is negative in 6 places, first `-0.25` in row 0"),
        ({"value": GREY[:1]}, r"with the same n"),
        ({"weight": np.zeros(2)}, "Every `weight` is 0"),
        ({"weight": np.array([1.0, -1.0])}, "`weight` is negative"),
        ({"weight": np.ones(3)}, r"Pass \(2,\)"),
        ({"sigma": np.array([1.0, 0.0])}, "`sigma` is not positive and finite in 1 places, first `0` in row 1"),
        ({"sigma": np.array([1.0, np.inf])}, "`sigma` is not positive and finite"),
        ({"sigma": np.ones((2, 2))}, r"`sigma` has the shape \(2, 2\)\. Pass \(2,\) or \(2, 3\)"),
        ({"wi": UP[:0], "wo": UP[:0], "value": GREY[:0], "dropped": {"negative": 7}}, "7 negative"),
        ({"grid": Grid({"theta_h": np.arange(3.0)}, np.arange(3))}, "one cell per sample"),
    ],
)
def test_what_cannot_be_a_measurement_is_refused(changes, message):
    with pytest.raises(UserError, match=message):
        make(**changes)


def test_grid_puts_values_back_and_leaves_the_rest_open():
    grid = Grid({"theta_h": np.arange(2.0), "theta_d": np.arange(2.0)}, np.array([3, 0]))
    full = grid.scatter(np.array([1.0, 2.0]))
    np.testing.assert_array_equal(full, [[2, np.nan], [np.nan, 1]])
    assert grid.scatter(GREY).shape == (2, 2, 3)
    with pytest.raises(UserError, match="leaves the grid of 4 cells"):
        Grid(grid.axes, np.array([4]))
    with pytest.raises(UserError, match="3 rows for 2 samples"):
        grid.scatter(np.zeros(3))


def test_selection_counts_what_it_leaves_out():
    grid = Grid({"theta_h": np.arange(2.0)}, np.arange(2))
    data = make(dropped={"negative": 3}, grid=grid).select(np.array([False, True]), "beyond 80 deg")
    assert dict(data.dropped) == {"negative": 3, "beyond 80 deg": 1}
    assert data.grid is not None
    np.testing.assert_array_equal(data.grid.index, [1])
    with pytest.raises(UserError, match=r"no usable sample.*2 beyond"):
        data.select(np.array([False]), "beyond 80 deg")


@pytest.mark.parametrize("sigma", [np.array([0.1, 0.2]), np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])])
def test_selection_carries_the_standard_errors(sigma):
    data = make(sigma=sigma).select(np.array([False, True]), "a reason")
    np.testing.assert_array_equal(data.sigma, sigma[1:])
    assert make().select(np.array([False, True]), "a reason").sigma is None


def test_evaluation_is_zero_below_the_horizon_and_asks_the_format_above():
    data = make(interpolant=lambda wi, wo: np.full((len(wi), 3), -0.5))
    wi = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, -0.8]])
    np.testing.assert_array_equal(data.evaluate(wi, UP), [[-0.5] * 3, [0.0] * 3])
    with pytest.raises(UserError, match="2 rows and `wo` 1"):
        data.evaluate(UP, UP[:1])


def test_scattered_samples_have_no_value_in_between():
    with pytest.raises(UserError, match=r"scattered.*brdf fit"):
        make().evaluate(UP, UP)


def test_summary_is_plain_json():
    # Oracle: directions at 0 and at asin(0.6) degrees.
    grid = Grid({"theta_h": np.radians([0.0, 45.0])}, np.arange(2))
    summary = json.loads(json.dumps(summarise(make(grid=grid, dropped={"negative": 1}))))
    assert summary["samples"] == 2
    assert summary["dropped"] == {"negative": 1}
    assert summary["angles_deg"]["theta_i"] == pytest.approx([0.0, np.degrees(np.arcsin(0.6))])
    assert summary["value"]["g"]["50%"] == 0.25
    assert summary["grid"]["theta_h"]["last_deg"] == pytest.approx(45.0)
    assert summary["interpolates"] is False
    assert summary["standard_errors"] is False
    assert summarise(make(sigma=np.ones(2)))["standard_errors"] is True
    assert summarise(make())["grid"] is None


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gold.xyz", b"1 2 3", r"suffix `.xyz`.*\.csv.*\.binary \(MERL\)|\.binary \(MERL\).*\.csv"),
        ("gold", b"tensor_file\0\1\0", r"without a suffix.*looks like RGL: rename it"),
        ("gold.binary", b"", "is empty"),
    ],
)
def test_unusable_files_are_named_with_what_is_supported(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=message) as caught:
        fitter.formats.read(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_missing_file_suggests_its_neighbour_and_a_folder_is_refused(tmp_path):
    (tmp_path / "gold.binary").write_bytes(b"x")
    with pytest.raises(FileError, match=r"does not exist.*Did you mean `.*gold.binary`"):
        fitter.formats.read(tmp_path / "gold.binry")
    with pytest.raises(FileError, match="is a folder"):
        fitter.formats.read(tmp_path)


def test_unknown_options_and_choices_are_refused(tmp_path):
    (tmp_path / "gold.binary").write_bytes(b"x" * 99)
    with pytest.raises(UserError, match=r"`cell` is not an option of the MERL reader.*`cells`"):
        fitter.formats.read(tmp_path / "gold.binary", {"cell": "edge"})
    with pytest.raises(UserError, match=r"`cells = middle` is not allowed.*`edge`, `centre`"):
        fitter.formats.read(tmp_path / "gold.binary", {"cells": "middle"})


def test_writing_an_unknown_suffix_names_the_known_ones(tmp_path):
    with pytest.raises(FileError, match=r"\.binary, \.csv"):
        fitter.formats.write(make(), tmp_path / "out.bsdf")


def test_every_format_declares_what_the_registry_needs():
    names = [format.NAME for format in fitter.formats.formats()]
    assert {"MERL", "RGL", "CSV", "npz slices", "UTIA", "ASTM E1392", "goniometer CSV", "ALTA", "EXR slice"} <= set(
        names
    )
    for format in fitter.formats.formats():
        assert all(suffix.startswith(".") and suffix.islower() for suffix in format.SUFFIXES)
        assert format.DESCRIPTION
        assert isinstance(format.sniff(b""), bool)


def test_member_is_split_off_only_where_a_format_has_members(tmp_path):
    odd = tmp_path / "a:b.npz"
    odd.write_bytes(b"")
    assert fitter.formats.split_member("x/slices.npz:brass")[1] == "brass"
    assert fitter.formats.split_member("C:gold.binary")[1] is None
    assert fitter.formats.split_member(odd)[1] is None
