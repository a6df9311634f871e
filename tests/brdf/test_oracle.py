"""Models and their terms against values that independent implementations computed in float64."""

import jax
import numpy as np

from brdf import MODELS
from brdf.distributions import cos_lambda_ggx, d_beckmann, d_ggx
from brdf.frame import geometry
from brdf.masking import v_smith_separable


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
