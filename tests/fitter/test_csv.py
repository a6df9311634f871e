"""CSV files of scattered samples."""

from __future__ import annotations

import numpy as np
import pytest

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.reflectance import Reflectance


def read(tmp_path, text: str | bytes, name: str = "mine.csv") -> Reflectance:
    content = text.encode() if isinstance(text, str) else text
    (tmp_path / name).write_bytes(content)
    return fitter.formats.read(tmp_path / name)


def test_angles_in_degrees_become_directions(tmp_path):
    # Oracle: directions worked out by hand.
    data = read(tmp_path, "# mine\ntheta_i,phi_i,theta_o,phi_o,r,g,b\n30,90,60,180,0.1,0.2,0.3\n")
    half, root = 0.5, np.sqrt(0.75)
    np.testing.assert_allclose(data.wi, [[0, half, root]], atol=1e-15)
    np.testing.assert_allclose(data.wo, [[-root, 0, half]], atol=1e-15)
    np.testing.assert_array_equal(data.value, [[0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(data.weight, [1.0])
    assert data.source == "mine.csv (CSV)"


def test_one_channel_stands_for_three_and_phi_i_may_be_left_out(tmp_path):
    data = read(tmp_path, "theta_i,theta_o,phi_o,value,weight\n30,60,180,0.1,2\n")
    np.testing.assert_array_equal(data.value, [[0.1, 0.1, 0.1]])
    np.testing.assert_array_equal(data.weight, [2.0])
    assert data.wi[0, 1] == 0
    assert "one channel" in data.source


def test_vectors_in_any_order_with_other_separators_and_a_byte_order_mark(tmp_path):
    text = "Weight;r;g;b;wi_x;wi_y;wi_z;wo_x;wo_y;wo_z\r\n2;1;2;3;0;0;1;0,577;0;0\r\n"
    with pytest.raises(FileError, match=r"line 2, column `wo_x`: `0,577` is no number"):
        read(tmp_path, text)
    for separator in (";", "\t", ",", " ; "):
        names = ["weight", "r", "g", "b", "wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"]
        rows = [names, ["2", "1", "2", "3", "0", "0", "1", "0.577", "0.577", "0.577"]]
        text = "\r\n".join(separator.join(row) for row in rows)
        data = read(tmp_path, b"\xef\xbb\xbf" + text.encode())
        np.testing.assert_array_equal(data.value, [[1, 2, 3]])
        np.testing.assert_allclose(data.wo, np.full((1, 3), 3**-0.5))
        np.testing.assert_array_equal(data.weight, [2.0])


def test_unusable_rows_are_dropped_and_counted(tmp_path):
    rows = ["10,20,30,1", "nan,20,30,1", "10,20,30,inf", "10,95,30,1", "90,20,30,1", "10,20,30,-1"]
    data = read(tmp_path, "theta_i,theta_o,phi_o,value\n" + "\n".join(rows))
    assert len(data) == 1
    assert dict(data.dropped) == {"not finite": 2, "below horizon": 2, "negative": 1}
    with pytest.raises(FileError, match="no usable row: of 5 2 not finite, 2 below horizon"):
        read(tmp_path, "theta_i,theta_o,phi_o,value\n" + "\n".join(rows[1:]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("theta_i,theta_0,phi_o,value\n1,2,3,4", r"line 1: `theta_0` is no known column.*`theta_o`"),
        ("# x\n\ntheta_i,phi_o,value\n1,2,3", r"line 3 lacks `theta_o`\."),
        ("theta_i,theta_o,phi_o,r,g\n1,2,3,4,5", "lacks `b`"),
        ("theta_i,theta_o,phi_o\n1,2,3", "lacks `r`, `g`, `b`"),
        ("wi_x,wi_y,wi_z,theta_o,phi_o,value\n1,2,3,4,5,6", "mixes"),
        ("theta_i,theta_o,phi_o,r,g,b,value\n1,2,3,4,5,6,7", "mixes"),
        ("theta_i,theta_i,phi_o,value\n1,2,3,4", "names `theta_i` twice"),
        ("theta_i,theta_o,phi_o,value\n1,2,3,4\n1,2,3\n", "line 3 has 3 fields for 4 columns"),
        ("theta_i,theta_o,phi_o,value\n1,2,3,x", "line 2, column `value`: `x` is no number"),
        ("theta_i,theta_o,phi_o,value\n1,2,,4", "line 2, column `phi_o`: `` is no number"),
        ("theta_i,theta_o,phi_o,value,weight\n1,2,3,4,-1", "line 2: `weight = -1` is negative"),
        ("theta_i,theta_o,phi_o,value,sigma\n1,2,3,4,0", "line 2: `sigma = 0` is not positive"),
        ("theta_i,theta_o,phi_o,value,sigma,sigma_r\n1,2,3,4,5,6", "mixes sigma_r, sigma_g, sigma_b with sigma"),
        ("theta_i,theta_o,phi_o,value,sigma_r\n1,2,3,4,5", "lacks `sigma_g`, `sigma_b`"),
        ("theta_i,theta_o,phi_o,value,weight\n1,2,3,4,0", "weight 0 in every row"),
        ("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,value\n0,0,1,0,0,2,1", "line 2: `wo` has the length 2"),
        ("# only a comment\n", "has no header line.*theta_i, phi_i"),
        ("theta_i,theta_o,phi_o,value\n", "a header and no rows"),
        (b"\xff\xfe\x00\x01garbage", "byte 0 is not UTF-8"),
        (b"theta_i\0", "is no text"),
    ],
)
def test_errors_name_the_line_and_the_remedy(tmp_path, text, message):
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, text)
    assert "mine.csv" in str(caught.value)


def test_truncation_anywhere_is_an_error_or_a_whole_number_of_rows(tmp_path):
    # Oracle: a cut inside a number cannot be told, one between the fields must be.
    text = "theta_i,theta_o,phi_o,value\n10,20,30,0.5\n11,21,31,0.6\n"
    for end in range(len(text)):
        try:
            data = read(tmp_path, text[:end])
        except FileError:
            continue
        assert len(data) == text[:end].rstrip("\n").count("\n")


@pytest.mark.parametrize("name", ["out.csv", "out.tsv"])
def test_written_samples_come_back_bit_by_bit(tmp_path, name):
    # Oracle: the round trip.
    rng = np.random.default_rng(0)
    pairs = rng.normal(size=(2, 50, 3))
    pairs[..., 2] = np.abs(pairs[..., 2]) + 0.01
    wi, wo = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    weight = rng.uniform(0, 2, 50)
    data = Reflectance(wi, wo, rng.exponential(size=(50, 3)), "a\ntest", weight=weight)
    fitter.formats.write(data, tmp_path / name)
    again = fitter.formats.read(tmp_path / name)
    for field in ("wi", "wo", "value", "weight"):
        np.testing.assert_array_equal(getattr(again, field), getattr(data, field))
    with pytest.raises(FileError, match="--force"):
        fitter.formats.write(data, tmp_path / name)


@pytest.mark.parametrize("shape", [(50,), (50, 3)])
def test_standard_errors_come_back_bit_by_bit(tmp_path, shape):
    # Oracle: the round trip.
    rng = np.random.default_rng(1)
    up = np.tile([0.0, 0.0, 1.0], (50, 1))
    data = Reflectance(up, up, rng.exponential(size=(50, 3)), "a test", sigma=rng.uniform(0.01, 1, shape))
    fitter.formats.write(data, tmp_path / "out.csv")
    np.testing.assert_array_equal(fitter.formats.read(tmp_path / "out.csv").sigma, data.sigma)


def test_standard_errors_follow_the_rows_that_are_kept(tmp_path):
    data = read(tmp_path, "theta_i,theta_o,phi_o,value,sigma\n1,2,3,4,0.1\n1,2,3,-4,0.2\n1,2,3,4,nan\n1,2,3,4,0.4")
    np.testing.assert_array_equal(data.sigma, [0.1, 0.4])
    assert dict(data.dropped) == {"not finite": 1, "negative": 1}


def test_weights_of_one_are_not_written(tmp_path):
    data = read(tmp_path, "theta_i,theta_o,phi_o,value\n10,20,30,0.5\n")
    fitter.formats.write(data, tmp_path / "out.csv")
    assert "weight" not in (tmp_path / "out.csv").read_text()


def test_text_beyond_any_measurement_is_refused_before_it_is_read(tmp_path):
    # A sparse file of 2 GiB takes no space.
    with open(tmp_path / "big.csv", "wb") as file:
        file.write(b"theta_i,theta_o,phi_o,value\n")
        file.truncate(1 << 31)
    with pytest.raises(FileError, match=r"is 2147483648 bytes long.*up to 1073741824"):
        fitter.formats.read(tmp_path / "big.csv")


def test_scattered_samples_cannot_be_evaluated(tmp_path):
    data = read(tmp_path, "theta_i,theta_o,phi_o,value\n10,20,30,0.5\n")
    with pytest.raises(UserError, match="scattered"):
        data.evaluate(data.wi, data.wo)


def test_a_polar_angle_beyond_half_a_turn_is_named_with_its_line(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("theta_i,theta_o,phi_o,value\n10,20,180,0.5\n400,20,180,0.5\n")
    with pytest.raises(FileError, match=r"line 3: `theta_i = 400`"):
        fitter.formats.read(path)
