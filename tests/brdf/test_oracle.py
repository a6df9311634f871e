"""Models and their terms against values that independent implementations computed in float64."""

import math

import jax
import jax.numpy as jnp
import numpy as np

from brdf import MODELS
from brdf.distributions import cos_lambda_ggx, d_beckmann, d_ggx, d_gtr, gtr_norm
from brdf.frame import geometry
from brdf.fresnel import f_dielectric
from brdf.gaussian import d_gaussian
from brdf.masking import v_kelemen, v_neumann, v_schlick, v_smith_separable


def compare(shared, table, function, rtol, floor=1e-300):
    """Holds `function(params, wi, wo)` to a table, relative to the larger of the value and `floor`."""
    file = np.load(shared / "oracle" / f"{table}.npz")
    value = np.asarray(jax.jit(jax.vmap(function))(file["params"], file["wi"], file["wo"]))
    truth = file["value"] if value.ndim == 2 else file["value"][:, 0]
    error = np.abs(value - np.maximum(truth, 0)) / np.maximum(np.abs(truth), floor)
    assert error.max() <= rtol


def test_oren_nayar_equals_brdf_explorer(shared):
    def value(p, wi, wo):
        return MODELS["oren_nayar"](albedo=jax.numpy.full(3, p[0]), sigma=jax.numpy.deg2rad(p[1]))(wi, wo)

    # The table's own negative values are cut at 0; next to its zeros only the absolute difference means something.
    compare(shared, "orennayar", value, 1e-9, floor=1e-3)


def test_ggx_distribution_equals_brdf_explorer(shared):
    compare(shared, "d_ggx", lambda p, wi, wo: d_ggx(geometry(wi, wo), p[0], p[0]), 1e-9)


def test_beckmann_distribution_equals_brdf_explorer(shared):
    # Far in the tail the table's own numbers are subnormal.
    compare(shared, "d_beckmann", lambda p, wi, wo: d_beckmann(geometry(wi, wo), p[0], p[0]), 1e-9, floor=1e-280)


def test_separable_smith_masking_equals_brdf_explorer(shared):
    def value(p, wi, wo):
        g = geometry(wi, wo)
        lambdas = (cos_lambda_ggx(c, p[0] * p[0] * s) for c, s in ((g.cos_i, g.sin2_i), (g.cos_o, g.sin2_o)))
        # The table holds G / (cos_i cos_o).
        return 4 * v_smith_separable(g, *lambdas)

    compare(shared, "g_walter07", value, 1e-9)


def test_ggx_with_exact_fresnel_equals_brdf_explorer(shared):
    def value(p, wi, wo):
        ggx = MODELS["ggx"](alpha=p[2], ior=p[3], fresnel="dielectric", masking="smith_separable")
        return p[0] / jnp.pi + p[1] * ggx(wi, wo)

    compare(shared, "walter", value, 1e-9)


def test_trowbridge_reitz_equals_brdf_explorer(shared):
    compare(shared, "d_trowbridge_reitz", lambda p, wi, wo: d_ggx(geometry(wi, wo), p[0], p[0]), 1e-9)


def test_gtr_at_gamma_two_is_trowbridge_reitz(shared):
    def value(p, wi, wo):
        two = jnp.asarray(2.0)
        return d_gtr(geometry(wi, wo), p[0], p[0], two, gtr_norm(p[0] * p[0], two))

    compare(shared, "d_trowbridge_reitz", value, 1e-9)


def test_the_gaussian_without_its_norm_equals_brdf_explorer(shared):
    def value(p, wi, wo):
        return jnp.pi * p[0] * p[0] * d_gaussian(geometry(wi, wo), p[0], p[0], jnp.asarray(1.0))

    # Far in the tail ours is cut at exp(-700).
    compare(shared, "d_gaussian", value, 1e-9, floor=1e-290)


def test_neumann_and_kelemen_masking_equal_brdf_explorer(shared):
    # The tables hold G / (cos_i cos_o).
    compare(shared, "g_neumann", lambda p, wi, wo: 4 * v_neumann(geometry(wi, wo)), 1e-9)
    compare(shared, "g_kelemen", lambda p, wi, wo: 4 * v_kelemen(geometry(wi, wo)), 1e-9)


def test_schlick_masking_equals_brdf_explorer(shared):
    # There k = m sqrt(2 / pi), after Schlick 1994.
    compare(shared, "g_schlick", lambda p, wi, wo: 4 * v_schlick(geometry(wi, wo), p[0] * math.sqrt(2 / math.pi)), 1e-9)


def test_dielectric_fresnel_equals_brdf_explorer(shared):
    compare(shared, "f_cooktorrance", lambda p, wi, wo: f_dielectric(p[0], geometry(wi, wo).cos_d), 1e-9)
