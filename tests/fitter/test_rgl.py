"""RGL tensors: the container, the definition, and the measured materials."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic_rgl import ORACLE, VARIANTS, fields, write_tensor_file

import fitter.formats
from brdf.errors import FileError, UserError
from fitter.formats._bilinear_warp import BilinearWarp
from fitter.formats._tensor_file import read_tensor_file
from fitter.reflectance import Reflectance

MATERIALS = [
    "aurora_white",
    "cc_green_malachite",
    "cc_iris_purple_gem",
    "cc_nothern_aurora",
    "cg_sunflower",
    "chm_mint",
    "chm_orange",
    "cm_military_green",
    "ilm_solo_m_68",
    "irid_flake_paint1",
    "paper_white",
    "vch_golden_yellow",
]
ISOTROPIC = (np.zeros(1), 1)


@pytest.fixture
def made_up(tmp_path):
    write_tensor_file(tmp_path / "made.bsdf", fields(*ISOTROPIC))
    return tmp_path / "made.bsdf"


def material(shared, name: str):
    return shared / "data" / "rgl_bsdf" / f"{name}_rgb.bsdf"


def half_vectors(data: Reflectance) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the half vector to the normal and, about it, to wi."""
    wm = data.wi + data.wo
    phi = np.arctan2(wm[:, 1], wm[:, 0]) - np.arctan2(data.wi[:, 1], data.wi[:, 0])
    return np.arctan2(np.hypot(wm[:, 0], wm[:, 1]), wm[:, 2]), phi


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize(("incident", "outgoing"), [("wi", "wo"), ("wo", "wi")])
def test_measured_materials_agree_with_the_independent_evaluation(shared, name, incident, outgoing):
    # Oracle: Mitsuba 3.9 `measured` in float32. Medians lie near 1e-6; the tail is float32 azimuths
    # of half vectors near the normal and cumulative sums near 1, up to 1.2e-3 at 95 %.
    with np.load(shared / "oracle" / f"rgl_{name}_rgb.npz") as oracle:
        expected = oracle[f"si_wi_is_{incident}"]
        found = fitter.formats.read(material(shared, name)).evaluate(oracle[incident], oracle[outgoing])
    np.testing.assert_array_equal(found == 0, expected == 0)
    lit = expected != 0
    difference = np.abs(found[lit] / expected[lit] - 1)
    assert np.median(difference) < 4e-6
    assert np.percentile(difference, 95) < 2e-3


@pytest.mark.parametrize("variant", VARIANTS)
def test_anisotropic_files_agree_with_the_independent_evaluation(tmp_path, variant):
    # Oracle: Mitsuba 3.9 `measured` in float32 on the same made-up tensors (synthetic_rgl.py), with
    # phi_i whole, half and a quarter, and with the factor in M. 2e-4: float32 where channels cancel.
    path = tmp_path / "made.bsdf"
    write_tensor_file(path, fields(*VARIANTS[variant]))
    data = fitter.formats.read(path)
    assert "anisotropic" in data.source
    with np.load(ORACLE) as oracle:
        found = data.evaluate(oracle["wi"], oracle["wo"])
        scale = np.abs(oracle[variant]).max(1, keepdims=True)
        np.testing.assert_allclose(found / scale, oracle[variant] / scale, atol=2e-4)
        assert np.median(np.abs(found / oracle[variant] - 1)) < 2e-6


