"""Integrals over the hemisphere by quadrature: the directional albedo, the truth behind energy laws."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from .model import AbstractBRDF, Color, evaluate


def albedo(model: AbstractBRDF, theta: float, nodes: int = 128) -> Color:
    """The fraction of light from all around that is reflected towards one direction.

    By reciprocity it is also the fraction of light from that direction that is reflected at all. Use it for models
    without a sharp highlight: the nodes resolve slopes down to about 0.1.

    **Arguments:**

    - `model`: any model or sum.
    - `theta`: polar angle of the direction in radians, in [0, pi/2).
    - `nodes`: of the Gauss-Legendre rule over the cosine, and twice as many around.

    **Returns:** shape (3,), linear Rec. 709.
    """
    abscissas, weights = np.polynomial.legendre.leggauss(nodes)
    cos_i, weights = 0.5 * (1 + abscissas), 0.5 * weights
    phi = (np.arange(2 * nodes) + 0.5) * (np.pi / nodes)
    sin_i = np.sqrt(1 - cos_i * cos_i)
    wi = np.stack(
        [np.outer(sin_i, np.cos(phi)), np.outer(sin_i, np.sin(phi)), np.outer(cos_i, np.ones_like(phi))], axis=-1
    ).reshape(-1, 3)
    wo = np.broadcast_to([np.sin(theta), 0.0, np.cos(theta)], wi.shape)
    weight = np.repeat(cos_i * weights, 2 * nodes) * (np.pi / nodes)
    return jnp.sum(evaluate(model, wi, wo) * weight[:, None], axis=0)
