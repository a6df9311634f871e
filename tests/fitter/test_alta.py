"""ALTA files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import fitter.formats
from brdf.errors import FileError
from fitter.cli.main import cli
from fitter.formats._alta_parametrizations import PARAMETRIZATIONS
from fitter.reflectance import Reflectance
from fitter.rusinkiewicz import half_difference


def read(tmp_path, text: str | bytes, options: dict[str, str] | None = None, name: str = "felt.alta") -> Reflectance:
    (tmp_path / name).write_bytes(text.encode() if isinstance(text, str) else text)
    return fitter.formats.read(tmp_path / name, options)


def alta(name: str, rows: str, output: str = "INV_STERADIAN", values: int = 1) -> str:
    return f"# a comment\n#DIM {PARAMETRIZATIONS[name][0]} {values}\n#PARAM_IN  {name}\n#PARAM_OUT {output}\n{rows}\n"


def angles_of(data: Reflectance) -> dict[str, float]:
    """Every angle that ALTA's `from_cartesian` knows, of one sample: V is the viewer, L the light."""
    v, w = data.wo[0], data.wi[0]
    half = half_difference(data.wo, data.wi)  # ALTA's difference vector is the viewer's
    azimuth = np.arctan2(v[1], v[0]) - np.arctan2(w[1], w[0])
    return {
        "TH": half.theta_h[0],
        "PH": half.phi_h[0],
        "TD": half.theta_d[0],
        "PD": half.phi_d[0],
        "TL": np.arccos(w[2]),
        "PL": np.arctan2(w[1], w[0]),
        "TV": np.arccos(v[2]),
        "PV": np.arctan2(v[1], v[0]),
        "DPHI": -azimuth,  # of the light, seen from the viewer
        "COS_LV": v @ w,
        "X": np.arccos(v[2]) * np.cos(azimuth),
        "Y": np.arccos(v[2]) * np.sin(azimuth),
    }


CASES = [
    ("RUSIN_TH_PH_TD_PD", (0.3, 0.5, 0.7, 1.1), {"TH": 0.3, "PH": 0.5, "TD": 0.7, "PD": 1.1}),
    ("RUSIN_TH_PH_TD", (0.3, 0.5, 0.7), {"TH": 0.3, "PH": 0.5, "TD": 0.7, "PD": 0.0}),
    ("RUSIN_TH_TD_PD", (0.3, 0.7, 1.1), {"TH": 0.3, "TD": 0.7, "PD": 1.1}),
    ("RUSIN_TH_TD", (0.3, 0.7), {"TH": 0.3, "TD": 0.7, "PD": np.pi / 2}),
    ("COS_TH_TD", (0.8, 0.9), {"TH": np.arccos(0.8), "TD": np.arccos(0.9), "PD": 0.0}),
    ("COS_TH", (0.8,), {"TH": np.arccos(0.8), "TD": 0.0}),
    ("COS_TLV", (0.8,), {"COS_LV": 0.8, "TL": 0.0}),
    ("SPHERICAL_TL_PL_TV_PV", (0.3, 0.5, 0.7, 1.1), {"TL": 0.3, "PL": 0.5, "TV": 0.7, "PV": 1.1}),
    ("ISOTROPIC_TV_TL_DPHI", (0.3, 0.5, 0.7), {"TV": 0.3, "TL": 0.5, "DPHI": 0.7}),
    ("ISOTROPIC_TL_TV_PROJ_DPHI", (0.3, 0.4, 0.2), {"TL": 0.3, "X": 0.4, "Y": 0.2}),
    ("ISOTROPIC_TV_PROJ_DPHI", (0.4, 0.2), {"TL": 0.0, "TV": np.hypot(0.4, 0.2)}),
]


@pytest.mark.parametrize(("name", "numbers", "expected"), CASES)
def test_angles_come_back_from_the_directions(tmp_path, name, numbers, expected):
    # Oracle: the angles computed back from the two vectors by their definitions, as ALTA's `from_cartesian` does.
    data = read(tmp_path, alta(name, " ".join(map(str, numbers)) + " 0.5"))
    found = angles_of(data)
    assert {key: found[key] for key in expected} == pytest.approx(expected, abs=1e-9)
    np.testing.assert_array_equal(data.value, [[0.5] * 3])
    assert data.source == f"felt.alta (ALTA, {name}, INV_STERADIAN)"


def test_every_parametrization_is_tested():
    assert {name for name, _, _ in CASES} | {"CARTESIAN"} == set(PARAMETRIZATIONS)