@pytest.mark.parametrize("name", ["paper_white", "chm_mint", "cg_sunflower"])
def test_samples_are_the_values_that_evaluate_interpolates(shared, name):
    # Oracle: the interpolant, which was held to Mitsuba. Left out is what has several nodes for
    # one pair of directions: half vectors on the normal, and phi = -pi, which is also pi.
    data = fitter.formats.read(material(shared, name))
    theta_m, phi_m = half_vectors(data)
    one = (theta_m > 1e-9) & (np.abs(np.abs(phi_m) - np.pi) > 1e-9)
    assert one.mean() > 0.9
    found = np.maximum(data.evaluate(data.wi[one], data.wo[one]), 0)
    np.testing.assert_allclose(found, data.value[one], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", MATERIALS)
def test_samples_are_those_that_the_file_marks_as_valid(shared, name):
    # Oracle: the file's own field `valid`, one bit per node, which the reader does not look at.
    # Three of these files store it inverted.
    path = material(shared, name)
    contents = read_tensor_file(path)
    valid = np.unpackbits(contents["valid"]).reshape(len(contents["theta_i"]), -1)
    valid = valid[:-1]  # incidence at the horizon is left out
    if valid.mean() < 0.5:
        valid = 1 - valid
    data = fitter.formats.read(path)
    assert len(data) == valid.sum()
    theta_i = np.arctan2(data.wi[:, 0], data.wi[:, 2])
    expected = np.repeat(contents["theta_i"][:-1], valid.sum(1).astype(int))
    np.testing.assert_allclose(theta_i, expected, atol=1e-7)
    assert sum(data.dropped.values()) + len(data) == contents["rgb"].size // 3


def test_negative_channels_are_clamped_for_the_fit_and_kept_by_evaluate(shared):
    data = fitter.formats.read(material(shared, "cc_green_malachite"))
    assert data.clamped > 1000
    assert data.value.min() == 0
    assert data.evaluate(data.wi, data.wo).min() < 0


def test_isotropic_material_does_not_change_when_it_is_turned(shared):
    # Oracle: a law. Incidence along the normal and half vectors on it are left out: they have no
    # azimuth but zero, and the measured numbers do differ around them. So is the seam phi = -pi.
    data = fitter.formats.read(material(shared, "paper_white"))
    theta_m, phi_m = half_vectors(data)
    one = (theta_m > 1e-6) & (data.wi[:, 2] < 1) & (np.abs(np.abs(phi_m) - np.pi) > 1e-9)
    wi, wo = data.wi[one], data.wo[one]
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    turned = data.evaluate(wi @ turn.T, wo @ turn.T)
    np.testing.assert_allclose(turned, data.evaluate(wi, wo), rtol=1e-8)


def test_warp_and_its_inverse_undo_each_other():
    # Oracle: the round trip, on a density that is empty along one border.
    density = np.random.default_rng(0).uniform(0.0, 1.0, (2, 9, 7))
    density[:, :, :2] = 0
    warp = BilinearWarp(density, (np.array([0.0, 1.0]),))
    u_x, u_y = np.linspace(0, 1, 11), np.linspace(0, 1, 13)
    for number in range(2):
        x, y = warp.warp(number, u_x, u_y)
        back = warp.invert(x.ravel(), y.ravel(), (np.full(x.size, float(number)),))
        np.testing.assert_allclose(back[0].reshape(x.shape), np.broadcast_to(u_x, x.shape), atol=1e-12)
        np.testing.assert_allclose(back[1].reshape(x.shape), u_y[:, None] + 0 * x, atol=1e-12)
        assert x.min() > 0.16  # the border of the support, not of the square


def test_inverse_warp_is_the_integral_of_the_density():
    # Oracle: midpoint quadrature of the bilinear density, 400 steps a side.
    density = np.random.default_rng(1).uniform(0.1, 1.0, (5, 4))
    warp = BilinearWarp(density[None], (np.zeros(1),))
    steps = (np.arange(400) + 0.5) / 400
    rows = np.array([np.interp(steps * 3, range(4), row) for row in density])
    fine = np.array([np.interp(steps * 4, range(5), column) for column in rows.T]).T
    one = (np.zeros(1),)
    _, u_y = warp.invert(np.array([0.3]), np.array([0.6]), one)
    assert u_y[0] == pytest.approx(fine[:240].sum() / fine.sum(), abs=1e-5)
    u_x, _ = warp.invert(np.array([0.3]), np.array([0.6]), one)
    row = (fine[239] + fine[240]) / 2
    assert u_x[0] == pytest.approx(row[:120].sum() / row.sum(), abs=1e-5)


def test_flat_spectra_are_grey(tmp_path):
    # Oracle: the same tensors as rgb. Every wavelength holds the red plane, so that any observer
    # and illuminant must see it in all three channels.
    pytest.importorskip("colour", reason="colours of spectra need colour-science")
    contents = fields(*ISOTROPIC)
    red = contents["rgb"][:, :, :1]
    write_tensor_file(tmp_path / "rgb.bsdf", contents | {"rgb": np.repeat(red, 3, 2)})
    del contents["rgb"]
    contents["spectra"] = np.repeat(red, 20, 2)
    contents["wavelengths"] = np.linspace(400, 700, 20).astype("<f4")
    write_tensor_file(tmp_path / "spectral.bsdf", contents)
    grey, spectral = (fitter.formats.read(tmp_path / f"{n}.bsdf") for n in ("rgb", "spectral"))
    np.testing.assert_allclose(spectral.value, grey.value, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("illuminant", ["D65", "A", "e", "FL2", "D50"])
def test_spectra_become_the_colour_that_an_independent_computation_gives(tmp_path, illuminant):
    # Oracle: colour-science's own chain sd_to_XYZ (summed at 1 nm) and XYZ_to_RGB with Bradford's adaptation, on the
    # spectrum that every node holds. 2e-4: its Rec. 709 white is D65 rounded to four decimals.
    colour = pytest.importorskip("colour", reason="colours of spectra need colour-science")
    nm = np.arange(360.0, 831.0, 5)
    spectrum = 0.5 + 0.3 * np.sin(nm / 40) + 0.1 * np.cos(nm / 11)
    contents = fields(*ISOTROPIC)
    shape = contents.pop("rgb").shape
    contents["spectra"] = np.tile(spectrum[:, None, None], (*shape[:2], 1, *shape[3:])).astype("<f8")
    contents["wavelengths"] = nm.astype("<f4")
    contents["jacobian"] = np.array([0], "u1")  # M is f cos_o itself
    write_tensor_file(tmp_path / "spectral.bsdf", contents)
    data = fitter.formats.read(tmp_path / "spectral.bsdf", {"illuminant": illuminant})
    fine = np.arange(360.0, 831.0)
    name = illuminant.upper()
    shape = colour.SpectralShape(360, 830, 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    light = colour.SDS_ILLUMINANTS[name].copy().align(shape)
    seen = {"cmfs": observer, "illuminant": light, "method": "Integration"}
    reflectance = colour.SpectralDistribution(np.interp(fine, nm, spectrum), fine)
    xyz = colour.sd_to_XYZ(reflectance, **seen) / 100
    white = colour.sd_to_XYZ(colour.SpectralDistribution(np.ones(len(fine)), fine), **seen)
    rgb = colour.XYZ_to_RGB(xyz, "ITU-R BT.709", colour.XYZ_to_xy(white), chromatic_adaptation_transform="Bradford")
    expected = rgb / data.wo[:, 2:]
    np.testing.assert_allclose(data.value, np.maximum(expected, 0), rtol=2e-4, atol=2e-4 * rgb.max())
    assert f"colour of 95 wavelengths under {name}" in data.source
    assert np.ptp(rgb) > 0.1  # the spectrum is not grey


def test_one_or_three_wavelengths_can_be_chosen(tmp_path):
    # Oracle: the planes themselves, as an RGB file.
    contents = fields(*ISOTROPIC)
    contents["rgb"] = np.abs(contents["rgb"])
    write_tensor_file(tmp_path / "rgb.bsdf", contents)
    rgb = fitter.formats.read(tmp_path / "rgb.bsdf")
    contents["spectra"] = contents.pop("rgb")[:, :, ::-1]
    contents["wavelengths"] = np.array([465, 525, 630], "<f4")
    write_tensor_file(tmp_path / "spectral.bsdf", contents)
    three = fitter.formats.read(tmp_path / "spectral.bsdf", {"wavelength": "630,525,465"})
    np.testing.assert_allclose(three.value, rgb.value, rtol=1e-12)
    assert "630, 525, 465 nm as red, green, blue" in three.source
    one = fitter.formats.read(tmp_path / "spectral.bsdf", {"wavelength": "465"})
    np.testing.assert_allclose(one.value, np.repeat(rgb.value[:, 2:], 3, 1), rtol=1e-12)
    grey = fitter.formats.read(tmp_path / "spectral.bsdf")
    np.testing.assert_allclose(grey.value, np.repeat(rgb.value[:, 1:2], 3, 1), rtol=1e-12)
    assert "all channels from 525 nm, since wavelengths of 465-630 nm do not cover 450-650 nm" in grey.source


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"illuminant": "D66"}, r"`illuminant = D66` is not one that colour-science knows.*`D6"),
        ({"illuminant": "A", "wavelength": "550"}, "exclude each other"),
        ({"wavelength": "green"}, "`wavelength = green` is not one number of nm"),
        ({"wavelength": "500,550"}, "is not one number of nm, or three"),
        ({"wavelength": "nan"}, "is not one number of nm"),
        ({"wavelength": "444"}, "`wavelength = 444` nm was not measured. The nearest is 450 nm"),
    ],
)
def test_options_of_spectra_that_do_not_fit_are_refused(tmp_path, options, message):
    contents = fields(*ISOTROPIC)
    contents["spectra"] = np.repeat(contents.pop("rgb"), 7, 2)
    contents["wavelengths"] = np.linspace(400, 800, 21).astype("<f4") + (np.arange(21) == 2) * np.float32(10)  # 450
    write_tensor_file(tmp_path / "made.bsdf", contents)
    with pytest.raises(UserError, match=message):
        fitter.formats.read(tmp_path / "made.bsdf", options)


