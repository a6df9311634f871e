"""The report says what the result holds. Oracle: the numbers of the result itself."""

import json

import numpy as np
import pytest
from synthetic import noisy_in_log, plastic

import brdf
import fitter
from fitter.reflectance import Reflectance
from fitter.report import elements

DATA = noisy_in_log(plastic(), 1, 1500)


@pytest.fixture(scope="module")
def result():
    return fitter.fit("lambert+ggx", DATA)


def test_every_number_has_a_line_with_its_error_interval_and_start(result):
    lines = {line.split()[0]: line for line in result.report().splitlines() if line.strip()}
    for label, error in result.standard_errors().items():
        low, high = result.intervals()[label]
        value = elements(result.brdf)[label]
        assert f"{value:.6g} " in lines[label]
        assert f"+/- {error:<9.3g}" in lines[label]
        assert f"{low:.4g}" in lines[label]
        assert f"{high:.4g}]" in lines[label]
        assert low < value < high
        assert high - low == pytest.approx(2 * 1.959964 * error, rel=1e-6)
        assert f"(init = {elements(result.initial)[label]:.4g})" in lines[label]
    assert "(choice)" in lines["ggx.masking"]


def test_the_head_counts_samples_losses_and_errors():
    result = fitter.fit("lambert+ggx", DATA, max_theta_deg=60)
    text, lost = result.report(), int(np.sum((DATA.wi[:, 2] <= 0.5) | (DATA.wo[:, 2] <= 0.5)))
    assert f"{1500 - lost} used, {lost} left out (theta >= 60 deg: {lost})" in text
    assert f"mean {result.errors['log_mae']:.5f}, rms {result.errors['log_rms']:.5f}" in text
    assert "log, weights samples, theta < 60 deg" in text
    assert result.status in text
    assert "7 of 7 numbers" in text


def test_correlations_are_those_of_the_inverse_hessian(result):
    # Oracle: symmetric, one on the diagonal, and the strongest pair first in the text.
    matrix = result.certainty.correlations
    np.testing.assert_allclose(matrix, matrix.T, rtol=1e-9)
    np.testing.assert_allclose(np.diagonal(matrix), 1, rtol=1e-9)
    a, b, rho = result.correlations()[0]
    assert abs(rho) == pytest.approx(np.abs(matrix - np.eye(7)).max(), rel=1e-9)
    assert f"{a}, {b}" in result.report().partition("[[Correlations]]")[2].splitlines()[1]


def test_fixed_tied_held_and_stuck_numbers_are_told_apart():
    fixed = fitter.fit("lambert+ggx", DATA, fixed={"albedo": 0.0}, bounds={"alpha": (0.3, 0.9)})
    lines = {line.split()[0]: line for line in fixed.report().splitlines() if line.strip()}
    assert lines["lambert.albedo.r"].endswith("(fixed)")
    assert "at its bound" in lines["ggx.alpha"]
    assert "At a bound: ggx.alpha" in fixed.report()


def test_the_json_is_finite_and_agrees_with_the_result(result):
    told = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert told["standard_errors"] == result.standard_errors()
    assert told["intervals_95"] == result.intervals()
    assert told["errors_from"] == "independent samples"
    assert told["at_bound"] == told["freedoms"] == []
    assert told["converged"] is True
    assert told["samples"] == result.samples
    assert told["delta_e_itp"]["mean"] == result.judgement.mean


def test_what_the_data_leave_open_is_named_in_text_and_json():
    # One pair of directions tells one number per channel; Lambert and the highlight share it.
    up = np.tile([[0.0, 0.0, 1.0]], (5, 1))
    data = Reflectance(wi=up, wo=up, value=np.full((5, 3), 0.3), source="up")
    result = fitter.fit("lambert+ggx", data)
    told = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert len(told["freedoms"]) == 4
    assert all(type(label) is str for labels in result.certainty.freedoms for label in labels)
    assert all(error is None for error in result.standard_errors().values())
    assert "trade off exactly on these data" in result.report()
    assert "3 of 7 numbers" in result.report()


def test_trade_offs_are_warned_of():
    # A highlight as broad as can be is nearly as matt as the base.
    result = fitter.fit("lambert+ggx", noisy_in_log(plastic(alpha=0.95), 1, 1500), quick=True)
    pairs = result.correlations(0.95)
    assert pairs
    assert f"{pairs[0][0]} and {pairs[0][1]} trade off against each other" in result.report()


def test_another_unit_is_suspected_of_data_that_are_far_off():
    data = Reflectance(wi=DATA.wi, wo=DATA.wo, value=1e4 * DATA.value, source="far")
    result = fitter.fit("lambert", data)
    assert "Check the data's units" in result.report()
    assert brdf.Material(result.brdf).to_dict()
