"""Losses and weights. Oracles: difference quotients, closed-form integrals, repeated samples, and truths."""

import dataclasses

import numpy as np
import pytest
from synthetic import measure, noisy_in_log, plastic

import brdf
import fitter
from fitter.loss import LOSSES, compressed
from fitter.reflectance import Grid, Reflectance
from fitter.weights import weights

DATA = noisy_in_log(plastic(), 1, 1500)


def alpha_of(result) -> float:
    return float(result.brdf.lobes[1].alpha)


@pytest.mark.parametrize("loss", list(LOSSES))
def test_every_loss_recovers_a_noise_free_material(loss):
    truth = plastic()
    result = fitter.fit("lambert+ggx", measure(truth, count=1500), loss=loss)
    assert result.converged
    for lobe, expected in zip(result.brdf.lobes, truth.lobes, strict=True):
        for p in brdf.parameters(lobe):
            np.testing.assert_allclose(getattr(lobe, p.name), getattr(expected, p.name), rtol=1e-6)


@pytest.mark.parametrize("loss", list(LOSSES))
def test_slopes_and_curvatures_are_the_derivatives_of_the_loss(loss):
    # Oracle: central differences; the curvature is the square of the derivative of sqrt(2 rho). Residuals on both sides
    # of Huber's threshold, 0.2 of the scale.
    r = np.array([-3.0, -0.5, -0.19, -1e-3, 1e-3, 0.07, 0.21, 0.9, 5.0])[None].repeat(3, 0)
    judge, h = LOSSES[loss].judge, 1e-6
    judged, ahead, behind = (judge(x, 1.0) for x in (r, r + h, r - h))
    np.testing.assert_allclose(judged.slope, (ahead.cost - behind.cost) / (2 * h), rtol=1e-6, atol=1e-9)
    root = (np.sqrt(2 * ahead.cost) - np.sqrt(2 * behind.cost)) / (2 * h)
    np.testing.assert_allclose(judged.curvature, root**2, rtol=1e-5)
    value, cos_i = np.array([[1e-3, 0.1, 2.0, 50.0]]).repeat(3, 0), np.array([[0.2, 0.5, 0.9, 1.0]])
    z, rise = compressed(LOSSES[loss], value, cos_i)
    step = 1e-5 * value
    ends = [np.asarray(LOSSES[loss].compress(value + s * step, cos_i)) for s in (1, -1)]
    np.testing.assert_allclose(rise, (ends[0] - ends[1]) / (2 * step), rtol=1e-6)
    np.testing.assert_array_equal(z, LOSSES[loss].compress(value, cos_i))


@pytest.mark.parametrize(("robust", "plain"), [("log", "log_squares"), ("log_huber", "log_squares")])
def test_a_robust_loss_resists_outliers(robust, plain):
    # Oracle: the truth. Every 30th sample is 200 times too bright.
    spoilt = np.where(np.arange(1500)[:, None] % 30 == 0, 200.0, 1.0) * DATA.value
    data = dataclasses.replace(DATA, value=spoilt)
    off = [abs(alpha_of(fitter.fit("lambert+ggx", data, loss=loss)) - 0.15) for loss in (robust, plain)]
    assert off[0] < 0.7 * off[1]


def test_adaptive_keeps_the_loss_whose_picture_is_nearest():
    # Oracle: the same fits one by one.
    data = dataclasses.replace(DATA, value=DATA.value * (1 + (1 - DATA.wi[:, 2:3]) ** 2))
    result = fitter.fit("lambert+ggx", data, loss="adaptive")
    assert set(result.looks) == {"log", "cube_root", "square_root", "cosine"}
    assert result.loss == min(result.looks, key=result.looks.get)
    alone = fitter.fit("lambert+ggx", data, loss=result.loss)
    assert alone.judgement.mean == pytest.approx(min(result.looks.values()), rel=1e-9)
    assert alpha_of(result) == alpha_of(alone)
    assert f"{result.loss} looks most like the measurement" in result.report()


