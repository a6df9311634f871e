"""The stress test itself, and every registered model under a short form of it."""

import functools
import json
import pathlib
import subprocess
import sys

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from jax.scipy.special import erf, erfc

import brdf
from brdf import MODELS, choices
from brdf.distributions import d_ggx
from brdf.frame import Scalar, geometry
from brdf.model import AbstractBRDF, Color
from brdf.parameter import color, slope
from brdf.sampling import Proposals
from fitter.cli import options
from fitter.cli.main import main
from fitter.stress import evaluation, points
from fitter.stress.accuracy import sample
from fitter.stress.evaluation import values_and_gradients
from fitter.stress.exact import DIGITS, exact, number
from fitter.stress.report import data, markdown, text
from fitter.stress.run import stress

GGX_BAR = 6e-7  # of the project, for D at alpha >= 1e-3 in float32


@pytest.fixture(autouse=True)
def _quick_to_compile(monkeypatch):
    """Without fusion XLA compiles three times as fast; the values differ by roundings."""
    monkeypatch.setattr(evaluation, "_COMPILER_OPTIONS", {"xla_disable_hlo_passes": "fusion"})


@functools.cache
def glsl():
    """The GLSL evaluation where there is OpenGL."""
    from shaders.context import describe
    from shaders.evaluation import evaluate

    return evaluate if describe()["available"] else None


@pytest.mark.parametrize("name", list(MODELS))
def test_every_model_survives_a_short_stress_test(name):
    # Oracle: no NaN, Inf, negative value or light below the horizon; the model's own formula in 50 digits.
    found = stress(brdf.build(name), 20_000, 64, seed=1, evaluate=glsl(), most_structures=1)
    assert found.points >= 20_000
    assert found.passed, text(found)


def test_a_sum_survives_a_short_stress_test():
    found = stress(brdf.build("lambert+ggx"), 5_000, 32, seed=1, most_structures=1)
    assert found.passed, text(found)


class _AbstractBroken(AbstractBRDF):
    """What the broken models have in common."""

    def proposals(self, cos_o):
        return Proposals(jnp.ones_like(cos_o), ())


class NotANumberAtRetro(_AbstractBroken):
    albedo: Color = color(0.0, 1.0, 0.5, "albedo")

    def reflect(self, g):
        d2 = (g.wi[0] - g.wo[0]) ** 2 + (g.wi[1] - g.wo[1]) ** 2 + (g.wi[2] - g.wo[2]) ** 2
        return self.albedo * d2 / d2


class NegativeAtTheUpperBound(_AbstractBroken):
    albedo: Color = color(0.0, 1.0, 0.5, "albedo")

    def reflect(self, g):
        return jnp.where(self.albedo == 1, -1e-3, self.albedo)


class InfiniteNextToTheLowerBound(_AbstractBroken):
    albedo: Color = color(0.0, 1.0, 0.5, "albedo")

    def reflect(self, g):
        return jnp.where((self.albedo > 0) & (self.albedo < 1e-30), jnp.inf, self.albedo)


class GradientBreaksAtNormalIncidence(_AbstractBroken):
    albedo: Color = color(0.0, 1.0, 0.5, "albedo")

    def reflect(self, g):
        return self.albedo * (2 + jnp.sqrt(g.sin2_i))


class Cubic(_AbstractBroken):
    albedo: Color = color(0.0, 1.0, 0.5, "albedo")

    def reflect(self, g):
        return self.albedo / jnp.pi * g.cos_i**3


class LosesTheHighlight(_AbstractBroken):
    """GGX from a rounded `n . h`: the first column of the table in NUMERICS.md."""

    f0: Color = color(0.0, 1.0, 1.0, "reflectance")
    alpha: Scalar = slope(1e-3, 1.0, 0.3, "slope")

    def reflect(self, g):
        cos_h = g.h_z / jnp.sqrt(g.h2)
        a2 = self.alpha * self.alpha
        base = cos_h * cos_h * (a2 - 1) + 1
        return self.f0 * a2 / (jnp.pi * base * base)


