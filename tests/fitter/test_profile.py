"""Intervals of what ended at a bound. Oracles: the same fits by hand, and the error of a free fit."""

import numpy as np
import pytest
import scipy.optimize
from synthetic import measure, noisy_in_log, plastic

import fitter
from brdf import MODELS


def alpha_of(result) -> float:
    return float(result.brdf.lobes[1].alpha)


def error_of(result) -> float:
    return result.standard_errors()["ggx.alpha"]


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("grey", [False, True])
@pytest.mark.parametrize("loss", ["log_squares", "log"])
def test_without_a_slope_the_limit_is_the_free_fit_s(loss, grey, side):
    # A bound exactly at the estimate. Grey data repeat one channel: a cost that takes them as three is too sure.
    data = noisy_in_log(plastic(), 3, 1500, grey=grey)
    free = fitter.fit("lambert+ggx", data, loss=loss)
    alpha, error = alpha_of(free), error_of(free)
    bound, end = ((alpha, 0.9), 1) if side == "lower" else ((0.01, alpha), 0)
    result = fitter.fit("lambert+ggx", data, loss=loss, bounds={"alpha": bound})
    interval = result.intervals()["ggx.alpha"]
    assert interval[1 - end] == pytest.approx(alpha, rel=1e-9)
    assert abs(interval[end] - alpha) == pytest.approx(1.96 * error, rel=0.05)


def test_with_a_slope_the_limit_is_where_the_cost_has_risen_enough():
    # Oracle: fits with alpha fixed, until the cost has risen by half the square of 1.96 times the residuals' variance.
    data = noisy_in_log(plastic(), 3, 1500)
    free = fitter.fit("lambert+ggx", data, loss="log_squares")
    bound = alpha_of(free) + 2 * error_of(free)
    result = fitter.fit("lambert+ggx", data, loss="log_squares", bounds={"alpha": (bound, 0.9)})
    assert result.at_bound() == ["ggx.alpha"]
    variance = 2 * result.errors["cost"] / (3 * result.samples - 7)

    def risen(alpha):
        fixed = fitter.fit("lambert+ggx", data, loss="log_squares", fixed={"alpha": alpha}, quick=True)
        return fixed.errors["cost"] - result.errors["cost"] - 0.5 * 1.96**2 * variance

    limit = float(np.asarray(scipy.optimize.brentq(risen, bound + 1e-9, bound * 1.1, xtol=1e-6)))
    low, high = result.certainty.intervals[-1]
    assert low == bound
    # The scatter is that of the samples' own gradients, not of the mean square of all residuals.
    assert high - low == pytest.approx(limit - bound, rel=0.1)
    assert high - low < 0.6 * 1.96 * error_of(free)


def test_a_large_measurement_is_profiled_on_a_part_of_it_with_the_slope_of_all():
    # Oracle: the free fit's error over all samples.
    data = noisy_in_log(plastic(), 3, 30_000)
    free = fitter.fit("lambert+ggx", data)
    alpha = alpha_of(free)
    result = fitter.fit("lambert+ggx", data, bounds={"alpha": (alpha, 0.9)}, start=free.brdf)
    high = result.intervals()["ggx.alpha"][1]
    assert high - alpha == pytest.approx(1.96 * error_of(free), rel=0.15)


def test_data_without_any_scatter_leave_nothing_but_the_bound():
    black = MODELS["lambert"](albedo=np.zeros(3))
    result = fitter.fit("lambert", measure(black, count=300))
    assert result.errors["cost"] == 0
    assert result.intervals() == {f"lambert.albedo.{channel}": [0.0, 0.0] for channel in "rgb"}


def test_a_quick_fit_has_no_profile():
    data = noisy_in_log(plastic(), 3, 1500)
    result = fitter.fit("lambert+ggx", data, bounds={"alpha": (0.3, 0.9)}, quick=True)
    assert result.at_bound()
    assert result.intervals()["ggx.alpha"] is None
    assert "at its bound" in result.report()
