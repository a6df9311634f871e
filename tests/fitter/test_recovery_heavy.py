"""The promised accuracy, measured: run with `-m heavy -s`; the last figures are in docs/accuracy.md."""

import dataclasses
import os
import time

import numpy as np
import pytest
from recovery import EXACT, ONE_LOBE, SEVERAL_LOBES, measurement, recover

import fitter
from brdf.material import from_dict
from fitter.reflectance import Reflectance
from fitter.select import select

pytestmark = pytest.mark.heavy

# A smaller share of the materials, repetitions and slices, for a first look.
SHARE = float(os.environ.get("HEAVY_SHARE", "1"))


def some(count: int) -> int:
    return max(round(SHARE * count), 1)


@pytest.mark.parametrize("model", ONE_LOBE)
def test_99_percent_of_random_materials_are_recovered(model):
    # Oracle: the truth, to 1e-6 in every identifiable parameter.
    found = [recover(model, seed) for seed in range(some(1000))]
    share = np.mean([one.found for one in found])
    known = sum(one.identifiable for one in found) / sum(one.elements for one in found)
    print(f"\n{model}: {100 * share:.1f} % of {len(found)}, {100 * known:.1f} % of the parameters identifiable")
    assert share >= 0.99


@pytest.mark.parametrize("model", SEVERAL_LOBES)
def test_several_lobes_are_recovered_in_cost(model):
    # Oracle: a noise-free measurement can be met exactly. No search promises every one: 99 % as above.
    costs = np.array([recover(model, seed).cost for seed in range(some(200))])
    missed = np.flatnonzero(costs > EXACT)
    print(f"\n{model}: {100 * np.mean(costs <= EXACT):.1f} % of {len(costs)}; missed seeds {missed.tolist()}")
    assert len(missed) <= 0.01 * len(costs)


def multiplied(data: Reflectance, seed: int) -> Reflectance:
    """5 % Gaussian noise of the value."""
    noise = 0.05 * np.random.default_rng(seed).normal(size=data.value.shape)
    return dataclasses.replace(data, value=np.maximum(data.value * (1 + noise), 0))


def compressed(data: Reflectance, seed: int) -> Reflectance:
    """The same size of noise, but symmetric in log(1 + f cos_i), so that the loss `log` is not biased by it."""
    noise = 0.05 * np.random.default_rng(seed).normal(size=data.value.shape)
    raised = data.value * data.wi[:, 2:3]
    value = np.expm1(np.log1p(raised) + noise * raised / (1 + raised)) / data.wi[:, 2:3]
    return dataclasses.replace(data, value=np.maximum(value, 0))


@pytest.mark.parametrize("noise", [multiplied, compressed])
@pytest.mark.parametrize("alpha", [0.1, 0.2, 0.3])
def test_5_percent_noise_leaves_alpha_within_a_fifth_of_a_percent_and_intervals_cover_it(alpha, noise):
    # Oracle: the truth; over 500 repetitions a coverage of 95 % scatters by 1 %. Multiplied noise lowers the mean of
    # the logarithm, which moves alpha by 0.05 %, its own standard error: only without that bias can 95 % be met.
    parts = {"lambert": {"albedo": [0.4, 0.2, 0.1]}, "ggx": {"f0": [0.05, 0.1, 0.2], "alpha": alpha}}
    truth = from_dict({"model": "lambert+ggx", "parameters": parts}).brdf
    wanted = np.array([0.4, 0.2, 0.1, 0.05, 0.1, 0.2, alpha])
    values, inside, inflated = [], [], 0
    for seed in range(some(500)):
        result = fitter.fit("lambert+ggx", noise(measurement(truth, seed, 20_000), seed))
        values.append(result.unknowns.values(result.unknowns.vector(result.brdf)))
        low, high = result.certainty.intervals.T
        inside.append((low <= wanted) & (wanted <= high))
        inflated += result.certainty.inflation > 1
    error = np.array(values) / wanted - 1
    root, bias, cover = np.sqrt((error**2).mean(axis=0)), error.mean(axis=0), 100 * np.mean(inside, axis=0)
    print(f"\nalpha {alpha}, {noise.__name__}: rms {100 * root[6]:.3f} %, bias of all {(100 * bias).round(3)} %")
    print(f"covered {cover.round(1)} %, bootstraps {inflated} of {len(values)}")
    assert root[6] <= 0.002
    assert inflated <= 0.01 * len(values)
    if noise is compressed:
        assert (cover >= 90).all()
        assert (cover <= 98).all()


def test_models_chosen_automatically_meet_the_bar_on_measured_slices(shared):
    # Oracle: 0.0330, the best published parametric fit to these slices (Low's ABC microfacets).
    path = shared / "data" / "merl_slices" / "merl_phid90_slices.npz"
    with np.load(path) as file:
        names = sorted(file)[:: max(round(1 / SHARE), 1)]
    errors, plain, seconds = [], [], []
    for name in names:
        started = time.process_time()
        found = select(f"{path}:{name}", max_theta_deg=75.0)
        seconds.append(time.process_time() - started)
        errors.append(found.chosen.log_mae)
        plain.append(next(one.log_mae for one in found.candidates if one.expression == "lambert+ggx"))
        print(
            f"\n{name}: {found.chosen.name} {errors[-1]:.4f}, lambert+ggx {plain[-1]:.4f}, {seconds[-1]:.1f} s", end=""
        )
    worst = names[int(np.argmax(errors))]
    print(f"\nmean {np.mean(errors):.4f}, worst {max(errors):.4f} ({worst}), lambert+ggx {np.mean(plain):.4f}")
    print(f"CPU seconds per material: median {np.median(seconds):.1f}, most {max(seconds):.1f}")
    assert np.mean(errors) <= 0.023
    assert np.mean(plain) <= 0.0555
    assert (np.array(errors) <= np.array(plain)).all()
