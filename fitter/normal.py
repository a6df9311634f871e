"""The normal equations of a fit, added up chunk by chunk in forward mode: no Jacobian of the measurement is stored."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .loss import Samples, residual
from .unknowns import Unknowns


class NormalEquations(NamedTuple):
    """Cost, gradient and Gauss-Newton Hessian of a least-squares problem at one point.

    - `cost`: half the sum of squared residuals.
    - `gradient`: shape (k,), J^T r.
    - `hessian`: shape (k, k), J^T J.
    """

    cost: Float[Array, ""]
    gradient: Float[Array, " k"]
    hessian: Float[Array, "k k"]


def normal_equations(
    unknowns: Unknowns, y: Float[Array, " k"], samples: Samples, count: Int[Array, ""]
) -> NormalEquations:
    """The normal equations at `y` over the first `count` chunks of the samples."""
    tangents, places = _directions(unknowns)

    def add(index: Array, total: NormalEquations) -> NormalEquations:
        chunk = samples.chunk(index)

        r, push = jax.linearize(lambda y: residual(unknowns.model(y), chunk), y)
        columns = [push(tangent) for tangent in tangents]
        # Sums of products, one by one: XLA fuses them, but hands a contraction of thin matrices to a slow routine.
        products = _table([[jnp.sum(a * b, axis=1) for b in columns] for a in columns], y)
        slopes = _table([[jnp.sum(a * r, axis=1)] for a in columns], y)[..., 0]
        return NormalEquations(
            total.cost + 0.5 * jnp.vdot(r, r),
            total.gradient + jnp.einsum("cgk,cg->k", places, slopes),
            total.hessian + jnp.einsum("cgk,cgh,chl->kl", places, products, places),
        )

    k = unknowns.size
    start = NormalEquations(jnp.zeros((), y.dtype), jnp.zeros(k, y.dtype), jnp.zeros((k, k), y.dtype))
    return jax.lax.fori_loop(0, count, add, start)


def score_products(
    unknowns: Unknowns, y: Float[Array, " k"], samples: Samples, count: Int[Array, ""]
) -> Float[Array, "k k"]:
    """The sum over samples of the outer product of each sample's own gradient, its channels taken together.

    Beside the Hessian it tells how far the solution scatters, whatever the distribution of the errors and however the
    channels of a sample are correlated.
    """
    tangents, places = _directions(unknowns)

    def add(index: Array, total: Float[Array, "k k"]) -> Float[Array, "k k"]:
        chunk = samples.chunk(index)
        r, push = jax.linearize(lambda y: residual(unknowns.model(y), chunk), y)
        scores = jnp.zeros((unknowns.size, r.shape[1]), y.dtype)
        for g, tangent in enumerate(tangents):
            scores = scores + jnp.einsum("ck,cn->kn", places[:, g], push(tangent) * r)
        return total + scores @ scores.T

    return jax.lax.fori_loop(0, count, add, jnp.zeros((unknowns.size, unknowns.size), y.dtype))


def _table(rows: list[list[Array]], y: Float[Array, " k"]) -> Float[Array, "3 rows columns"]:
    if not rows:
        return jnp.zeros((3, 0, 1), y.dtype)
    return jnp.moveaxis(jnp.stack([jnp.stack(row) for row in rows]), -1, 0)


def _directions(unknowns: Unknowns) -> tuple[np.ndarray, np.ndarray]:
    """Directions of differentiation, and where each one's derivative of a channel belongs.

    Where a channel of the value depends on that channel of a colour alone, one direction serves all three.

    **Returns:**

    - shape (g, k): the directions.
    - shape (3, g, k): one where channel c's derivative along direction g is the derivative by element k.
    """
    k = unknowns.size
    if unknowns.mixes_channels:
        return np.eye(k), np.broadcast_to(np.eye(k), (3, k, k))
    tangents = np.zeros((len(unknowns.free), k))
    places = np.zeros((3, len(unknowns.free), k))
    for g, unknown in enumerate(unknowns.free):
        tangents[g, unknown.elements] = 1
        for channel in range(3):
            places[channel, g, unknown.offset + (channel if unknown.parameter.size == 3 else 0)] = 1
    return tangents, places
