"""How different a fit looks."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from synthetic import measure

import fitter
from brdf.errors import FileError, UserError
from brdf.integrate import evaluate_in_chunks, sphere
from brdf.material import from_dict
from fitter import judge as judging
from fitter.judge import delta_e_itp, judge, render
from fitter.plot_judgement import plot_judgement
from fitter.reflectance import Reflectance

# What `brdf fit` found on blue acrylic with the log loss: colours that cancel in the mean over channels make it brown.
BROWN = {
    "base_color": [0.08715, 0.05646, 0.05758],
    "metallic": 0.29945,
    "specular": 0.000706,
    "specular_tint": 1.0,
    "roughness": 0.19051,
    "anisotropic": 1.0,
    "rotation": 1.5707963,
    "clearcoat": 0.43723,
    "clearcoat_gloss": 0.99578,
}
BLUE = {
    "lambert": {"albedo": [0.02558, 0.04872, 0.12398]},
    "ggx": {"f0": [0.00418, 0.003685, 0.003598], "alpha": 0.0065},
}


def lit(alpha: float, albedo: float = 0.3, f0: float = 0.04):
    return from_dict(
        {"model": "lambert+ggx", "parameters": {"lambert": {"albedo": albedo}, "ggx": {"alpha": alpha, "f0": f0}}}
    ).brdf


def matte(albedo):
    return from_dict({"model": "lambert", "parameters": {"lambert": {"albedo": albedo}}}).brdf


def defined_everywhere(model, hole=None, calls=None) -> Reflectance:
    """A measurement of a model whose interpolant knows all values, but none where `hole` of (wi, wo) is true."""

    def interpolant(wi, wo):
        if calls is not None:
            calls.append(len(wi))
        value = evaluate_in_chunks(model, wi, wo)
        return value if hole is None else np.where(hole(wi, wo)[:, None], np.nan, value)

    up = np.array([[0.0, 0.0, 1.0]])
    return Reflectance(wi=up, wo=up, value=np.ones((1, 3)), source="made up", interpolant=interpolant)


@pytest.fixture(scope="module")
def fine_scene():
    """The judge's sphere with four times as many directions."""
    lights = judging._lights()
    return sphere(lights, np.radians(judging.THETA_MAX_DEG), polar=64, around=96), judging._scene()[1]


def test_the_colour_difference_is_that_of_colour_science():
    # Oracle: colour-science's chain of functions.
    import colour

    rng = np.random.default_rng(3)
    a = 10 ** rng.uniform(-2, 3, (200, 3))
    b = a * np.exp(rng.normal(0, 0.3, (200, 3)))
    spaces = colour.RGB_COLOURSPACES["ITU-R BT.709"], colour.RGB_COLOURSPACES["ITU-R BT.2020"]
    encoded = [colour.RGB_to_ICtCp(colour.RGB_to_RGB(rgb, *spaces)) for rgb in (a, b)]
    expected = colour.difference.delta_E_ITP(*encoded)
    # The matrix of Rec. ITU-R BT.2087 has four decimals.
    np.testing.assert_allclose(delta_e_itp(a, b), expected, rtol=3e-3, atol=0.02)


def test_the_published_pair_of_colours_has_its_published_difference():
    # Oracle: the example of colour-science's documentation, 1.42657228, in its own code values, after decoding.
    import colour

    codes = [0.4885468072, -0.04739350675, 0.07475401302], [0.4899203231, -0.04567508203, 0.07361341775]
    a, b = (np.linalg.solve(judging._REC2020, colour.ICtCp_to_RGB(np.array(code))) for code in codes)
    np.testing.assert_allclose(delta_e_itp(a, b), 1.42657228, rtol=1e-5)


def test_reference_white_is_encoded_as_58_percent():
    # Oracle: Rec. ITU-R BT.2408 gives 58 % PQ for 203 cd/m2.
    np.testing.assert_allclose(judging._perceptual(np.full(3, 203.0)), 0.58, atol=2e-3)