@pytest.mark.parametrize(
    ("model", "arithmetic", "fault"),
    [
        (NotANumberAtRetro, "JAX float32", "value NaN"),
        (NegativeAtTheUpperBound, "JAX float64", "value negative"),
        (InfiniteNextToTheLowerBound, "JAX float64", "value Inf"),
        (GradientBreaksAtNormalIncidence, "JAX float32", "gradient NaN"),
    ],
)
def test_a_broken_model_is_caught_and_its_offender_can_be_tried_again(model, arithmetic, fault):
    found = stress(model(), 4000, 0)
    assert not found.passed
    counts = next(counts for counts in found.counts if counts.arithmetic == arithmetic)
    assert counts.faults[fault] > 0
    offender = next(offender for offender in counts.offenders if offender.fault == fault)
    # The printed digits alone, put into a new model, show the fault again.
    lines = text(found).split(f"  {fault} in {arithmetic}\n")[1].splitlines()
    printed = {key: json.loads(value) for key, _, value in (line.strip().partition(" ") for line in lines[:3])}
    (values,) = printed["parameters"].values()
    dtype = offender.wi.dtype
    leaves = [np.asarray(values[p.name], dtype)[None] for _, p in points.declared(model())]
    wi, wo = (np.asarray(printed[w], dtype)[None] for w in ("wi", "wo"))
    np.testing.assert_array_equal(wi[0], offender.wi)
    value, gradient, _ = values_and_gradients(model(), leaves, wi, wo)
    shown = {"NaN": np.isnan, "Inf": np.isinf, "negative": lambda x: x < 0}[fault.split()[1]]
    assert shown(gradient if fault.startswith("gradient") else value).any()
    if fault.startswith("gradient"):
        assert "gradient by wi" in text(found)


def test_a_glsl_fault_is_caught():
    def broken(model, wi, wo):
        value = np.ones_like(wi)
        value[(wi == wo).all(axis=1)] = np.nan
        return value

    found = stress(brdf.build("lambert"), 3000, 0, evaluate=broken)
    counts = found.counts[-1]
    assert counts.arithmetic == "GLSL float32"
    assert counts.faults["value NaN"] > 0
    # This twin shines below the horizon too.
    assert counts.faults["value below the horizon"] > 0
    assert sum(sum(c.faults.values()) for c in found.counts[:-1]) == 0


def test_a_formula_that_loses_digits_is_over_the_bar():
    found = stress(LosesTheHighlight(), 1000, 256)
    single = found.errors[0]
    assert single.worst_ratio > 1
    assert not found.passed
    assert single.figures()["max"] > 1e-4
    assert "exact [" in text(found)


def test_the_condition_number_of_a_product_is_the_sum_of_its_exponents():
    # Oracle: f = albedo / pi has kappa 1; f = albedo wi_z^3 / pi has 1 + 3.
    lambert = sample(brdf.build("lambert"), np.random.default_rng(0), 64, "float32")
    seen = lambert.truth > 1e-30
    np.testing.assert_allclose(lambert.kappa[seen], 1, rtol=1e-12)
    cubic = sample(Cubic(), np.random.default_rng(0), 64, "float64")
    seen = cubic.truth > 1e-290
    np.testing.assert_allclose(cubic.kappa[seen], 4, rtol=1e-12)


