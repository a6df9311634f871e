"""ASTM E1392 text."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.cli.main import cli
from fitter.reflectance import Reflectance

HEAD = 'LAB_NAME somewhere\nSAMPLE_NAME "blue paint"\n\nMEAS_DATE 1999/01/01\n'


def read(tmp_path, text: str | bytes, options: dict[str, str] | None = None) -> Reflectance:
    (tmp_path / "paint.astm").write_bytes(text.encode() if isinstance(text, str) else text)
    return fitter.formats.read(tmp_path / "paint.astm", options)


def test_colours_at_angles_in_radians(tmp_path):
    # Oracle: directions worked out by hand, from pi / 6 at 90 degrees of azimuth and pi / 3 at 180.
    text = (
        HEAD
        + "NUM_POINTS 1\nVARS theta_i,phi_i,theta_s,phi_s,R,G,B\n\n# first\n0.5235987756,1.5707963268,1.0471975512,"
    )
    data = read(tmp_path, text + "3.1415926536,0.1,0.2,0.3\r\n")
    half, root = 0.5, np.sqrt(0.75)
    np.testing.assert_allclose(data.wi, [[0, half, root]], atol=1e-9)
    np.testing.assert_allclose(data.wo, [[-root, 0, half]], atol=1e-9)
    np.testing.assert_allclose(data.value, [[0.1, 0.2, 0.3]])
    assert data.source.startswith("paint.astm (ASTM E1392, angles in radians, mirror direction at 180 degrees, R, G, B")


@pytest.mark.parametrize(
    ("header", "options", "unit"),
    [
        ("", {}, "degrees"),
        ("ANGLE_UNITS Degrees\n", {}, "degrees"),
        ("", {"angles": "degrees"}, "degrees"),
        ("ANGLE_UNITS RADIANS\n", {"angles": "degrees"}, "degrees"),
    ],
)
def test_angles_in_degrees_are_seen_told_or_chosen(tmp_path, header, options, unit):
    # Oracle: the sine of 30 degrees.
    data = read(tmp_path, f"{header}VARS theta_i,theta_s,phi_s,BRDF\n30,60,180,0.1\n", options)
    np.testing.assert_allclose(data.wi[0], [0.5, 0, np.sqrt(0.75)], atol=1e-15)
    assert f"angles in {unit}" in data.source
    assert "all channels from `BRDF`" in data.source


def test_small_angles_are_radians_unless_told_otherwise(tmp_path):
    text = "VARS theta_i,theta_s,phi_s,BRDF\n1,1,0,0.1\n"
    assert "angles in radians" in read(tmp_path, text).source
    assert "angles in degrees" in read(tmp_path, "ANGLE_UNITS deg\n" + text).source
    np.testing.assert_allclose(read(tmp_path, text, {"angles": "degrees"}).wi[0, 0], np.sin(np.radians(1)))


def test_mirror_direction_is_where_the_option_says(tmp_path):
    # Oracle: the half vector of a mirror pair is the normal.
    for mirror, phi in (("180", 180), ("0", 0)):
        data = read(tmp_path, f"VARS theta_i,phi_i,theta_s,phi_s,BRDF\n40,0,40,{phi},0.1\n", {"mirror": mirror})
        half = data.wi + data.wo
        np.testing.assert_allclose(half[0, :2], 0, atol=1e-15)
        assert f"mirror direction at {mirror} degrees" in data.source


def test_xyz_becomes_linear_rec_709(tmp_path):
    # Oracle: the white of D65 (0.3127, 0.3290) is grey; colour-science for another colour. 2e-4: rounded white.
    colour = pytest.importorskip("colour", reason="colours need colour-science")
    rows = [[0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290], [0.3, 0.4, 0.2]]
    lines = "\n".join("10,20,30," + ",".join(map(str, row)) for row in rows)
    data = read(tmp_path, f"VARS theta_i,theta_s,phi_s,X,Y,Z\n{lines}\n")
    np.testing.assert_allclose(data.value[0], 1, rtol=2e-4)
    np.testing.assert_allclose(data.value[1], colour.XYZ_to_RGB(np.array(rows[1]), "ITU-R BT.709"), rtol=1e-9)


def test_spectra_become_colours_or_one_wavelength(tmp_path):
    # Oracle: a flat spectrum is grey of its own height; a single wavelength is its column. Columns in any order.
    nanometres = np.arange(700, 390, -10)
    names = ",".join(f"{nm}nm" for nm in nanometres)
    flat, ramp = ",".join(["0.25"] * 31), ",".join(str(nm / 1000) for nm in nanometres)
    text = f"VARS theta_i,phi_i,theta_s,phi_s,{names}\n10,0,20,30,{flat}\n10,0,20,30,{ramp}\n"
    data = read(tmp_path, text, {"illuminant": "A"})
    np.testing.assert_allclose(data.value[0], 0.25, rtol=1e-12)
    assert data.value[1, 0] > data.value[1, 1] > data.value[1, 2]  # rising towards red
    assert "colour of 31 wavelengths under A" in data.source
    one = read(tmp_path, text, {"wavelength": "550"})
    np.testing.assert_allclose(one.value, [[0.25] * 3, [0.55] * 3])


def test_three_colour_camera_wavelengths_are_named_in_the_order_red_green_blue(tmp_path):
    text = "VARS theta_i,phi_i,theta_s,phi_s,465nm,525nm,630nm\n10,0,20,30,1,2,3\n"
    np.testing.assert_array_equal(read(tmp_path, text, {"wavelength": "630,525,465"}).value, [[3, 2, 1]])
    np.testing.assert_array_equal(read(tmp_path, text).value, [[2, 2, 2]])


def test_dirty_rows_are_dropped_clamped_and_counted(tmp_path):
    rows = ["10,20,30,1,1,1", "10,20,30,1,-1,1", "10,20,30,-1,-1,0", "10,20,30,nan,1,1", "10,95,30,1,1,1"]
    data = read(tmp_path, "VARS theta_i,theta_s,phi_s,R,G,B\n" + "\n".join(rows))
    np.testing.assert_array_equal(data.value, [[1, 1, 1], [1, 0, 1]])
    assert data.clamped == 1
    assert dict(data.dropped) == {"not finite": 1, "below horizon": 1, "negative": 1}


def test_holes_in_wavelengths_that_are_not_used_do_no_harm(tmp_path):
    text = "VARS theta_i,theta_s,phi_s,400nm,550nm\n10,20,30,nan,0.5\n"
    np.testing.assert_array_equal(read(tmp_path, text).value, [[0.5] * 3])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("theta_i,phi_i\n1,2\n", r"no line VARS that names the columns \(2 lines\)"),
        ("LAB x\n" * 1000, "no line VARS"),
        (HEAD + "VARS theta_i,theta_s,phi_s,BRDF\n", "ends with VARS in line 5.*truncated"),
        ("VARS theta_i,theta_s,BRDF\n1,2,3\n", "line 1: VARS lacks `phi_s`"),
        ("VARS theta_i,theta_s,phi_s\n1,2,3\n", "line 1: VARS names no value"),
        ("VARS theta_i,theta_s,phi_s,R,R\n1,2,3,4,5\n", "line 1 names `r` twice"),
        ("VARS theta_i,theta_s,phi_s,R,G\n1,2,3,4,5\n", "names the values r, g.*Supported are R,G,B"),
        ("VARS theta_i,theta_s,phi_s,500nm,G\n1,2,3,4,5\n", "mixes wavelengths with g"),
        ("VARS theta_i,theta_s,phi_s,500nm,500.0nm\n1,2,3,4,5\n", "a wavelength twice"),
        ("VARS theta_i,theta_s,phi_s,BRDF\n1,2,3,x\n", "line 2, column `BRDF`: `x` is no number"),
        ("VARS theta_i,theta_s,phi_s,BRDF\n1,2,3,4\n1,2,3\n", "line 3 has 3 fields for 4 columns"),
        ("VARS theta_i,theta_s,phi_s,BRDF\n95,2,3,1\n", "no usable row: of 1 1 below horizon"),
        ("NUM_POINTS 3\nVARS theta_i,theta_s,phi_s,BRDF\n1,2,3,4\n", "has 1 rows, but NUM_POINTS says 3.*truncated"),
        (f"NUM_POINTS {'9' * 5000}\nVARS theta_i,theta_s,phi_s,B\n1,2,3,4\n", "NUM_POINTS says 999"),
        ("NUM_POINTS some\nVARS theta_i,theta_s,phi_s,BRDF\n1,2,3,4\n", "`NUM_POINTS some`, which is no count"),
        (b"\xff\xfe\x00", "byte 0 is not UTF-8"),
        (b"VARS\0", "is no text"),
    ],
)
def test_errors_name_the_line_and_the_remedy(tmp_path, text, message):
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, text)
    assert "paint.astm" in str(caught.value)


def test_options_of_spectra_are_refused_for_colours(tmp_path):
    with pytest.raises(UserError, match="VARS names no wavelengths"):
        read(tmp_path, "VARS theta_i,theta_s,phi_s,R,G,B\n1,2,3,4,5,6\n", {"illuminant": "A"})


def test_truncation_anywhere_is_an_error_or_a_whole_number_of_rows(tmp_path):
    # Oracle: a cut inside a number cannot be told, one between the fields must be.
    text = "NUM_POINTS 2\nVARS theta_i,theta_s,phi_s,BRDF\n10,20,30,0.5\n11,21,31,0.6\n"
    for end in range(1, len(text)):
        try:
            data = read(tmp_path, text[:end])
        except FileError:
            continue
        assert len(data) == 2


@pytest.mark.parametrize("name", ["a.astm", "a.dat", "a.txt"])
def test_shared_suffixes_are_told_apart_by_content(tmp_path, name):
    (tmp_path / name).write_text(HEAD * 20 + "VARS theta_i,theta_s,phi_s,BRDF\n30,60,180,0.1\n")
    assert fitter.formats.read(tmp_path / name).format == "ASTM E1392"


def test_info_describes_a_file(tmp_path):
    (tmp_path / "a.astm").write_text("VARS theta_i,theta_s,phi_s,BRDF\n30,60,180,0.1\n")
    result = CliRunner().invoke(cli, ["info", str(tmp_path / "a.astm"), "--read", "mirror=0", "--json"])
    assert json.loads(result.output)["format"] == "ASTM E1392"