def test_weights_count_like_repeated_samples():
    # Oracle: the same measurement with every third sample twice, and its sum of squares.
    twice = np.arange(1500) % 3 == 0
    weighted = dataclasses.replace(DATA, weight=np.where(twice, 2.0, 1.0))
    rows = np.concatenate([np.arange(1500), np.flatnonzero(twice)])
    repeated = Reflectance(wi=DATA.wi[rows], wo=DATA.wo[rows], value=DATA.value[rows], source="repeated")
    a, b = (fitter.fit("lambert+ggx", data, loss="log_squares") for data in (weighted, repeated))
    np.testing.assert_allclose(a.brdf.lobes[0].albedo, b.brdf.lobes[0].albedo, rtol=1e-6)
    assert alpha_of(a) == pytest.approx(alpha_of(b), rel=1e-6)
    # Only ratios matter, and repeating a sample tells nothing new of its scatter.
    c = fitter.fit("lambert+ggx", dataclasses.replace(weighted, weight=7 * weighted.weight), loss="log_squares")
    np.testing.assert_allclose(c.certainty.standard_errors, a.certainty.standard_errors, rtol=1e-9)
    assert alpha_of(c) == pytest.approx(alpha_of(a), rel=1e-12)


def test_sigma_is_carried_through_the_compression():
    # Oracle: d log(1 + f cos) = cos / (1 + f cos) df, and per channel where the file tells it so.
    sigma = np.random.default_rng(2).uniform(0.01, 0.1, (1500, 3))
    data = dataclasses.replace(DATA, sigma=sigma)
    cos_i = DATA.wi[:, 2:3]
    expected = ((1 + DATA.value * cos_i) / (cos_i * sigma)) ** 2
    np.testing.assert_allclose(weights(data, "sigma", LOSSES["log_squares"]), expected, rtol=1e-12)
    np.testing.assert_allclose(weights(data, "sigma", LOSSES["linear"]), sigma**-2.0, rtol=1e-12)
    one = weights(dataclasses.replace(DATA, sigma=sigma[:, 0]), "sigma", LOSSES["linear"])
    np.testing.assert_allclose(one, sigma[:, :1].repeat(3, 1) ** -2.0, rtol=1e-12)


def test_noise_of_a_known_sigma_is_fitted_better_with_it():
    # Oracle: the truth. Half of the samples are 30 times as noisy.
    rng, off = np.random.default_rng(4), {"samples": [], "sigma": []}
    for seed in range(5):
        clean = measure(plastic(), seed, 1500)
        sigma = np.where(np.arange(1500) % 2, 0.003, 0.1) * (0.1 + clean.value.mean(axis=1))
        value = np.abs(clean.value + sigma[:, None] * rng.normal(size=(1500, 3)))
        data = Reflectance(wi=clean.wi, wo=clean.wo, value=value, source="noisy", sigma=sigma)
        for kind, found in off.items():
            found.append(alpha_of(fitter.fit("lambert+ggx", data, loss="log_squares", weights=kind)) - 0.15)
    assert np.std(off["sigma"]) < 0.3 * np.std(off["samples"])


def test_grid_weights_add_up_to_the_integrals_over_the_angles():
    # Oracle: closed forms. Over theta_h, theta_d to 90 degrees and phi_d to 180 the integral of sin(theta_h)
    # sin(theta_d) is pi, and of 4 cos(theta_d) times that, 2 pi. theta_h is spaced quadratically as in MERL.
    axes = {
        "theta_h": np.pi / 2 * np.linspace(0, 1, 90) ** 2,
        "theta_d": np.linspace(0, np.pi / 2, 90),
        "phi_d": np.linspace(0, np.pi, 9, endpoint=False),
    }
    count = 90 * 90 * 9
    up = np.tile([[0.0, 0.0, 1.0]], (count, 1))
    grid = Grid(axes, np.arange(count))
    table = Reflectance(wi=up, wo=up, value=np.ones((count, 3)), source="table", grid=grid)
    assert weights(table, "grid", LOSSES["log"]).sum() == pytest.approx(np.pi, rel=1e-3)
    assert weights(table, "solid_angle", LOSSES["log"]).sum() == pytest.approx(2 * np.pi, rel=1e-3)
    # What was left out of the table takes its own weight along.
    some = table.select(np.arange(count) % 7 > 0, "left out")
    kept = weights(table, "grid", LOSSES["log"])[np.arange(count) % 7 > 0]
    np.testing.assert_array_equal(weights(some, "grid", LOSSES["log"]), kept)


@pytest.mark.parametrize(("kind", "sentence"), [("grid", "no table over theta_h"), ("sigma", "no standard errors")])
def test_weights_that_the_data_do_not_give_are_refused(kind, sentence):
    with pytest.raises(brdf.UserError, match=sentence):
        fitter.fit("lambert+ggx", DATA, weights=kind)
