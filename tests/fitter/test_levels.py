"""Large measurements: a random part first, then all. Oracles: sums over all samples in NumPy, and laws of counting."""

import numpy as np
import pytest
from synthetic import measure, noisy_in_log, plastic

import brdf
import fitter
from brdf.registry import split
from fitter.loss import LOSSES
from fitter.reflectance import Reflectance
from fitter.samples import CHUNK, SLAB, arrange

COUNT = 150_000
SHAPES = {"albedo": np.array([0.4, 0.2, 0.05]), "f0": np.array([0.05, 0.06, 0.07]), "alpha": 0.15}


@pytest.fixture(scope="module")
def large():
    data = noisy_in_log(plastic(), 3, COUNT)
    return data, fitter.fit("lambert+ggx", data, loss="log_squares", max_theta_deg=90.0)


def cost(data: Reflectance, **changed) -> float:
    value = np.asarray(brdf.evaluate(plastic(**{**SHAPES, **changed}), data.wi, data.wo))
    cos_i = data.wi[:, 2:3]
    return 0.5 * float(np.sum((np.log1p(value * cos_i) - np.log1p(data.value * cos_i)) ** 2))


def test_the_solution_of_a_large_fit_is_that_of_all_samples(large):
    # Oracle: the cost over all samples in NumPy. To move any element by a tenth of its error raises it.
    data, result = large
    lobes = split(result.brdf)
    found = {"albedo": lobes["lambert"].albedo, "f0": lobes["ggx"].f0, "alpha": float(lobes["ggx"].alpha)}
    best = cost(data, **found)
    assert result.errors["cost"] == pytest.approx(best, rel=1e-9)
    assert result.converged
    errors = result.standard_errors()
    moves = [("alpha", errors["ggx.alpha"])]
    moves += [("albedo", errors["lambert.albedo.r"] * np.eye(3)[0]), ("f0", errors["ggx.f0.b"] * np.eye(3)[2])]
    for name, step in moves:
        for sign in (-0.1, 0.1):
            assert cost(data, **{**found, name: found[name] + sign * step}) > best


def test_a_large_fit_passes_over_all_samples_a_few_times(large):
    # The target of issue 4: at most four evaluations of all samples.
    assert large[1].passes < 8
    assert large[1].samples == COUNT


def test_standard_errors_shrink_with_the_root_of_the_samples(large):
    # Oracle: the law, with samples of the same distribution. 30,000 samples tell their error to some per cent.
    small = fitter.fit("lambert+ggx", noisy_in_log(plastic(), 4, 30_000), loss="log_squares", max_theta_deg=90.0)
    assert large[1].certainty.inflation == small.certainty.inflation == 1.0
    ratio = small.certainty.standard_errors / large[1].certainty.standard_errors
    np.testing.assert_allclose(ratio, np.sqrt(COUNT / 30_000), rtol=0.08)


def test_nothing_free_is_only_judged_on_all_samples(large):
    data = large[0]
    fixed = {"albedo": SHAPES["albedo"], "f0": SHAPES["f0"], "alpha": 0.15}
    result = fitter.fit("lambert+ggx", data, loss="log_squares", max_theta_deg=90.0, fixed=fixed)
    assert result.converged
    assert result.errors["cost"] == pytest.approx(cost(data), rel=1e-9)


@pytest.mark.parametrize("count", [1, CHUNK, CHUNK + 1, SLAB, SLAB + 1])
def test_every_sample_stands_once_in_the_slabs_and_at_most_once_in_the_subset(count):
    # Oracle: weights that are all different, told apart again by sorting. Their mean is 1.
    wi = np.tile([[0.0, 0.0, 1.0]], (count, 1))
    weight = np.arange(1.0, count + 1)
    data = Reflectance(wi=wi, wo=wi, value=np.ones((count, 3)), source="made", weight=weight)
    arranged = arrange(data, LOSSES["log"], weight[:, None])

    def held(slab):
        laid = np.asarray(slab.samples.weight)[:, 0].ravel()
        assert not laid[slab.count * CHUNK :].any()
        return np.rint(laid[laid > 0] * weight.mean()).astype(int)

    np.testing.assert_array_equal(np.sort(np.concatenate([held(slab) for slab in arranged.slabs])), weight)
    subset = held(arranged.subset)
    np.testing.assert_array_equal(subset, arranged.rows + 1)
    assert len(np.unique(subset)) == min(count, SLAB)
    assert arranged.share == pytest.approx(subset.sum() / weight.sum(), rel=1e-12)


def test_one_to_three_samples_end_in_a_report():
    for count in (1, 2, 3):
        result = fitter.fit("lambert+ggx", measure(plastic(), count=count), advice=True)
        assert result.converged
        assert str(result.samples) in result.report()