def test_every_option_of_every_choice_is_tried():
    for name in MODELS:
        tried = points.structures(brdf.build(name), np.random.default_rng(0))
        for choice in choices(MODELS[name]):
            assert {getattr(model, choice.name) for model in tried} == set(choice.options)
        assert all(getattr(tried[0], choice.name) == choice.default for choice in choices(MODELS[name]))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_directions_hold_every_awkward_kind(dtype):
    wi, wo = points.directions(np.full(16_000, 0.01), np.random.default_rng(0), dtype)
    assert wi.dtype == wo.dtype == dtype
    for w in (wi, wo):
        np.testing.assert_allclose(np.linalg.norm(w.astype(np.float64), axis=1), 1, rtol=3e-7)
    assert (wi == wo * [-1, -1, 1]).all(axis=1).mean() > 0.03
    assert (wi == wo).all(axis=1).mean() > 0.03
    assert (wi == -wo).all(axis=1).mean() > 0.02
    up = np.array([0, 0, 1], dtype)
    assert ((wi == up).all(axis=1) & (wo == up).all(axis=1)).any()
    assert ((wi == up).all(axis=1) | (wo == up).all(axis=1)).mean() > 0.05
    low = (np.abs(wi[:, 2]) < 2e-7) & (np.abs(wo[:, 2]) < 2e-7)
    across = wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1] < -0.999
    assert (low & across).any()
    assert (np.signbit(wi[:, 1]) & (wi[:, 1] == 0) & (wi[:, 0] < 0)).any()
    h = wi + wo
    near = np.hypot(h[:, 0], h[:, 1]) < 0.1 * np.abs(h[:, 2])
    assert near.mean() > 0.15
    above = np.abs(np.concatenate([wi[:, 2], wo[:, 2]]))
    assert above.min() >= 0.99 * points.GRAZING


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_parameters_lie_at_next_to_and_between_their_bounds(dtype):
    model = brdf.build("ggx")
    values = points.parameter_sets(model, np.random.default_rng(0), 4000, dtype)
    for value, (_, parameter) in zip(values, points.declared(model), strict=True):
        assert value.dtype == dtype
        lower, upper = dtype(parameter.lower), dtype(parameter.upper)
        assert lower == value.min()
        assert upper == value.max()
        beside = np.finfo(dtype).tiny if lower == 0 else np.nextafter(lower, upper)
        for edge in (lower, upper, beside, np.nextafter(upper, lower)):
            assert (value == edge).mean() > 0.03
        assert np.unique(value).size > 1000


def test_the_seed_decides_everything():
    first, again, other = (stress(NotANumberAtRetro(), 2000, 32, seed=seed) for seed in (3, 3, 4))
    assert text(first).splitlines()[1:] == text(again).splitlines()[1:]
    assert text(first).splitlines()[1:] != text(other).splitlines()[1:]


def test_the_page_and_the_data_name_models_counts_and_errors():
    found = [stress(brdf.build("lambert"), 1000, 32)]
    page = markdown(found, 0)
    assert "| `lambert` | JAX float64 |" in page
    plain = json.loads(json.dumps(data(found), allow_nan=False))
    assert plain["lambert"]["passed"]
    assert plain["lambert"]["errors"]["JAX float32"]["max"] < 3e-7


# 50 digits.


def close(value, truth):
    assert value.dtype == object
    with mpmath.workdps(DIGITS):
        for v, t in zip(value.reshape(-1), np.asarray(truth, object).reshape(-1), strict=True):
            assert abs(v - t) <= mpmath.mpf(10) ** (4 - DIGITS) * abs(t)


mp = mpmath.mp


@pytest.mark.parametrize(
    ("function", "truth"),
    [
        (jnp.sqrt, mp.sqrt),
        (jax.lax.rsqrt, lambda x: 1 / mp.sqrt(x)),
        (jnp.cbrt, lambda x: x ** (mp.mpf(1) / 3)),
        (jnp.exp, mp.exp),
        (jnp.log, mp.log),
        (jnp.log1p, mp.log1p),
        (jnp.expm1, mp.expm1),
        (erf, mp.erf),
        (erfc, mp.erfc),
        (jnp.sin, mp.sin),
        (jnp.cos, mp.cos),
        (jnp.tan, mp.tan),
        (jnp.arctan, mp.atan),
        (jnp.arcsin, mp.asin),
        (jnp.tanh, mp.tanh),
        (jax.nn.sigmoid, lambda x: 1 / (1 + mp.exp(-x))),
        (lambda x: jnp.arctan2(x, x - 1), lambda x: mp.atan2(x, x - 1)),
        (lambda x: x**5, lambda x: x**5),
        (lambda x: x**-3, lambda x: x**-3),
        (lambda x: x**2.5, lambda x: x ** mp.mpf(2.5)),
        (lambda x: jnp.clip(x, 0.25, 0.5), lambda x: min(max(x, 0.25), 0.5)),
        (lambda x: jnp.where((x > 0.5) & (x != 0.75), 1 / x, -x), lambda x: 1 / x if x > 0.5 else -x),
        (lambda x: jnp.abs(jnp.floor(-3 * x)) + jnp.sign(x), lambda x: abs(mp.floor(-3 * x)) + 1),
    ],
)
def test_functions_have_fifty_digits(function, truth):
    # Oracle: mpmath's own functions at the same numbers.
    x = np.array([1e-9, 0.1, 0.3, 0.9, 1 - 1e-12])
    with mpmath.workdps(DIGITS):
        close(exact(jax.vmap(function), x), [truth(mpmath.mpf(one)) for one in x])