def test_options_of_spectra_are_refused_for_colours(made_up):
    with pytest.raises(UserError, match=r"holds colours, not spectra. Leave `wavelength` and `illuminant` out"):
        fitter.formats.read(made_up, {"illuminant": "A"})


def test_spectra_that_miss_the_visible_range_are_no_colour(tmp_path):
    contents = fields(*ISOTROPIC)
    contents["spectra"] = contents.pop("rgb")
    contents["wavelengths"] = np.array([0.4, 0.5, 0.6], "<f4")  # micrometres
    write_tensor_file(tmp_path / "made.bsdf", contents)
    with pytest.raises(UserError, match=r"asks for a colour, but wavelengths of 0.4-0.6 nm do not cover 450-650 nm"):
        fitter.formats.read(tmp_path / "made.bsdf", {"illuminant": "D65"})
    assert "0.4-0.6 nm do not cover" in fitter.formats.read(tmp_path / "made.bsdf").source


@pytest.mark.parametrize(
    ("end", "message"),
    [
        (5, "byte 5, inside the magic"),
        (13, "inside the version"),
        (16, "inside the number of fields"),
        (25, "inside the header of field 1"),
        (33, "inside the header of field `description`"),
        (60, "inside field `description`"),
        (600, "inside field `sigma`"),
        (-1, "inside field `jacobian`"),
    ],
)
def test_truncated_files_are_refused_with_field_and_byte(made_up, end, message):
    made_up.write_bytes(made_up.read_bytes()[:end])
    with pytest.raises(FileError, match=message) as caught:
        fitter.formats.read(made_up)
    assert str(made_up) in str(caught.value)


