"""EXR slices at phi_d = 90 degrees."""

from __future__ import annotations

import json
import pathlib
import struct

import numpy as np
import OpenEXR
import pytest
from click.testing import CliRunner

import fitter.formats
from brdf.errors import FileError
from fitter.cli.main import cli
from fitter.rusinkiewicz import directions

ROWS, COLUMNS = 4, 6


def write(path: pathlib.Path, channels: dict[str, np.ndarray]) -> pathlib.Path:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {name: np.ascontiguousarray(plane) for name, plane in channels.items()}).write(str(path))
    return path


@pytest.fixture
def made_up(tmp_path):
    values = np.random.default_rng(0).uniform(0.1, 5, (ROWS, COLUMNS, 3)).astype(np.float32)
    return write(tmp_path / "felt.exr", {"RGB": values}), values.astype(np.float64)


@pytest.mark.parametrize("theta_h", ["linear", "quadratic"])
@pytest.mark.parametrize(("cells", "offset"), [("centre", 0.5), ("edge", 0.0)])
@pytest.mark.parametrize("theta_d", ["down", "up"])
def test_every_pixel_stands_where_the_options_say(made_up, theta_h, cells, offset, theta_d):
    # Oracle: the layout as documented, pixel by pixel.
    path, values = made_up
    data = fitter.formats.read(path, {"theta_h": theta_h, "cells": cells, "theta_d": theta_d})
    assert len(data) == ROWS * COLUMNS
    for row in range(ROWS):
        for column in range(COLUMNS):
            angle_h = ((column + offset) / COLUMNS) ** (2 if theta_h == "quadratic" else 1) * np.pi / 2
            wi, wo = directions(angle_h, (row + offset) / ROWS * np.pi / 2, np.pi / 2)
            pixel = values[row if theta_d == "down" else ROWS - 1 - row, column]
            np.testing.assert_allclose(data.wi[row * COLUMNS + column], wi, atol=1e-15)
            np.testing.assert_allclose(data.wo[row * COLUMNS + column], wo, atol=1e-15)
            np.testing.assert_array_equal(data.value[row * COLUMNS + column], pixel)
    np.testing.assert_array_equal(data.evaluate(data.wi, data.wo), data.value)
    for said in (f"theta_h {theta_h}", f"theta_d {theta_d}", f"the cells' {cells}"):
        assert said in data.source


def test_evaluation_between_pixels_is_the_bilinear_mean_for_any_phi_d(made_up):
    # Oracle: the four corners, weighted by hand, at centres and linear theta_h.
    path, values = made_up
    data = fitter.formats.read(path)
    wi, wo = directions(2.75 / COLUMNS * np.pi / 2, 2.0 / ROWS * np.pi / 2, np.array([0.0, 0.7, 1.5]))
    expected = 0.5 * (0.75 * (values[1, 2] + values[2, 2]) + 0.25 * (values[1, 3] + values[2, 3]))
    np.testing.assert_allclose(data.evaluate(wi, wo), np.tile(expected, (3, 1)), rtol=1e-9)


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_grey_and_half_precision_are_read(tmp_path, dtype):
    # Oracle: the numbers that were written.
    grey = np.arange(1, 1 + ROWS * COLUMNS).reshape(ROWS, COLUMNS).astype(dtype) / dtype(8)
    data = fitter.formats.read(write(tmp_path / "grey.exr", {"Y": grey}))
    np.testing.assert_array_equal(data.value, np.repeat(grey.reshape(-1, 1).astype(np.float64), 3, 1))


def test_invalid_pixels_are_dropped_counted_and_not_interpolated(tmp_path):
    values = np.ones((ROWS, COLUMNS, 3), np.float32)
    values[1, 2, 0], values[2, 2, 1], values[3, 3, 2] = -1, np.nan, np.inf
    data = fitter.formats.read(write(tmp_path / "bad.exr", {"RGB": values}))
    assert dict(data.dropped) == {"not finite": 2, "marked invalid": 1}
    wi, wo = directions(np.array([2.75 / COLUMNS * np.pi / 2]), 2.0 / ROWS * np.pi / 2, 0.7)
    np.testing.assert_allclose(data.evaluate(wi, wo), 1.0)


def test_measured_slice_as_a_picture_is_the_slice(shared, tmp_path):
    # Oracle: the npz reader on the same numbers, in float32 as EXR holds them.
    path = shared / "data" / "merl_slices" / "merl_phid90_slices.npz"
    with np.load(path) as archive:
        name = archive.files[0]
        values = archive[name].astype(np.float32)
    exact = fitter.formats.read(f"{path}:{name}")
    data = fitter.formats.read(
        write(tmp_path / "slice.exr", {"RGB": values}), {"theta_h": "quadratic", "cells": "edge"}
    )
    np.testing.assert_array_equal(data.wi, exact.wi)
    np.testing.assert_array_equal(data.value, exact.value.astype(np.float32))


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ({"A": np.ones((4, 6), np.float32)}, "has the channels `A`.*R, G, B, or Y"),
        ({"Y": np.full((4, 6), np.nan, np.float32)}, "has no valid cell: of 24 24 are not finite"),
        ({"Y": np.full((4, 6), -1, np.float32)}, "no valid cell.*24 negative"),
    ],
)
def test_pictures_that_are_no_slice_are_refused(tmp_path, channels, message):
    with pytest.raises(FileError, match=message):
        fitter.formats.read(write(tmp_path / "bad.exr", channels))


def test_absurd_size_is_refused_before_anything_is_allocated(made_up):
    whole = bytearray(made_up[0].read_bytes())
    place = whole.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    whole[place : place + 16] = struct.pack("<4i", 0, 0, 99_999, 99_999)
    made_up[0].write_bytes(whole)
    with pytest.raises(FileError, match=r"100000 x 100000 pixels|cannot be read"):
        fitter.formats.read(made_up[0])


@pytest.mark.parametrize(
    "content", [b"\x76\x2f", b"PK\x03\x04 a zip", b"\x76\x2f\x31\x01", b"\x76\x2f\x31\x01" + b"\xff" * 99]
)
def test_wrong_magic_and_damaged_headers_are_refused(tmp_path, content):
    (tmp_path / "bad.exr").write_bytes(content)
    with pytest.raises(FileError, match=r"starts with b|cannot be read by OpenEXR"):
        fitter.formats.read(tmp_path / "bad.exr")


def test_any_truncation_is_an_error_and_never_another(made_up):
    path, _ = made_up
    whole = path.read_bytes()
    for end in [*range(1, 40), *range(40, len(whole), 29), len(whole) - 1]:
        path.write_bytes(whole[:end])
        with pytest.raises(FileError):
            fitter.formats.read(path)


def test_info_describes_a_picture(made_up):
    result = CliRunner().invoke(cli, ["info", str(made_up[0]), "--read", "theta_d=up", "--json"])
    facts = json.loads(result.output)
    assert facts["format"] == "EXR slice"
    assert list(facts["grid"]) == ["theta_d", "theta_h"]