def test_tables_products_and_reductions_have_fifty_digits():
    # Oracle: the same sums and look-ups in plain Python.
    table = np.linspace(0.1, 2.3, 12).reshape(4, 3)

    def interpolate(x, m):
        place = jnp.clip(jnp.floor(x * 3), 0, 2)
        row = place.astype(jnp.int32)
        low, high = jnp.asarray(table)[row], jnp.take(jnp.asarray(table), row + 1, axis=0)
        mixed = low + (high - low) * (x * 3 - place)
        return jnp.concatenate([m @ mixed, jnp.stack([mixed.sum(), mixed.max(), mixed.min(), jnp.prod(mixed)])])

    rng = np.random.default_rng(0)
    x, m = np.array([0.0, 0.2, 0.5, 0.99, 1.0]), rng.normal(size=(5, 3, 3))
    value = exact(jax.vmap(interpolate), x, m)
    with mpmath.workdps(DIGITS):
        for row, a, matrix in zip(value, x, m, strict=True):
            place = min(int(a * 3), 2)
            t = mpmath.mpf(a) * 3 - place
            mixed = [mpmath.mpf(p) + (mpmath.mpf(q) - mpmath.mpf(p)) * t for p, q in zip(*table[place : place + 2])]  # noqa: B905
            truth = [mpmath.fsum(mpmath.mpf(c) * y for c, y in zip(line, mixed, strict=True)) for line in matrix]
            truth += [mpmath.fsum(mixed), max(mixed), min(mixed), mpmath.fprod(mixed)]
            close(row, truth)


def test_what_is_not_finite_is_as_in_ieee_arithmetic():
    x = np.array([0.0, -1.0])

    def awkward(x):
        return jnp.stack([1 / x, x / x, jnp.sqrt(x), jnp.log(x), jnp.exp(x * 1e300), jnp.where(x < 0, x, jnp.log(x))])

    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(exact(awkward, x).astype(np.float64), np.asarray(awkward(x)))


def test_an_operation_without_digits_is_named():
    with pytest.raises(NotImplementedError, match="`lgamma` has no 50-digit version"):
        exact(jax.scipy.special.gammaln, np.array(0.5))


def ggx_points(alpha, count):
    """Pairs whose half vectors have angles up to 4 alpha, as in the table of NUMERICS.md, and their D in 50 digits."""
    rng = np.random.default_rng(5)
    theta, tilt = rng.uniform(0, 1.4, count), np.arctan(4 * alpha * rng.random(count))
    phi = rng.uniform(0, 2 * np.pi, count)
    h = np.stack([np.sin(tilt) * np.cos(phi), np.sin(tilt) * np.sin(phi), np.cos(tilt)], axis=-1)
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)
    wo = 2 * np.sum(wi * h, axis=-1, keepdims=True) * h - wi
    keep = wo[:, 2] > 1e-3
    wi, wo, alpha = wi[keep].astype(np.float32), wo[keep].astype(np.float32), np.float32(alpha)
    truth = []
    # The formula as printed cancels: twice alpha's digits are lost.
    with mpmath.workdps(DIGITS + 20):
        a2 = mpmath.mpf(float(alpha)) ** 2
        for i, o in zip(wi.tolist(), wo.tolist(), strict=True):
            h = [mpmath.mpf(x) + mpmath.mpf(y) for x, y in zip(i, o, strict=True)]
            cos2 = h[2] ** 2 / mpmath.fsum(x * x for x in h)
            truth.append(a2 / (mpmath.pi * (cos2 * (a2 - 1) + 1) ** 2))
    return wi, wo, alpha, np.array(truth, object)


