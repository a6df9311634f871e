"""Integrals over the hemisphere by quadrature in float64: the truth behind energy laws."""

from __future__ import annotations

import functools

import jax
import numpy as np
from jaxtyping import Float

from .model import AbstractBRDF, evaluate


def albedo(model: AbstractBRDF, theta: float, nodes: int = 128) -> Float[np.ndarray, "3"]:
    """The fraction of light from all around that is reflected towards one direction.

    By reciprocity it is also the fraction of light from that direction that is reflected at all. Use it for models
    without a sharp highlight: the nodes resolve slopes down to about 0.1.

    **Arguments:**

    - `model`: any model or sum.
    - `theta`: polar angle of the direction in radians, in [0, pi/2).
    - `nodes`: of the Gauss-Legendre rule over the cosine, and twice as many around.

    **Returns:** shape (3,), linear Rec. 709.
    """
    wi, weight = _hemisphere(nodes)
    wo = np.broadcast_to([np.sin(theta), 0.0, np.cos(theta)], wi.shape)
    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, wi, wo))
    return (value * (wi[:, 2] * weight)[:, None]).sum(axis=0)


@functools.cache
def _hemisphere(nodes: int) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
    """Directions and weights in sr, which add up to 2 pi."""
    abscissas, weights = np.polynomial.legendre.leggauss(nodes)
    cosine, weights = 0.5 * (1 + abscissas), 0.5 * weights
    phi = (np.arange(2 * nodes) + 0.5) * (np.pi / nodes)
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    across = [np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cosine, np.ones_like(phi))]
    return np.stack(across, axis=-1).reshape(-1, 3), np.repeat(weights, 2 * nodes) * (np.pi / nodes)
