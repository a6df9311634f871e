"""Which scan to add. Oracle: the standard errors of fits to measurements with that scan added."""

import numpy as np
import pytest
from synthetic import noisy_in_log, plastic

import brdf
import fitter
from fitter.advice import _OUTGOING_DEG, _scan
from fitter.reflectance import Reflectance

COUNT = 3220  # a twentieth of it is one scan of 161 samples


def dull():
    """Samples far from the highlight, which tell little of it."""
    data = noisy_in_log(plastic(), 2, 40_000)
    half = data.wi + data.wo
    far = half[:, 2] / np.linalg.norm(half, axis=1) < np.cos(0.5)
    return data.select(far & (np.cumsum(far) <= COUNT), "near")


def test_the_advised_scan_lowers_the_error_as_much_as_is_said():
    data = dull()
    before = fitter.fit("lambert+ggx", data, loss="log_squares", max_theta_deg=90.0, advice=True, quick=True)
    best = before.advice[0]
    assert 0 < best.factor < 0.9
    wi, wo = _scan(best.theta_i_deg, {"in": 0.0, "across": np.pi / 2}[best.arc] * 180 / np.pi)
    assert len(wi) == len(_OUTGOING_DEG) == 0.05 * COUNT
    value = np.asarray(brdf.evaluate(plastic(), wi, wo))
    cos_i = wi[:, 2:3]
    value = np.expm1(np.log1p(value * cos_i) + 0.004 * np.random.default_rng(1).normal(size=value.shape)) / cos_i
    parts = ((data.wi, wi), (data.wo, wo), (data.value, np.maximum(value, 0)))
    wi, wo, value = (np.concatenate(part) for part in parts)
    both = Reflectance(wi=wi, wo=wo, value=value, source="both")
    after = fitter.fit("lambert+ggx", both, loss="log_squares", max_theta_deg=90.0, quick=True)
    element = before.unknowns.element_labels.index(best.label)
    factor = after.certainty.standard_errors[element] / before.certainty.standard_errors[element]
    # Errors from one noisy measurement each.
    assert factor == pytest.approx(best.factor, rel=0.2)
    assert f"lowers its standard error by {1 - best.factor:.0%}" in before.report()


def test_advice_comes_best_first_and_only_if_it_is_worth_a_sentence():
    advice = fitter.fit("lambert+ggx", dull(), advice=True, quick=True).advice or []
    assert [one.factor for one in advice] == sorted(one.factor for one in advice)
    assert len(advice) == 3
    good = fitter.fit("lambert", noisy_in_log(plastic(), 2, 3000), advice=True, quick=True)
    assert good.advice == []
    assert "No further scan" in good.report()


def test_what_one_pair_of_directions_leaves_open_would_be_determined():
    up = np.tile([[0.0, 0.0, 1.0]], (5, 1))
    data = Reflectance(wi=up, wo=up, value=np.full((5, 3), 0.3), source="up")
    result = fitter.fit("lambert+ggx", data, advice=True)
    assert result.advice[0].factor == 0
    assert "would determine it" in result.report()


def test_nothing_free_needs_no_advice():
    fixed = {"albedo": 0.2, "f0": 0.05, "alpha": 0.15}
    assert fitter.fit("lambert+ggx", noisy_in_log(plastic(), 2, 300), fixed=fixed, advice=True).advice == []