def worst(value, truth):
    return max(float(abs(number(v) - t) / t) for v, t in zip(value, truth, strict=True))


def test_the_interpreter_agrees_with_the_textbook_formula_of_ggx():
    # Oracle: NUMERICS.md's D = alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2) in 50 digits; pi is a double in ours.
    wi, wo, alpha, truth = ggx_points(1e-3, 50)
    slope = np.full(len(wi), alpha)
    value = exact(jax.vmap(lambda i, o, alpha: d_ggx(geometry(i, o), alpha, alpha)), wi, wo, slope)
    with mpmath.workdps(DIGITS):
        close(value * (number(np.pi) / mpmath.pi), truth)


@pytest.mark.parametrize("alpha", [1e-3, 3e-3, 1e-2, 0.1, 0.5, 1.0])
def test_ggx_density_in_float32_stays_within_its_bar(alpha):
    # Oracle: NUMERICS.md's formula in 50 digits.
    wi, wo, alpha, truth = ggx_points(alpha, 400)
    with jax.enable_x64(False):
        slope = jnp.asarray(alpha)
        density = jax.jit(jax.vmap(lambda i, o: d_ggx(geometry(i, o), slope, slope)))(wi, wo)
    assert density.dtype == jnp.float32
    assert worst(density, truth) <= GGX_BAR


@pytest.mark.gpu
@pytest.mark.parametrize("alpha", [1e-3, 3e-3, 1e-2, 0.1, 0.5, 1.0])
def test_ggx_density_in_glsl_stays_within_its_bar(alpha):
    # Oracle: NUMERICS.md's formula in 50 digits.
    from shaders.evaluation import evaluate
    from shaders.twin import Twin

    wi, wo, alpha, truth = ggx_points(alpha, 400)
    density = "d_ggx(geometry(wi, wo), alpha, alpha)"
    includes = '#include "common.glsl"\n#include "distributions.glsl"\n'
    body = f"vec3 brdf(vec3 wi, vec3 wo) {{ float alpha = {alpha:.9g}; return vec3({density}); }}\n"
    twin = Twin(includes + body, bytes(16), 0, is_anisotropic=False)
    assert worst(evaluate(twin, wi, wo)[:, 0], truth) <= GGX_BAR


# The command line.


def test_the_command_prints_json_and_says_how_far_it_is():
    arguments = ("stress", "lambert", "--points", "3000", "--exact-points", "32", "--no-gpu", "--json", "--seed", "2")
    command = [str(pathlib.Path(sys.executable).parent / "brdf"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["lambert"]
    assert found["passed"]
    assert set(found["faults"]) == {"JAX float32", "JAX float64"}
    assert "50 digits" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["gxg"], "Did you mean `ggx`"),
        (["lambert+"], "is not a model"),
        (["lambert", "--points", "0"], "--points"),
        (["lambert", "--points", "many"], "not a valid integer"),
        (["lambert", "--exact-points", "-1"], "--exact-points"),
        (["lambert", "--json", "--markdown"], "exclude each other"),
    ],
)
def test_mistakes_get_one_message_and_status_2(arguments, message, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["brdf", "stress", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    assert message in capsys.readouterr().err


def test_a_fault_means_status_1(monkeypatch, capsys):
    from brdf import registry

    # The command's own cache folder is for users.
    monkeypatch.setattr(options, "cache_compilations", lambda: None)
    monkeypatch.setattr(sys, "argv", ["brdf", "stress", "lambert", "--points", "2000", "--no-gpu", "-q"])
    monkeypatch.setattr(registry, "build", lambda name: NegativeAtTheUpperBound())
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 1
    assert "FAILED" in capsys.readouterr().out