def test_vectors_have_the_viewer_first(tmp_path):
    data = read(tmp_path, alta("CARTESIAN", "0.6 0 0.8 0 0 1 0.5"))
    np.testing.assert_allclose(data.wo, [[0.6, 0, 0.8]])
    np.testing.assert_allclose(data.wi, [[0, 0, 1]])
    with pytest.raises(FileError, match="line 5: the light vector has the length 2"):
        read(tmp_path, alta("CARTESIAN", "0.6 0 0.8 0 0 2 0.5"))


def test_published_file_is_read(tmp_path):
    # Oracle: the first and last rows of ALTA's data/pink-felt-1d.alta (MPL 2), whose columns are cosine and colour.
    rows = (
        "0.999984567305837\t0.109704419970512\t0.0794405192136765\t0.0616232864558697\t\n"
        "0.105117666245532\t0.14767487347126\t0.120244853198528\t0.125162586569786\t\n"
    )
    data = read(tmp_path, alta("COS_TH", rows, "RGB_COLOR", 3))
    np.testing.assert_allclose(data.wi, data.wo)
    np.testing.assert_allclose(data.wi[:, 2], [0.999984567305837, 0.105117666245532], rtol=1e-12)
    np.testing.assert_array_equal(data.value[1], [0.14767487347126, 0.120244853198528, 0.125162586569786])


@pytest.mark.parametrize(("cosine", "factor"), [("light", np.cos(0.3)), ("view", np.cos(0.7))])
def test_cosine_factor_is_taken_out(tmp_path, cosine, factor):
    # Oracle: 0.5 / sr times the cosine that the option names.
    text = alta("SPHERICAL_TL_PL_TV_PV", f"0.3 0 0.7 1 {0.5 * factor}", "INV_STERADIAN_COSINE_FACTOR")
    data = read(tmp_path, text, {"cosine": cosine})
    np.testing.assert_allclose(data.value, 0.5, rtol=1e-12)
    assert f"the {cosine} direction's cosine taken out" in data.source


def test_xyz_becomes_linear_rec_709(tmp_path):
    # Oracle: colour-science.
    colour = pytest.importorskip("colour", reason="colours need colour-science")
    data = read(tmp_path, alta("RUSIN_TH_TD", "0.1 0.2 0.3 0.4 0.2", "XYZ_COLOR", 3))
    np.testing.assert_allclose(data.value[0], colour.XYZ_to_RGB(np.array([0.3, 0.4, 0.2]), "ITU-R BT.709"), rtol=1e-9)


def binary(rows: np.ndarray, order: str = "little", vs: int = 0) -> bytes:
    head = (
        "#DIM 2 1\n#PARAM_IN  RUSIN_TH_TD\n#PARAM_OUT INV_STERADIAN\n#FORMAT binary\n#VERSION 0\n"
        f"#PRECISION ieee754-double\n#SAMPLE_COUNT {len(rows)}\n#VS {vs}\n#ENDIAN {order}\n#BEGIN_STREAM\n"
    )
    return head.encode() + rows.astype("<f8" if order == "little" else ">f8").tobytes() + b"\n#END_STREAM\n"


@pytest.mark.parametrize("order", ["little", "big"])
@pytest.mark.parametrize("vs", [0, 2])
def test_binary_stream_holds_the_same_as_text(tmp_path, order, vs):
    # Oracle: the text reader. Ten is the byte of a line feed: the stream is not taken for lines.
    rows = np.random.default_rng(0).uniform(0, 0.7, (10, 3 + vs))
    whole = read(tmp_path, binary(rows, order, vs))
    text = read(tmp_path, alta("RUSIN_TH_TD", "\n".join(" ".join(map(repr, row)) for row in rows[:, :3].tolist())))
    for field in ("wi", "wo", "value"):
        np.testing.assert_array_equal(getattr(whole, field), getattr(text, field))
    assert ("2 more columns not used" in whole.source) == (vs == 2)


def test_confidence_intervals_of_text_are_not_used(tmp_path):
    data = read(tmp_path, "#VS 1\n" + alta("RUSIN_TH_TD", "0.1 0.2 0.5 0.01"))
    np.testing.assert_array_equal(data.value, [[0.5] * 3])
    assert "1 more columns not used" in data.source


