"""The normal equations of a fit, added up chunk by chunk in forward mode: no Jacobian of the measurement is stored.

Each free parameter is differentiated by itself, so that nothing that does not depend on it is compiled into its
derivative; and where a channel of the value depends on that channel of a colour alone, one derivative serves all three.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental.layout import Layout, with_layout_constraint
from jaxtyping import Array, Bool, Float, Int

from brdf.frame import Geometry, geometry
from brdf.model import AbstractBRDF

from .levenberg import NormalEquations
from .loss import LOSSES, Values, compressed, log_compress
from .samples import Samples
from .unknowns import Unknown, Unknowns


class Assessment(NamedTuple):
    """What a pass over the samples tells about one point of the parameters.

    - `equations`: the normal equations of the loss.
    - `log_abs`, `log_square`: sums of |d| and d^2 over samples of positive weight and channels, of the difference d of
      `log(1 + f cos_i)`.
    - `scores`: shape (k, k), the sum over samples of the outer product of each sample's own gradient, its channels
      taken together; zero unless asked for. Beside the Hessian it tells how far the solution scatters, whatever the
      distribution of the errors and however the channels of a sample are correlated.
    """

    equations: NormalEquations
    log_abs: Float[Array | np.ndarray, ""]
    log_square: Float[Array | np.ndarray, ""]
    scores: Float[Array | np.ndarray, "k k"]


def assess(
    unknowns: Unknowns,
    y: Float[Array | np.ndarray, " k"],
    samples: Samples,
    loss: str,
    first: Int[Array | np.ndarray, ""],
    count: Int[Array | np.ndarray, ""],
    scores: Bool[Array | np.ndarray, ""],
) -> Assessment:
    """Assesses a point over `count` chunks of a slab, beginning with `first`."""
    model = unknowns.model(y)
    k = unknowns.size
    places = _places(unknowns)

    def add(index: Array, total: tuple[Any, ...]) -> tuple[Any, ...]:
        chunk = samples.chunk(index)
        g = jax.vmap(geometry, in_axes=-1, out_axes=-1)(chunk.wi, chunk.wo)
        value = jax.lax.optimization_barrier(_channels_first(_value(model, g)))
        columns = [column for unknown in unknowns.free for column in _derivatives(unknowns, model, unknown, y, g)]
        cos_i = chunk.wi[2:3]
        z, rise = compressed(LOSSES[loss], value, cos_i)
        judged = LOSSES[loss].judge(z - LOSSES[loss].compress(chunk.value, cos_i), chunk.scale)
        distance = log_compress(value, cos_i) - log_compress(chunk.value, cos_i)
        used = (chunk.weight > 0).astype(y.dtype)
        slope = chunk.weight * rise * judged.slope
        curvature = chunk.weight * rise * rise * judged.curvature
        # Values and derivatives are computed once and kept: fused into each of the sums, they would be computed anew.
        columns, slope, curvature = jax.tree.map(_channels_first, (columns, slope, curvature))
        columns, slope, curvature = jax.lax.optimization_barrier((columns, slope, curvature))
        sums = [*_sums([chunk.weight * judged.cost, used * jnp.abs(distance), used * distance * distance])]
        for row, column in enumerate(columns):
            bent = curvature * column
            sums += _sums([slope * column, *(bent * other for other in columns[: row + 1])])
        own = jax.lax.cond(
            jnp.asarray(scores), lambda: _scores(columns, slope, places, y), lambda: jnp.zeros((k, k), y.dtype)
        )
        return total[0] + jnp.stack(sums), total[1] + own

    size = 3 + sum(range(2, places.shape[1] + 2))
    blank = jnp.zeros((size, 3), y.dtype), jnp.zeros((k, k), y.dtype)
    sums, own = jax.lax.fori_loop(first, first + count, add, blank)
    gradient, hessian = _assemble(sums[3:], places, y)
    cost, log_abs, log_square = sums[:3].sum(axis=1)
    return Assessment(NormalEquations(cost, gradient, hessian), log_abs, log_square, own)


def _channels_first(x: Values | Array) -> Array:
    """The same values, laid out channel by channel."""
    return with_layout_constraint(x, Layout((0, 1)))


def _value(model: AbstractBRDF, g: Geometry) -> Values:
    """The model's value; every sample is above the horizon."""
    return jax.vmap(model.reflect, in_axes=-1, out_axes=-1)(g)


