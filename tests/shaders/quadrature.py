"""The radiance that a point reflects, by float64 quadrature: the truth that the preview is held to.

The quadrature runs over half vectors in polar coordinates of their slope, `tan(theta_h) = scale s / (1 - s)`: as many
nodes inside a highlight as outside, however sharp it is, and all directions are reached. Each lobe of a sum is
integrated with its own scale. In float64 the error is that of the horizon's cut, which falls with the square of the
number of nodes.

- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 14: the Jacobian
  of reflection about a half vector.
"""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from brdf.frame import Direction
from brdf.model import AbstractBRDF, Color, evaluate
from brdf.parameter import parameters
from brdf.registry import split

Incident = Callable[[Float[Array, "n 3"]], Float[Array, "n 3"]]


def reflected_radiance(model: AbstractBRDF, wo: Direction, incident: Incident, nodes: int = 512) -> Color:
    """The radiance that a surface point sends to the viewer under light from all around.

    Use it in float64, as the truth that a sampled picture is held to.

    **Arguments:**

    - `model`: any model or sum.
    - `wo`: shape (3,), unit, to the viewer, in the local frame with normal +z, above the horizon.
    - `incident`: takes directions to the light, shape (n, 3), local frame, and returns their radiance, shape (n, 3).
    - `nodes`: along the slope, and twice as many around.

    **Returns:** shape (3,), in the unit of `incident`.
    """
    total = jnp.zeros(3, wo.dtype)
    for lobe in split(model).values():
        wi, solid_angle = _nodes(wo, _scale(lobe), nodes)
        values = evaluate(lobe, wi, jnp.broadcast_to(wo[None, :], wi.shape))
        total = total + jnp.sum(values * incident(wi) * (wi[:, 2] * solid_angle)[:, None], axis=0)
    return total


def _scale(lobe: AbstractBRDF) -> float:
    """The slope of a specular lobe; 1, which spreads the nodes over the hemisphere, for one without."""
    found = [float(getattr(lobe, parameter.name)) for parameter in parameters(lobe) if parameter.slope]
    return min(found, default=1.0)


def _nodes(wo: Direction, scale: float, count: int) -> tuple[Float[Array, "n 3"], Float[Array, " n"]]:
    """Directions to the light, above the horizon or weightless, and their solid angles."""
    abscissas, weights = np.polynomial.legendre.leggauss(count)
    s, weights = 0.5 * (1 + abscissas), 0.5 * weights
    slope = scale * s / (1 - s)
    # d(solid angle of h) = slope (1 + slope^2)^(-3/2) d(slope) d(phi)
    weight = weights * scale / (1 - s) ** 2 * slope * (1 + slope * slope) ** -1.5 * (np.pi / count)
    phi = (np.arange(2 * count) + 0.5) * (np.pi / count)
    cos_h = 1 / np.sqrt(1 + slope * slope)
    h = np.stack(
        [np.outer(slope * cos_h, np.cos(phi)), np.outer(slope * cos_h, np.sin(phi)), np.outer(cos_h, 0 * phi + 1)], -1
    ).reshape(-1, 3)
    cos_d = h @ wo
    wi = 2 * cos_d[:, None] * h - wo[None, :]
    above = (cos_d > 0) & (wi[:, 2] > 0)
    # Walter 2007, eq. 14: d(wi) = 4 (wi . h) d(h)
    solid_angle = jnp.where(above, 4 * cos_d * np.repeat(weight, 2 * count), 0)
    return jnp.where(above[:, None], wi, jnp.array([[0, 0, 1]], wi.dtype)), solid_angle