def test_dirty_rows_are_dropped_clamped_and_counted(tmp_path):
    rows = ["0.5 1 1 1", "0.6 1 -1 1", "0.7 -1 -1 -1", "1.5 1 1 1", "0.8 nan 1 1", "-0.5 1 1 1"]
    data = read(tmp_path, alta("COS_TH", "\n".join(rows), "RGB_COLOR", 3))
    np.testing.assert_array_equal(data.value, [[1, 1, 1], [1, 0, 1]])
    assert data.clamped == 1
    assert dict(data.dropped) == {"not finite": 2, "below horizon": 1, "negative": 1}


@pytest.mark.parametrize("name", ["a.alta", "a.dat", "a.txt", "a.ALTA"])
def test_suffixes_of_text_are_known(tmp_path, name):
    assert read(tmp_path, alta("RUSIN_TH_TD", "0.1 0.2 0.5"), name=name).format == "ALTA"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n", "no line `#DIM`"),
        ("#DIM 2 1\n1 2 3\n", "no line `#PARAM_IN`"),
        ("#DIM 2 1\n#PARAM_IN RUSIN_TH_TD\n1 2 3\n", "no line `#PARAM_OUT`"),
        (
            "#DIM 2 1\n#PARAM_IN STARK_2D\n#PARAM_OUT INV_STERADIAN\n1 2 3\n",
            "line 2: `#PARAM_IN STARK_2D` is not supported",
        ),
        (
            "#DIM 2 1\n#PARAM_IN RUSIN_TH_TD\n#PARAM_OUT ENERGY\n1 2 3\n",
            "`#PARAM_OUT ENERGY` is not supported.*XYZ_COLOR",
        ),
        ("#DIM 999999999 3\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n1\n", r"line 1: `#DIM 999999999 3` does not fit"),
        ("#DIM 2 2\n#PARAM_IN RUSIN_TH_TD\n#PARAM_OUT INV_STERADIAN\n1\n", "must be `#DIM 2 1 or 3`"),
        ("#DIM\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n1\n", "`#DIM ` does not fit"),
        (alta("RUSIN_TH_TD", ""), "a header and no rows"),
        (alta("RUSIN_TH_TD", "0.1 0.2"), "line 5 has 2 numbers, but `#DIM 2 1` asks for 3"),
        (alta("RUSIN_TH_TD", "0.1 0.2 3\n0.1 x 3"), "line 6, column `2`: `x` is no number"),
        (alta("RUSIN_TH_TD", "0.1 0.2 3\n0.1 0.2"), "line 6 has 2 fields for 3 columns"),
        (alta("RUSIN_TH_TD", "0.1 0.2 3\n45 0.2 3"), "line 6: `45` is no polar angle in radians"),
        (alta("COS_TH", "7 1"), "no usable row: of 1 1 not finite"),
        (binary(np.ones((4, 3)) / 2)[:-40], r"ends at byte \d+, but 4 samples of 3 numbers start at byte"),
        (binary(np.ones((4, 3))).replace(b"COUNT 4", b"COUNT 99999999999999"), "99999999999999 samples"),
        (binary(np.ones((4, 3))).replace(b"COUNT 4", b"COUNT -4"), "`#SAMPLE_COUNT -4`, which is no count"),
        (binary(np.ones((4, 3))).replace(b"#VS 0", b"#VS 9"), "`#VS 9`; 0 to 2 are known"),
        (binary(np.ones((4, 3))).replace(b"little", b"middle"), "`middle` endian"),
        (binary(np.ones((4, 3)) * 9), r"byte \d+: `9` is no polar angle"),
        (binary(np.ones((4, 3)))[:130], "is not supported|no line|no rows|no count"),
        (b"\xff\xfe", "byte 0 is not UTF-8"),
        (b"#DIM\0", "is no text"),
    ],
)
def test_errors_name_the_place_and_the_remedy(tmp_path, text, message):
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, text)
    assert "felt.alta" in str(caught.value)


def test_any_truncation_of_a_stream_is_an_error(tmp_path):
    whole = binary(np.full((3, 3), 0.5))
    for end in range(1, len(whole) - len(b"\n#END_STREAM\n")):
        with pytest.raises(FileError):
            read(tmp_path, whole[:end])


def test_info_describes_a_file(tmp_path):
    (tmp_path / "a.alta").write_text(alta("RUSIN_TH_TD", "0.1 0.2 0.5"))
    result = CliRunner().invoke(cli, ["info", str(tmp_path / "a.alta"), "--json"])
    assert json.loads(result.output)["source"] == "a.alta (ALTA, RUSIN_TH_TD, INV_STERADIAN)"