def _derivatives(
    unknowns: Unknowns, model: AbstractBRDF, unknown: Unknown, y: Float[Array | np.ndarray, " k"], g: Geometry
) -> list[Values]:
    """The derivatives of the value by one unknown: one, or one per channel of a colour that mixes channels."""
    at = y[unknown.elements] if unknown.parameter.size == 3 else y[unknown.offset]

    def lobes(x: Array) -> Values:
        first, *others = (_value(lobe, g) for lobe in unknowns.depending(model, unknown, x))
        return sum(others, first)

    if _splits(unknowns, unknown):
        return [jax.jvp(lobes, (at,), (row,))[1] for row in jnp.eye(3, dtype=y.dtype)]
    return [jax.jvp(lobes, (at,), (jnp.ones_like(at),))[1]]


def _splits(unknowns: Unknowns, unknown: Unknown) -> bool:
    return unknown.parameter.size == 3 and unknowns.mixes_channels(unknown)


def _places(unknowns: Unknowns) -> np.ndarray:
    """Shape (3, columns, k): one where channel c of a column is the derivative by element k."""
    rows = []
    for unknown in unknowns.free:
        row = np.zeros((3, unknowns.size))
        for channel in range(3):
            row[channel, unknown.offset + (channel if unknown.parameter.size == 3 else 0)] = 1
        if _splits(unknowns, unknown):
            rows += [np.tile(np.eye(unknowns.size)[unknown.offset + element], (3, 1)) for element in range(3)]
        else:
            rows.append(row)
    return np.stack(rows, axis=1) if rows else np.zeros((3, 0, 0))


def _sums(products: Sequence[Values]) -> tuple[Float[Array, "3"], ...]:
    """Sums over the samples, all in one pass over memory."""
    zeros = tuple(np.zeros((), products[0].dtype) for _ in products)
    return jax.lax.reduce(tuple(products), zeros, lambda a, b: tuple(x + y for x, y in zip(a, b, strict=True)), (1,))


def _assemble(
    sums: Float[Array, "m 3"], places: np.ndarray, y: Float[Array | np.ndarray, " k"]
) -> tuple[Float[Array, " k"], Float[Array, "k k"]]:
    """Gradient and Hessian of the elements from the sums of each column, its slope first, then its products."""
    columns = places.shape[1]
    if not columns:
        return jnp.zeros(0, y.dtype), jnp.zeros((0, 0), y.dtype)
    # Row r of the table: the slope of column r, and its products with columns 0 to r, after those of the rows before.
    starts = np.cumsum([0, *range(2, columns + 1)])
    slopes = sums[starts]
    high, low = np.maximum.outer(np.arange(columns), np.arange(columns)), np.minimum.outer(*2 * [np.arange(columns)])
    products = sums[starts[high] + 1 + low]
    gradient = jnp.einsum("cgk,gc->k", places, slopes)
    return gradient, jnp.einsum("cgk,ghc,chl->kl", places, products, places)


def _scores(
    columns: list[Values],
    slope: Values,
    places: np.ndarray,
    y: Float[Array | np.ndarray, " k"],
) -> Float[Array, "k k"]:
    own = jnp.zeros((y.size, slope.shape[1]), y.dtype)
    for g, column in enumerate(columns):
        own = own + jnp.einsum("ck,cn->kn", places[:, g], column * slope)
    return own @ own.T
