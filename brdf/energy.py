"""Multiple scattering between facets: the energy that a single-scattering microfacet model loses, given back.

    f_ms = F_ms (1 - E(cos_i)) (1 - E(cos_o)) / (pi (1 - E_avg)),   F_ms = F_avg^2 E_avg / (1 - F_avg (1 - E_avg))

E is the directional albedo of the model with F = 1 and Smith's height-correlated masking, E_avg its cosine-weighted
mean. It is reciprocal, and a white surface then reflects everything, to 6e-3.

- Kulla, Conty 2017, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course notes.
- Jakob, d'Eon, Jakob, Marschner 2014, "A Comprehensive Framework for Rendering Layered Materials", supplement: F_ms.

E is a quadrature over directions drawn from visible GGX normals, kept as a Chebyshev table. The twin of this file is
part of `shaders/glsl/microfacet.glsl`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from .chebyshev import Chebyshev, interpolate
from .distributions import alpha_sin2, cos_lambda_beckmann, cos_lambda_ggx, d_beckmann, d_ggx
from .frame import HORIZON, Color, Geometry, Scalar, geometry
from .gaussian import cos_lambda_gaussian, d_gaussian, norm_table, seen_slope
from .masking import v_smith
from .sampling import pdf_ggx, sample_ggx

_Density = Callable[[Geometry, Scalar], Scalar]
_CosLambda = Callable[[Scalar, Scalar], Scalar]
_DISTRIBUTIONS: dict[str, tuple[_Density, _CosLambda]] = {
    "ggx": (lambda g, alpha: d_ggx(g, alpha, alpha), cos_lambda_ggx),
    "beckmann": (lambda g, alpha: d_beckmann(g, alpha, alpha), cos_lambda_beckmann),
    "gaussian": (
        lambda g, alpha: d_gaussian(g, alpha, alpha, norm_table()(alpha * alpha)),
        lambda cos_theta, alpha_sin2: cos_lambda_gaussian(cos_theta, seen_slope(cos_theta, alpha_sin2)),
    ),
}
# Cosines and slopes of the table, and nodes of the quadrature per direction.
_COSINES, _ALPHAS, _NODES = 12, 10, 64
# A loss is rounded up smoothly, to 4e-3 at least: one that is nothing but rounding errors of the table would be the
# whole value where a narrow lobe has none.
_SOFTNESS = 8e-3
# Gauss-Legendre nodes in the cosine: exact for Schlick's polynomials, with their tint where it is not cut at 0; good to
# 1e-3 for the other choices.
_FRESNEL_NODES = 5


def _reduced(cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """The table's variable, in which the loss at grazing angles has the same shape for all slopes."""
    return cos_theta * (1 + alpha) / (cos_theta + alpha)


def _softened(loss: Scalar) -> Scalar:
    return 0.5 * (loss + jnp.sqrt(loss * loss + _SOFTNESS * _SOFTNESS))


@functools.cache
def loss_table(distribution: str) -> Chebyshev:
    """`1 - E`, not yet softened, as a function of `_reduced(cos_theta, alpha)` and alpha."""

    def loss(u: np.ndarray, alpha: np.ndarray) -> np.ndarray:
        cos_theta = u * alpha / (1 + alpha - u)
        return 1 - _directional_albedo(distribution, cos_theta, alpha)

    return interpolate(loss, _COSINES, _ALPHAS)


@functools.cache
def mean_loss_table(distribution: str) -> Chebyshev:
    """`1 - E_avg` as a function of alpha, from the other table."""
    table = loss_table(distribution)
    x, weight = np.polynomial.legendre.leggauss(200)
    # Denser towards grazing angles, where a small slope loses its energy.
    s, weight = 0.5 * (1 + x), 0.5 * weight
    cosine, weight = s**3, weight * 3 * s**2

    def mean(alpha: np.ndarray) -> np.ndarray:
        def loss_at(cosine: Scalar, alpha: Scalar) -> Scalar:
            return _softened(table(_reduced(cosine, alpha), alpha))

        with jax.ensure_compile_time_eval(), jax.enable_x64(True):
            loss = np.asarray(jax.jit(jax.vmap(jax.vmap(loss_at, (None, 0)), (0, None)))(cosine, alpha))
        return 2 * (weight * cosine) @ loss

    return interpolate(mean, _ALPHAS)


