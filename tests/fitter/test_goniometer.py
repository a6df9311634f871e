"""NIST-style goniometer CSV."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.cli.main import cli
from fitter.reflectance import Reflectance

HEAD = "lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11\n"


def read(tmp_path, text: str | bytes, options: dict[str, str] | None = None) -> Reflectance:
    (tmp_path / "gonio.csv").write_bytes(text.encode() if isinstance(text, str) else text)
    return fitter.formats.read(tmp_path / "gonio.csv", options)


@pytest.fixture
def ptfe(shared):
    return shared / "data" / "ptfe" / "PTFE.data.csv"


@pytest.mark.parametrize(("wavelength", "um"), [(None, "0.532"), ("351", "0.351"), ("1064", "1.064")])
def test_measured_ptfe_is_read_as_an_independent_parser_reads_it(ptfe, wavelength, um):
    # Oracle: the csv module and the definition of spherical coordinates, row by row.
    data = fitter.formats.read(ptfe, {} if wavelength is None else {"wavelength": wavelength})
    with open(ptfe, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["lambda"] == um]
    assert len(data) == len(rows) == 1824
    assert not data.dropped
    expected_wi, expected_wo, expected = [], [], []
    for row in rows:
        theta_i, theta_r, phi_r = (math.radians(float(row[name])) for name in ("thetai", "thetar", "phir"))
        expected_wi.append([math.sin(theta_i), 0, math.cos(theta_i)])
        sine = math.sin(theta_r)
        expected_wo.append([sine * math.cos(phi_r), sine * math.sin(phi_r), math.cos(theta_r)])
        expected.append([float(row["f_r11"])] * 3)
    np.testing.assert_allclose(data.wi, expected_wi, atol=1e-15)
    np.testing.assert_allclose(data.wo, expected_wo, atol=1e-15)
    np.testing.assert_array_equal(data.value, expected)


def test_measured_ptfe_scatters_forward_and_is_nearly_white_in_the_visible(ptfe):
    # Oracle: physics of a rough dielectric, and the literature: PTFE reflects more than 95 % of visible light, so that
    # its BRDF lies near 1 / pi.
    data = fitter.formats.read(ptfe)
    grazing = (data.wi[:, 2] < 0.3) & (data.wo[:, 2] < 0.4)
    opposite = np.einsum("ij,ij->i", data.wi[:, :2], data.wo[:, :2]) < 0
    assert data.value[grazing & opposite].mean() > 1.15 * data.value[grazing & ~opposite].mean()
    assert abs(np.median(data.value) - 1 / np.pi) < 0.05


def test_report_says_why_laser_lines_are_grey(ptfe):
    source = fitter.formats.read(ptfe).source
    assert "all channels from 532 nm, since the gap" in source
    assert "of wavelengths 351, 532, 633, 1064 nm" in source
    with pytest.raises(UserError, match="asks for a colour, but the gap"):
        fitter.formats.read(ptfe, {"illuminant": "D65"})


def test_light_comes_from_minus_x_where_thetai_is_negative(tmp_path):
    # Oracle: the mirror pair of the PTFE data, whose half vector is the normal.
    data = read(tmp_path, HEAD + "0.532,-60,0,60,0,0.4,0\n")
    np.testing.assert_allclose((data.wi + data.wo)[0], [0, 0, 1], atol=1e-15)
    assert data.wi[0, 0] < 0


def test_dense_spectra_become_colours_over_directions_in_any_order(tmp_path):
    # Oracle: flat spectra are grey of their own height, whatever the illuminant.
    pytest.importorskip("colour", reason="colours of spectra need colour-science")
    pairs = [(10, 0.1), (20, 0.2), (30, 0.3)]
    rows = [
        f"{nm},-45,0,{theta},{phi},{value},0" for nm in range(400, 701, 20) for theta, value in pairs for phi in (0, 90)
    ]
    np.random.default_rng(0).shuffle(rows)
    data = read(tmp_path, HEAD + "\n".join(rows), {"illuminant": "FL2"})
    assert len(data) == 6
    theta = np.degrees(np.arccos(data.wo[:, 2]))
    np.testing.assert_allclose(data.value, np.repeat(theta[:, None] / 100, 3, 1), rtol=1e-9)
    assert "colour of 16 wavelengths under FL2, of wavelengths 400 to 700 (16) nm" in data.source


def test_directions_without_every_wavelength_and_repeated_rows_are_counted(tmp_path):
    rows = ["0.6,0,0,10,0,3,0", "0.5,0,0,10,0,2,0", "0.4,0,0,10,0,1,0", "0.6,0,0,20,0,5,0", "0.5,0,0,10.0002,0,9,0"]
    data = read(tmp_path, HEAD + "\n".join(rows), {"wavelength": "600,500,400"})
    np.testing.assert_array_equal(data.value, [[3, 2, 1]])
    assert dict(data.dropped) == {"repeated": 1, "not at every wavelength": 1}


def test_dirty_rows_are_dropped_and_counted(tmp_path):
    rows = ["0.5,0,0,10,0,1,nan", "0.5,0,0,11,0,nan,0", "nan,0,0,12,0,1,0", "0.5,0,0,95,0,1,0", "0.5,0,0,13,0,-1,0"]
    data = read(tmp_path, HEAD + "\n".join(rows))
    assert len(data) == 1
    assert dict(data.dropped) == {"not finite": 2, "below horizon": 1, "negative": 1}


def test_other_spellings_of_the_header_and_nanometres(tmp_path):
    data = read(tmp_path, "# NIST\nThetaI,PhiI,ThetaR,PhiR,fr11,Lambda\n-10,0,20,30,0.3,633\n")
    np.testing.assert_array_equal(data.value, [[0.3] * 3])
    assert "633 nm" in data.source


def test_plain_csv_is_still_plain_csv(tmp_path):
    assert read(tmp_path, "theta_i,theta_o,phi_o,value\n10,20,30,1\n").format == "CSV"
    assert read(tmp_path, HEAD + "0.5,0,0,10,0,1,0\n").format == "goniometer CSV"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD, "has no rows"),
        ("lambda,thetai,phi,thetar,phir\n1,2,3,4,5\n", "line 1 lacks `fr11`"),
        ("lambda,thetai,thetai,phi,thetar,phir,fr11\n1,2,3,4,5,6,7\n", "line 1 names `thetai` twice"),
        (HEAD + "0.5,0,0,10,0,x,0\n", "line 2, column `fr11`: `x` is no number"),
        (HEAD + "0.5,0,0,10,0,1\n", "line 2 has 6 fields for 7 columns"),
        (HEAD + "0.5,0,0,10,0,1,0\n-0.5,0,0,10,0,1,0\n", "line 3: `lambda = -0.5` is not positive"),
        (HEAD + "nan,0,0,10,0,1,0\n", "no usable row: of 1 1 not finite"),
        (HEAD + "0.5,0,0,99,0,1,0\n", "no usable row: of 1 1 below horizon"),
        (
            HEAD + "".join(f"{1 + i / 1000},0,0,{i % 80},0,1,0\n" for i in range(3000)),
            "holds 3000 different wavelengths",
        ),
        (HEAD.encode() + b"\xff", "is not UTF-8"),
    ],
)
def test_errors_name_the_line_and_the_remedy(tmp_path, text, message):
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, text)
    assert "gonio.csv" in str(caught.value)


def test_info_describes_measured_ptfe(ptfe):
    result = CliRunner().invoke(cli, ["info", str(ptfe), "--read", "wavelength=633", "--json"])
    facts = json.loads(result.output)
    assert facts["samples"] == 1824
    assert "all channels from 633 nm" in facts["source"]