def test_any_truncation_is_an_error_and_never_another(made_up):
    whole = made_up.read_bytes()
    for end in [*range(1, 400, 7), *range(400, len(whole), 997)]:
        made_up.write_bytes(whole[:end])
        with pytest.raises(FileError):
            fitter.formats.read(made_up)


@pytest.mark.parametrize(
    ("place", "new", "message"),
    [
        (0, b"TENSOR", "starts with b'TENSOR"),
        (12, b"\x09", "version 9.0"),
        (14, b"\xff\xff\xff\xff", "claims to hold 4294967295 fields"),
        (31, b"\xff\xff", "and 65535 axes"),
        (33, b"\xee", "the type 238"),
        (34, b"\xff" * 8, "inside field `description`"),
        (42, b"\xff" * 8, "inside field `description`"),
    ],
)
def test_damaged_headers_are_refused_without_allocating(made_up, place, new, message):
    # A size of 2^64 - 1 elements must be held to the length of the file, not asked of memory.
    # The header of the first field, `description`: name at byte 20, axes 31, type 33, start 34, size 42.
    whole = bytearray(made_up.read_bytes())
    whole[place : place + len(new)] = new
    made_up.write_bytes(whole)
    with pytest.raises(FileError, match=message):
        fitter.formats.read(made_up)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vndf": None}, "has no field `vndf`; it has `description`"),
        ({"rgb": None}, "has no field `rgb` or `spectra`"),
        ({"ndf": np.ones(8, "<f4")}, r"`ndf` has the shape \(8,\), not 2 axes"),
        ({"sigma": np.full((8, 16), np.nan, "<f4")}, "`sigma` holds numbers that are not finite"),
        ({"sigma": np.full((8, 16), -1, "<f4")}, "`sigma` holds negative"),
        ({"theta_i": np.array([0, 1], "<f4")}, r"`vndf` has the shape .* must start with \(1, 2\)"),
        ({"theta_i": np.arange(5, 0, -1).astype("<f4")}, "`theta_i` does not ascend"),
        ({"rgb": np.ones((1, 5, 1, 8, 8), "<f4")}, r"`rgb` has the shape .*\(1, 5, 3\)"),
        ({"rgb": np.full((1, 5, 3, 8, 8), np.nan, "<f4")}, "no usable node.*not finite"),
        ({"vndf": np.zeros((1, 5, 16, 16), "<f4")}, "`vndf`: slice 0 integrates to nothing"),
    ],
)
def test_fields_that_do_not_fit_are_named(tmp_path, changes, message):
    contents = {k: v for k, v in (fields(*ISOTROPIC) | changes).items() if v is not None}
    write_tensor_file(tmp_path / "made.bsdf", contents)
    with pytest.raises(FileError, match=message):
        fitter.formats.read(tmp_path / "made.bsdf")


def test_nodes_that_are_not_finite_are_dropped_and_counted(tmp_path):
    contents = fields(*ISOTROPIC)
    contents["rgb"] = contents["rgb"].copy()
    contents["rgb"][0, 1, 2, 3, 4] = np.nan
    write_tensor_file(tmp_path / "made.bsdf", contents)
    data = fitter.formats.read(tmp_path / "made.bsdf")
    assert data.dropped["not finite"] == 1
    assert np.isfinite(data.value).all()
