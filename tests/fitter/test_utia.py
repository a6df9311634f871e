"""UTIA tables."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.cli.main import cli
from fitter.formats import utia
from fitter.reflectance import Reflectance

STEP_T, STEP_P = np.radians(15), np.radians(7.5)


def direction(theta: float, phi: float) -> np.ndarray:
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def flat_index(plane: int, theta_i: int, phi_i: int, theta_v: int, phi_v: int) -> int:
    """Where the readers of Sztrajman, ALTA and dj_brdf look in the file."""
    rows, columns = 6 * 48, 6 * 48
    return plane * rows * columns + columns * (48 * theta_i + phi_i) + 48 * theta_v + phi_v


@pytest.fixture(scope="module")
def made_up(tmp_path_factory):
    numbers = np.random.default_rng(0).uniform(0.01, 1, 3 * 6 * 48 * 6 * 48)
    path = tmp_path_factory.mktemp("utia") / "m001.bin"
    numbers.tofile(path)
    return path, numbers


def smooth(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return (0.1 + 0.1 * wi[:, 2:] * wo[:, 2:] + 0.02 * wi[:, :1] + 0.01 * wo[:, 1:2]) * [1.0, 0.5, 0.2]


def test_every_number_stands_where_the_public_readers_look(made_up):
    # Oracle: their index formula, and the angles worked out cell by cell.
    path, numbers = made_up
    data = fitter.formats.read(path)
    assert len(data) == 6 * 48 * 6 * 48
    assert data.grid is not None
    rng = np.random.default_rng(1)
    for _ in range(60):
        ti, tv, pi, pv = rng.integers(6), rng.integers(6), rng.integers(48), rng.integers(48)
        sample = flat_index(0, ti, pi, tv, pv)
        np.testing.assert_allclose(data.wi[sample], direction(ti * STEP_T, pi * STEP_P), atol=1e-15)
        np.testing.assert_allclose(data.wo[sample], direction(tv * STEP_T, pv * STEP_P), atol=1e-15)
        np.testing.assert_array_equal(data.value[sample], [numbers[flat_index(c, ti, pi, tv, pv)] for c in range(3)])


def test_evaluation_is_the_quadrilinear_mean_across_the_seam_of_the_azimuth(made_up):
    # Oracle: the sixteen corners, weighted one by one.
    path, numbers = made_up
    data = fitter.formats.read(path)
    rng = np.random.default_rng(2)
    at = rng.uniform([0, 0, 0, 0], [5, 48, 5, 48], (40, 4))
    at[:10, 1] = rng.uniform(47, 48, 10)
    at[10:20, 3] = rng.uniform(47, 48, 10)
    wi = np.array([direction(a * STEP_T, b * STEP_P) for a, b, _, _ in at])
    wo = np.array([direction(c * STEP_T, d * STEP_P) for _, _, c, d in at])
    expected = np.zeros((40, 3))
    for row, place in enumerate(at):
        low = place.astype(int)
        for corner in np.ndindex(2, 2, 2, 2):
            share = np.prod(np.where(corner, place - low, 1 - (place - low)))
            ti, pi, tv, pv = (low + corner) % [99, 48, 99, 48]
            expected[row] += share * np.array([numbers[flat_index(c, ti, pi, tv, pv)] for c in range(3)])
    np.testing.assert_allclose(data.evaluate(wi, wo), expected, rtol=1e-9)


def test_evaluation_is_constant_beyond_75_degrees(made_up):
    # Oracle: the module's text; the last cell's own number.
    data = fitter.formats.read(made_up[0])
    wi, wo = np.array([direction(np.radians(89), 0.0)]), np.array([direction(np.radians(30), 0.0)])
    expected = [made_up[1][flat_index(c, 5, 0, 2, 0)] for c in range(3)]
    np.testing.assert_allclose(data.evaluate(wi, wo)[0], expected, rtol=1e-12)


def test_azimuths_of_the_normal_share_the_weight_of_one_direction(made_up):
    # Oracle: 5 polar angles of 48 azimuths and one direction along the normal, for each end.
    weight = fitter.formats.read(made_up[0]).weight
    assert weight.sum() == pytest.approx((5 * 48 + 1) ** 2, rel=1e-12)
    assert weight.max() == 1


def test_encoded_values_are_decoded_as_srgb_after_the_division_by_140(tmp_path):
    # Oracle: colour-science's own sRGB decoding of number / 140, times 100 (dj_brdf); 140 itself is 100 / sr.
    colour = pytest.importorskip("colour", reason="the oracle is colour-science")
    numbers = np.geomspace(1e-3, 500, utia.BYTES // 8)
    numbers[0] = 140
    numbers.tofile(tmp_path / "m.bin")
    data = fitter.formats.read(tmp_path / "m.bin", {"values": "encoded"})
    expected = 100 * colour.cctf_decoding(numbers / 140, "sRGB").reshape(3, -1).T
    np.testing.assert_allclose(data.value, expected, rtol=1e-12)
    assert data.value[0, 0] == pytest.approx(100)
    assert "values encoded" in data.source
    low = np.full((3, utia.CELLS), 1.0)
    low.tofile(tmp_path / "low.bin")
    dark = fitter.formats.read(tmp_path / "low.bin", {"values": "encoded"}).value[0, 0]
    assert 1 / dark == pytest.approx(140 * 12.92 / 100, rel=1e-12)


def test_report_tells_how_much_light_is_reflected(tmp_path):
    # Oracle: a Lambertian BRDF of 0.2 reflects 0.2 pi; one of 1 reflects pi, more than there is.
    for value, said in ((0.2, "at most 0.628 of the light)"), (1.0, "3.14 of the light: more than there is, perhaps")):
        np.full(3 * utia.CELLS, value).tofile(tmp_path / "m.bin")
        assert said in fitter.formats.read(tmp_path / "m.bin").source
    assert "0.174 of the light)" in fitter.formats.read(tmp_path / "m.bin", {"values": "encoded"}).source


@pytest.mark.parametrize("values", ["stored", "encoded"])
def test_negative_numbers_are_clamped_and_holes_dropped_and_counted(tmp_path, values):
    numbers = np.full((3, utia.CELLS), 0.2)
    numbers[1, 60000] = -0.1
    numbers[2, 70100] = np.nan
    numbers[0, 71000] = np.inf
    numbers.tofile(tmp_path / "m.bin")
    data = fitter.formats.read(tmp_path / "m.bin", {"values": values})
    assert data.clamped == 1
    assert dict(data.dropped) == {"not finite": 2}
    assert data.value[60000, 1] == 0
    found = data.evaluate(data.wi[60000:60001], data.wo[60000:60001])[0]
    assert found[1] == pytest.approx(-found[0] / 2)
    hole = divmod(70100 // 288, 48), divmod(70100 % 288, 48)
    np.testing.assert_allclose(data.evaluate(*(direction(t * STEP_T, p * STEP_P)[None] for t, p in hole)), np.nan)


def test_written_tables_come_back_bit_by_bit_and_refuse_other_layouts(tmp_path):
    # Oracle: the round trip.
    utia.write_function(smooth, tmp_path / "a.bin")
    data = fitter.formats.read(tmp_path / "a.bin")
    fitter.formats.write(data, tmp_path / "b.bin")
    assert (tmp_path / "a.bin").read_bytes() == (tmp_path / "b.bin").read_bytes()
    np.testing.assert_allclose(data.value, smooth(data.wi, data.wo), rtol=1e-15)
    with pytest.raises(FileError, match="--force"):
        fitter.formats.write(data, tmp_path / "b.bin")
    with pytest.raises(UserError, match="lacks 1 of 82944 cells"):
        fitter.formats.write(data.select(np.arange(len(data)) > 0, "test"), tmp_path / "c.bin")
    scattered = Reflectance(data.wi[:2], data.wo[:2], data.value[:2], "scattered")
    with pytest.raises(UserError, match=r"not laid out as a UTIA table.*write_function"):
        fitter.formats.write(scattered, tmp_path / "c.bin")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\0" * 100, r"is 100 bytes long.*takes 1990656.*truncated"),
        (b"\0" * (utia.BYTES - 1), "1990655 bytes long.*truncated"),
        (b"\0" * (utia.BYTES + 8), "another format"),
        (np.full(3 * utia.CELLS, np.nan).tobytes(), "no valid cell: none of 82944 is finite"),
    ],
)
def test_files_of_another_length_or_without_a_number_are_refused(tmp_path, content, message):
    (tmp_path / "bad.bin").write_bytes(content)
    with pytest.raises(FileError, match=message):
        fitter.formats.read(tmp_path / "bad.bin")


def test_only_numbers_look_like_a_table(made_up):
    assert utia.sniff(made_up[0].read_bytes()[:4096])
    for text in (b"theta_i,theta_o,phi_o,value\n1,2,3,4\n" * 9, b"tensor_file\0\1\0" * 9, b"", b"\0" * 64):
        assert not utia.sniff(text)


def test_info_describes_a_table(made_up):
    result = CliRunner().invoke(cli, ["info", str(made_up[0]), "--read", "values=encoded", "--json"])
    facts = json.loads(result.output)
    assert facts["format"] == "UTIA"
    assert facts["interpolates"] is True
    assert facts["grid"]["phi_o"] == {"size": 48, "first_deg": 0.0, "last_deg": pytest.approx(352.5)}
