"""The geometry of a pair of directions, computed once per evaluation and shared by all lobes of a sum.

Rounding sets the rules here (Ngan 2005 and most code lose sharp highlights to it): nothing starts from a rounded
`n . h`. The half vector stays unnormalised, `h = wi + wo`, so that `h_x`, `h_y` are exact to one rounding even where
`wi` and `wo` nearly mirror each other, and `tan^2(theta_h) = (h_x^2 + h_y^2) / h_z^2` needs no normalisation.
The same vector times a power of two, of a length near 1, is `m`: quotients of its components are those of `h`, but
their derivatives stay inside the range of float32 where both directions graze the surface and `h` nearly vanishes.
The difference angle comes from `|wi + wo|` and `|wi - wo|`, which are its cosine and sine up to a common factor.
The twin of this file is `shaders/glsl/common.glsl`.
"""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

Direction = Float[Array | np.ndarray, "3"]
Scalar = Float[Array | np.ndarray, ""]
Color = Float[Array | np.ndarray, "3"]

# Below this cosine a direction counts as below the horizon: products of two cosines and their inverses, squared, stay
# inside the range of float32.
HORIZON = 1e-9


class Geometry(eqx.Module):
    """What the lobes of a model need to know of `wi` and `wo`, both above the horizon.

    - `cos_i`, `cos_o`, `sin2_i`, `sin2_o`: cosine and squared sine of the polar angles.
    - `dot_xy`: `wi . wo` in the tangent plane, that is `sin_i sin_o cos(phi_i - phi_o)`.
    - `h_x`, `h_y`, `h_z`, `h2`: the unnormalised half vector `wi + wo` and its squared length.
    - `m_x`, `m_y`, `m_z`, `m_z2`, `m2`: the half vector of a length between 1/32 and 2, its z squared without the
      rounding of the sum in it, and its squared length.
    - `cos_d`, `one_minus_cos_d`: of the angle between either direction and the half vector.
    """

    wi: Direction
    wo: Direction
    cos_i: Scalar
    cos_o: Scalar
    sin2_i: Scalar
    sin2_o: Scalar
    dot_xy: Scalar
    h_x: Scalar
    h_y: Scalar
    h_z: Scalar
    h2: Scalar
    m_x: Scalar
    m_y: Scalar
    m_z: Scalar
    m_z2: Scalar
    m2: Scalar
    cos_d: Scalar
    one_minus_cos_d: Scalar


def above_horizon(wi: Direction, wo: Direction) -> Bool[Array, ""]:
    """Whether both directions are above the horizon, where a reflectance model is not zero."""
    return (wi[2] > HORIZON) & (wo[2] > HORIZON)


def geometry(wi: Direction, wo: Direction) -> Geometry:
    """The geometry of a pair of unit directions that are both above the horizon (see `above_horizon`)."""
    h_x, h_y, h_z = wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]
    d_x, d_y, d_z = wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]
    h2 = h_x * h_x + h_y * h_y + h_z * h_z
    d2 = d_x * d_x + d_y * d_y + d_z * d_z
    cos_d = jnp.sqrt(h2 / (h2 + d2))
    scale = _power_of_two(h2)
    m_x, m_y, m_z = scale * h_x, scale * h_y, scale * h_z
    # The rounding error of the sum h_z (Knuth 1969, section 4.2.2): the square of z matters most in a narrow highlight.
    virtual = h_z - wi[2]
    error = scale * ((wi[2] - (h_z - virtual)) + (wo[2] - virtual))
    m_z2 = m_z * m_z + 2 * m_z * error
    return Geometry(
        wi=wi,
        wo=wo,
        cos_i=wi[2],
        cos_o=wo[2],
        sin2_i=wi[0] * wi[0] + wi[1] * wi[1],
        sin2_o=wo[0] * wo[0] + wo[1] * wo[1],
        dot_xy=wi[0] * wo[0] + wi[1] * wo[1],
        h_x=h_x,
        h_y=h_y,
        h_z=h_z,
        h2=h2,
        m_x=m_x,
        m_y=m_y,
        m_z=m_z,
        m_z2=m_z2,
        m2=m_x * m_x + m_y * m_y + m_z2,
        cos_d=cos_d,
        one_minus_cos_d=d2 / ((h2 + d2) * (1 + cos_d)),
    )


def _power_of_two(h2: Scalar) -> Scalar:
    """What brings a vector of this squared length, at most 4, to a length of 1/32 or more, down to 2^-30."""
    scale = jnp.ones_like(h2)
    for exponent in (5, 10, 15, 20, 25):
        scale = jnp.where(h2 < 2.0 ** (-2 * exponent), 2.0**exponent * jnp.ones_like(h2), scale)
    return jax.lax.stop_gradient(scale)


def turned(g: Geometry, rotation: Scalar) -> Geometry:
    """The geometry seen from a tangent frame that is turned about the normal by `rotation` radians."""
    c, s = jnp.cos(rotation), jnp.sin(rotation)
    wi = jnp.stack([c * g.wi[0] + s * g.wi[1], c * g.wi[1] - s * g.wi[0], g.wi[2]])
    wo = jnp.stack([c * g.wo[0] + s * g.wo[1], c * g.wo[1] - s * g.wo[0], g.wo[2]])
    h_x, h_y = c * g.h_x + s * g.h_y, c * g.h_y - s * g.h_x
    m_x, m_y = c * g.m_x + s * g.m_y, c * g.m_y - s * g.m_x
    return dataclasses.replace(g, wi=wi, wo=wo, h_x=h_x, h_y=h_y, m_x=m_x, m_y=m_y)