def test_a_perfect_fit_makes_no_difference_and_the_white_sphere_shows_the_reference_white():
    # Oracle: identity, and the exposure as documented.
    data = defined_everywhere(matte(1.0))
    found = judge(matte(1.0), data)
    assert (found.kind, found.mean, found.maximum, found.left_out) == ("sphere", 0, 0, 0)
    assert found.judged == 2048
    pictures = render(matte(1.0), data)
    np.testing.assert_allclose(pictures.measured.max(), 203, rtol=1e-6)
    # The key light makes the upper left the brightest, and the lower left and the lower right dark.
    quarter = pictures.measured[..., 0].reshape(32, 4, 16).mean(axis=(0, 2))
    assert quarter[1] > quarter[0] > max(quarter[2], quarter[3])


def test_the_difference_grows_with_the_error_in_colour_brightness_and_gloss():
    # Oracle: order; and the perceptual quantizer's own step for a darker grey, which is the same everywhere to a third.
    data = defined_everywhere(lit(0.1))
    for worse in ((lit(0.11), lit(0.15), lit(0.3)), (lit(0.1, 0.31), lit(0.1, 0.35), lit(0.1, 0.6))):
        means = [judge(model, data).mean for model in worse]
        assert 0 < means[0] < means[1] < means[2]
    grey = defined_everywhere(matte(0.4))
    step = delta_e_itp(np.full(3, 40.0), np.full(3, 30.0))
    np.testing.assert_allclose(judge(matte(0.3), grey).mean, step, rtol=0.1)
    tinted = judge(matte([0.4, 0.4, 0.3]), grey)
    assert tinted.mean > 5


@pytest.mark.parametrize(
    ("alpha", "f0", "albedo"), [(0.01, 0.04, 0.2), (0.01, 0.9, 0.0), (0.1, 0.9, 0.0), (0.5, 0.5, 0.1)]
)
def test_the_judgement_is_stable_when_the_light_is_sampled_more_finely(monkeypatch, fine_scene, alpha, f0, albedo):
    # Oracle: four times as many directions of light for each pixel.
    truth, model = lit(alpha, albedo, f0), lit(1.2 * alpha, 0.9 * albedo, f0)
    coarse = judge(model, defined_everywhere(truth))
    monkeypatch.setattr(judging, "_scene", lambda: fine_scene)
    refined = judge(model, defined_everywhere(truth))
    np.testing.assert_allclose(coarse.mean, refined.mean, rtol=5e-3)
    np.testing.assert_allclose(coarse.percentile_95, refined.percentile_95, rtol=0.02)
    np.testing.assert_allclose(coarse.maximum, refined.maximum, rtol=0.02)


def test_values_that_were_not_measured_are_left_out_of_both_pictures():
    # Oracle: the judgement without the hole, of a model that is wrong only there.
    def grazing(wi, wo):
        return wi[:, 2] < 0.2

    data = defined_everywhere(lit(0.3), grazing)
    assert judge(lit(0.3), data).maximum == 0

    def rim(wi, wo):
        return wo[:, 2] < 0.5

    found = judge(lit(0.3), defined_everywhere(lit(0.3), rim))
    # The rim's rings, three quarters of a sine, of the disk.
    np.testing.assert_allclose(found.left_out / 2048, 1 - 0.75 / np.sin(np.radians(80)) ** 2, atol=0.04)
    assert found.judged + found.left_out == 2048
    assert f"{found.left_out} of 2048 left out" in found.sentence()


def test_a_measurement_with_few_values_is_judged_by_its_samples():
    # Oracle: the colour difference of each sample's patch, one by one.
    def most(wi, wo):
        return wi[:, 2] < 0.9

    model = lit(0.3)
    hollow = judge(model, defined_everywhere(model, most))
    assert (hollow.kind, hollow.judged) == ("samples", 1)
    data = measure(lit(0.2), count=500)
    found = judge(model, data)
    assert (found.kind, found.judged) == ("samples", 500)
    scale = 203 * np.pi * data.wi[:, 2:3]
    shown = [np.clip(scale * v, 0.005, 1000) for v in (data.value, evaluate_in_chunks(model, data.wi, data.wo))]
    np.testing.assert_allclose(found.mean, np.mean([delta_e_itp(a, b) for a, b in zip(*shown, strict=True)]))
    assert render(model, data) is None


