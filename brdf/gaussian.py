"""The Gaussian distribution of facet angles, `D ~ exp(-(theta_h / alpha)^2)`, normalised and with its own masking.

It is a Gaussian in the angle, where Beckmann's is one in the slope. Neither its norm nor its masking has a closed form:
both are quadratures, kept as Chebyshev tables.

    norm(alpha^2) = integral over theta of exp(-(theta / alpha)^2) sin(2 theta) / alpha^2
    cos(theta) Lambda(theta) = double integral over kappa > pi/2 - theta and tau of
                               sin(kappa - (pi/2 - theta)) cos^2(tau) D(arccos(cos kappa cos tau))

The second is Smith's masking (Heitz 2014, eq. 43: the mean of the slopes that face away), with the normals written in
two angles of which only kappa meets the limit, so that it is smooth.

- Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures": the distribution, without its norm.
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".

The twin of this file is `shaders/glsl/gaussian.glsl`.
"""

from __future__ import annotations

import functools

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from .chebyshev import Chebyshev, interpolate
from .frame import Geometry, Scalar

_EXPONENT_MAX = 700.0
# Below this tan^2 the series of arctan is exact to 1e-17.
_SERIES_MAX = 1e-3
# Below this sin^2 a direction counts as the normal, where nothing is masked.
_SIN2_MIN = 1e-30
# The table reaches 5 alpha above the horizon for small slopes; exp(-25) of the light lies beyond.
_REACH = 5.0


@functools.cache
def norm_table() -> Chebyshev:
    """The norm as a function of alpha^2, to 1e-13."""
    return interpolate(lambda alpha2: _norm(np.sqrt(alpha2)), 48)


@functools.cache
def masking_table() -> Chebyshev:
    """`cos(theta) Lambda(theta) exp((elevation / alpha)^2) / alpha` as a function of the elevation in units of
    `elevation_max` and of alpha; with its exponential it is good to 1e-5 of `cos(theta) (1 + Lambda)`."""

    def value(u: np.ndarray, alpha: np.ndarray) -> np.ndarray:
        return np.vectorize(_masking)(u * 0.5 * np.pi * np.tanh(_REACH * alpha / (0.5 * np.pi)), alpha)

    return interpolate(value, 16, 16)


@functools.cache
def _rule(count: int) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    abscissas, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (1 + abscissas), 0.5 * weights


def _norm(alpha: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    x, weight = _rule(48)
    limit = np.minimum(0.5 * np.pi, 6.5 * alpha)[..., None]
    theta = limit * x
    return np.sum(np.exp(-((theta / alpha[..., None]) ** 2)) * np.sin(2 * theta) * limit * weight, axis=-1) / alpha**2


def _masking(elevation: float, alpha: float) -> float:
    x, weight = _rule(48)
    spread = min(0.5 * np.pi, np.sqrt(elevation**2 + 42 * alpha**2)) - elevation
    reach = min(0.5 * np.pi, 7 * alpha)
    kappa, tau = (elevation + spread * x)[:, None], (reach * x)[None, :]
    sine = np.sqrt(np.sin(kappa) ** 2 + (np.cos(kappa) * np.sin(tau)) ** 2)
    theta = np.arctan2(sine, np.cos(kappa) * np.cos(tau))
    density = np.exp(-(theta - elevation) * (theta + elevation) / alpha**2) / (np.pi * alpha**2)
    inner = np.sin(kappa - elevation) * np.cos(tau) ** 2 * density / _norm(np.array([alpha]))
    # Both signs of tau.
    return float(2 * spread * reach * weight @ inner @ weight) / alpha


def elevation_max(alpha: Scalar) -> Scalar:
    """The largest elevation above the horizon that the masking table holds."""
    return 0.5 * jnp.pi * jnp.tanh(_REACH / (0.5 * jnp.pi) * alpha)


def d_gaussian(g: Geometry, alpha_x: Scalar, alpha_y: Scalar, norm: Scalar) -> Scalar:
    """The density of normals in 1/sr; `norm` is that of the table, for unequal slopes its `elliptic_mean`."""
    # theta_h / |(m_x, m_y)|, from the series of arctan where that is 0 / 0.
    m2_xy = g.m_x * g.m_x + g.m_y * g.m_y
    x = m2_xy / (g.m_z * g.m_z)
    is_near = x < _SERIES_MAX
    far = jnp.sqrt(jnp.where(is_near, jnp.ones_like(m2_xy), m2_xy))
    near = jnp.where(is_near, x, jnp.zeros_like(x))
    near = (1 - near * (1 / 3 - near * (1 / 5 - near * (1 / 7 - near * (1 / 9 - near / 11))))) / g.m_z
    stretch = jnp.where(is_near, near, jnp.arctan2(far, g.m_z) / far)
    t_x, t_y = stretch * g.m_x / alpha_x, stretch * g.m_y / alpha_y
    exponent = t_x * t_x + t_y * t_y
    inside = exponent < _EXPONENT_MAX
    exponent = jnp.where(inside, exponent, jnp.zeros_like(exponent))
    # In two halves: the exponential may lie below the range of float32 where the density does not.
    decay = jnp.exp(-0.5 * exponent)
    density = decay * (1 / (jnp.pi * alpha_x * alpha_y * norm)) * decay
    return jnp.where(inside, density, jnp.zeros_like(density))


def seen_slope(cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
    """The slope in the plane of a direction; see `brdf.distributions.alpha_sin2`."""
    sin2 = (1 - cos_theta) * (1 + cos_theta)
    is_tilted = sin2 > _SIN2_MIN
    sin2 = jnp.where(is_tilted, sin2, jnp.ones_like(sin2))
    return jnp.minimum(jnp.sqrt(jnp.where(is_tilted, alpha_sin2, jnp.ones_like(sin2)) / sin2), 1)


def cos_lambda_gaussian(cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """`cos(theta) Lambda(theta)`: exact for equal slopes, for unequal ones with the `seen_slope` of the direction."""
    sin2 = (1 - cos_theta) * (1 + cos_theta)
    is_tilted = sin2 > _SIN2_MIN
    elevation = jnp.arctan2(cos_theta, jnp.sqrt(jnp.where(is_tilted, sin2, jnp.ones_like(sin2))))
    ratio = elevation / alpha
    inside = is_tilted & (ratio * ratio < _EXPONENT_MAX)
    ratio = jnp.where(inside, ratio, jnp.zeros_like(ratio))
    u = jnp.minimum(elevation / elevation_max(alpha), 1)
    value = alpha * jnp.exp(-ratio * ratio) * masking_table()(u, alpha)
    return jnp.where(inside, value, jnp.zeros_like(value))