def _directional_albedo(distribution: str, cosines: np.ndarray, alphas: np.ndarray) -> np.ndarray:
    density, cos_lambda = _DISTRIBUTIONS[distribution]
    x, weight = np.polynomial.legendre.leggauss(_NODES)
    u, weight = 0.5 * (1 + x), 0.5 * weight
    # Mirror-symmetric about the plane of incidence: half the azimuth is enough.
    points = np.stack(np.meshgrid(0.5 * u, u, indexing="ij"), axis=-1).reshape(-1, 2)
    weights = np.outer(weight, weight).reshape(-1)

    def ratio(wo: jax.Array, alpha: jax.Array, u: jax.Array | np.ndarray) -> jax.Array:
        wi = sample_ggx(wo, alpha, alpha, u)
        above = wi[2] > HORIZON
        g = geometry(jnp.where(above, wi, wo), wo)
        lambdas = (cos_lambda(w[2], alpha_sin2(w, alpha, alpha)) for w in (g.wi, g.wo))
        value = density(g, alpha) * v_smith(g, *lambdas) * g.cos_i / pdf_ggx(g, alpha, alpha)
        return jnp.where(above, value, 0.0)

    @jax.jit
    def albedo(cos_o: jax.Array, alpha: jax.Array) -> jax.Array:
        wo = jnp.stack([jnp.sqrt((1 - cos_o) * (1 + cos_o)), jnp.zeros_like(cos_o), cos_o])
        return jnp.vdot(weights, jax.vmap(ratio, (None, None, 0))(wo, alpha, points))

    with jax.ensure_compile_time_eval(), jax.enable_x64(True):
        pairs = zip(cosines.reshape(-1), alphas.reshape(-1), strict=True)
        return np.array([float(albedo(*pair)) for pair in pairs]).reshape(cosines.shape)


def directional_loss(distribution: str, cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """`1 - E`, rounded up smoothly: the part of white light that leaves no facet at once."""
    return _softened(loss_table(distribution)(_reduced(cos_theta, alpha), alpha))


def multiple_scattering(
    distribution: str, g: Geometry, alpha: Scalar, fresnel: Callable[[Scalar, Scalar], Color]
) -> Color:
    """What is reflected after several facets, in 1/sr.

    **Arguments:**

    - `distribution`: `"ggx"`, `"beckmann"` or `"gaussian"`.
    - `g`: the directions.
    - `alpha`: the slope; for unequal ones their geometric mean, an approximation.
    - `fresnel`: reflectance as a function of `cos_d` and `1 - cos_d`.
    """
    loss_i, loss_o = (directional_loss(distribution, cosine, alpha) for cosine in (g.cos_i, g.cos_o))
    mean_loss = mean_loss_table(distribution)(alpha)
    f = fresnel_average(fresnel, alpha)
    f_multiple = f * f * (1 - mean_loss) / (1 - f * mean_loss)
    return f_multiple * (loss_i / mean_loss * (loss_o / math.pi))


def fresnel_average(fresnel: Callable[[Scalar, Scalar], Color], like: Scalar) -> Color:
    """The cosine-weighted mean of a reflectance over the hemisphere, in the precision of `like`."""
    abscissas, weights = np.polynomial.legendre.leggauss(_FRESNEL_NODES)
    total = None
    for x, weight in zip(abscissas.tolist(), weights.tolist(), strict=True):
        cosine = 0.5 * (1 + x) * jnp.ones_like(like)
        part = weight * cosine * fresnel(cosine, 1 - cosine)
        total = part if total is None else total + part
    assert total is not None
    return total