def test_samples_of_no_weight_do_not_count_and_many_are_thinned_out():
    # Oracle: the judgement without the samples of no weight; every other one of the 40,000 that remain.
    data = measure(lit(0.2), count=60_000)
    weight, value = np.ones(60_000), data.value.copy()
    weight[:20_000], value[:20_000] = 0, 7.0
    spoiled = Reflectance(wi=data.wi, wo=data.wo, value=value, source="spoiled", weight=weight)
    found = judge(lit(0.3), spoiled)
    assert found.judged == 20_000
    assert found == judge(lit(0.3), data.select(np.arange(60_000) >= 20_000, "spoiled"))


def test_a_measurement_is_rendered_once_for_all_its_selections_and_forgotten_with_it():
    # Oracle: the calls of the interpolant, and the size of the cache.
    gc.collect()
    calls, before = [], len(judging._pictures)
    data = defined_everywhere(lit(0.2), calls=calls)
    judge(lit(0.3), data)
    once = len(calls)
    judge(matte(0.1), data.select(np.array([True]), "none"))
    assert len(calls) == once
    assert len(judging._pictures) == before + 1
    del data
    gc.collect()
    assert len(judging._pictures) == before


def test_a_brown_sphere_of_blue_acrylic_is_wrong_although_its_log_error_is_the_smaller(shared):
    # Oracle: eyes. The two fits of the log loss; see BROWN.
    data = fitter.read(f"{shared / 'data' / 'merl_slices' / 'merl_phid90_slices.npz'}:blue-acrylic")
    brown = from_dict({"model": "disney", "parameters": {"disney": BROWN}}).brdf
    blue = from_dict({"model": "lambert+ggx", "parameters": BLUE}).brdf
    keep = np.minimum(data.wi[:, 2], data.wo[:, 2]) > np.cos(np.radians(75))
    wi, wo, value = data.wi[keep], data.wo[keep], data.value[keep]
    error = {
        name: np.abs(np.log1p(evaluate_in_chunks(model, wi, wo) * wi[:, 2:]) - np.log1p(value * wi[:, 2:])).mean()
        for name, model in (("brown", brown), ("blue", blue))
    }
    assert error["brown"] < 0.5 * error["blue"]
    of_brown, of_blue = judge(brown, data), judge(blue, data)
    assert of_brown.mean > 2 * of_blue.mean
    assert (of_brown.verdict, of_blue.verdict) == ("wrong", "visible")


def test_a_model_that_is_not_finite_is_refused():
    broken = lit(0.2)
    object.__setattr__(broken.lobes[0], "albedo", np.full(3, np.nan))
    with pytest.raises(UserError, match=r"not finite at 49152 of 49152 pairs"):
        judge(broken, defined_everywhere(lit(0.2)))


def test_the_picture_shows_both_spheres_the_right_way_up(tmp_path):
    # Oracle: the colours of the spheres and their highlight in the file's pixels.
    from matplotlib.image import imread

    data = defined_everywhere(matte([0.8, 0.1, 0.1]))
    path = tmp_path / "judged.png"
    plot_judgement(matte([0.1, 0.1, 0.8]), data, path)
    picture = imread(path)[..., :3]
    red = (picture[..., 0] > 2 * picture[..., 2]) & (np.arange(picture.shape[1]) < picture.shape[1] / 3)
    blue = picture[..., 2] > 2 * picture[..., 0]
    rows, columns = np.nonzero(red)
    assert np.nonzero(blue)[1].mean() > columns.max()
    # The key light stands at the upper left.
    bright = picture[..., 0][rows, columns] > np.percentile(picture[..., 0][rows, columns], 98)
    assert rows[bright].mean() < rows.mean() - 20
    assert columns[bright].mean() < columns.mean() - 20
    with pytest.raises(FileError):
        plot_judgement(matte(0.1), data, path)
    with pytest.raises(UserError, match="too few values between its samples"):
        plot_judgement(matte(0.1), measure(lit(0.2), count=50), tmp_path / "other.png")


def test_a_judgement_is_a_json_object():
    found = judge(lit(0.2), defined_everywhere(lit(0.3)))
    assert set(found.to_dict()) == {"kind", "mean", "percentile_95", "maximum", "judged", "left_out"}
    assert found.verdict == "close"
    assert found.sentence().startswith(f"Delta E ITP {found.mean:.3g} on a lit sphere (95 % below ")
