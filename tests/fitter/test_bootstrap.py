"""The bootstrap over incident angles. Oracles: full fits to resampled blocks, and noise of a known kind."""

import dataclasses

import jax
import numpy as np
import pytest
from synthetic import noisy_in_log, plastic

import brdf
import fitter
from fitter.bootstrap import BLOCKS, assess_blocks
from fitter.loss import LOSSES
from fitter.minimise import Problem
from fitter.reflectance import Reflectance
from fitter.samples import arrange
from fitter.wishes import Wishes, choose


def bent(count=1500):
    """Data that rise towards grazing incidence as `lambert+ggx` cannot."""
    data = noisy_in_log(plastic(), 7, count)
    return dataclasses.replace(data, value=data.value * (1 + (1 - data.wi[:, 2:3]) ** 2))


def shaken(seed, count=1500):
    """Noise that whole ranges of incident angles have in common, and no misfit."""
    data = noisy_in_log(plastic(), seed, count)
    block = (np.argsort(np.argsort(data.wi[:, 2])) * BLOCKS) // count
    factor = np.exp(0.05 * np.random.default_rng(seed).normal(size=BLOCKS))
    return dataclasses.replace(data, value=data.value * factor[block][:, None])


def test_misfit_is_found_and_said():
    result = fitter.fit("lambert+ggx", bent())
    plain = fitter.fit("lambert+ggx", bent(), quick=True)
    assert result.certainty.inflation > 3
    assert plain.certainty.inflation == 1.0
    assert result.certainty.standard_errors[-1] > 1.5 * plain.certainty.standard_errors[-1]
    assert "bootstrap over incident angles" in result.report()
    assert result.to_dict()["errors_from"] == "bootstrap over incident angles"


def test_one_step_errors_are_those_of_fits_to_resampled_blocks():
    # Oracle: 60 full fits whose blocks count as often as they were drawn. Their scatter is known to 9 %.
    data = bent()
    result = fitter.fit("lambert+ggx", data)
    used = result.data
    block = np.empty(len(used), int)
    order = np.argsort(np.degrees(np.arccos(used.wi[:, 2])), kind="stable")
    for place, rows in enumerate(np.array_split(order, BLOCKS)):
        block[rows] = place
    rng, alphas = np.random.default_rng(5), []
    for _ in range(60):
        times = rng.multinomial(BLOCKS, np.full(BLOCKS, 1 / BLOCKS)).astype(float)
        drawn = dataclasses.replace(used, weight=times[block])
        alphas.append(float(fitter.fit("lambert+ggx", drawn, start=result.brdf, quick=True).brdf.lobes[1].alpha))
    assert result.standard_errors()["ggx.alpha"] == pytest.approx(np.std(alphas), rel=0.3)
    low, high = result.certainty.intervals[-1]
    assert 0.85 <= np.mean((np.array(alphas) > low) & (np.array(alphas) < high)) <= 1


def test_errors_that_neighbours_share_widen_the_intervals_to_where_the_truth_is():
    # Oracle: the truth, alpha = 0.15, within four of the quoted errors; independent samples would give about ten.
    worst, plain = 0.0, 0.0
    for seed in range(6):
        result = fitter.fit("lambert+ggx", shaken(seed))
        quick = fitter.fit("lambert+ggx", shaken(seed), quick=True)
        assert result.certainty.inflation > 3
        off = abs(result.brdf.lobes[0].albedo[0] - 0.4)
        worst = max(worst, off / result.standard_errors()["lambert.albedo.r"])
        plain = max(plain, off / quick.standard_errors()["lambert.albedo.r"])
    assert worst < 4 < plain


@pytest.mark.parametrize("grey", [False, True])
def test_clean_noise_is_not_taken_for_misfit(grey):
    # Oracle: the noise, independent by construction; a mean of ratios of variances from 32 blocks scatters by 0.2. Grey
    # data have directions in which hardly anything scatters.
    for seed in range(8):
        result = fitter.fit("lambert+ggx", noisy_in_log(plastic(), seed, 800, grey=grey))
        assert result.certainty.inflation == 1.0
        assert "independent samples" in result.report()


@pytest.mark.parametrize("kind", ["all", "one incident angle"])
def test_blocks_add_up_to_the_whole(kind):
    # Oracle: the pass over all samples. With one incident angle, outgoing angles make the blocks.
    data = bent()
    if kind != "all":
        wi = np.tile([[0.5, 0.0, np.sqrt(0.75)]], (len(data), 1))
        data = Reflectance(wi=wi, wo=data.wo, value=data.value, source="scan")
    weight = np.random.default_rng(1).uniform(0.5, 2, (len(data), 1))
    with jax.enable_x64(True):
        unknowns = choose(brdf.build("lambert+ggx"), Wishes())
        problem = Problem(unknowns, arrange(data, LOSSES["log"], weight), "log")
        y = unknowns.vector(plastic())
        whole, parts = problem.assess(y).equations, assess_blocks(problem, y, data, weight)
    assert parts.gradients.shape == (BLOCKS, 7)
    np.testing.assert_allclose(parts.gradients.sum(axis=0), whole.gradient, rtol=1e-9)
    np.testing.assert_allclose(parts.hessians.sum(axis=0), whole.hessian, rtol=1e-9)
    assert len(np.unique(parts.gradients[:, 6])) == BLOCKS
