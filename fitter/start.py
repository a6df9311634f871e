"""Where a fit starts: every value of the shape parameters is tried, the colours of each solved for.

With the shape parameters held, a sum of lobes is linear in its colours or nearly so: a few Gauss-Newton steps on tiny
systems, one per channel, find the best colours inside their bounds (variable projection, Golub and Pereyra 1973). This
replaces a multi-start: the slope of a lobe is never far from one of the values that its declaration lists.
"""

from __future__ import annotations

import itertools
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from brdf.parameter import choices as choices_of
from brdf.parameter import parameters
from brdf.registry import name_of, split

from .loss import Samples, residual
from .unknowns import Unknown, Unknowns

# Samples that judge a start, Gauss-Newton steps for the colours, sweeps of coordinate descent in each.
_SAMPLES = 2048
_STEPS = 4
_SWEEPS = 30
# Up to this many combinations of shape parameters are enumerated.
_ENUMERATED_MAX = 20_000
# Most combinations of shape parameters that are tried; of more, a random choice.
_COMBINATIONS_MAX = 400
_SEED = 19730401


def candidates(unknowns: Unknowns) -> np.ndarray:
    """The solver's vectors whose shape parameters are scanned, with the colours at the middle of their bounds.

    **Returns:**

    Shape (candidates, k), at most 400. Of interchangeable lobes the first has the smallest slope.
    """
    shapes = [u for u in unknowns.free if u.parameter.kind == "scalar"]
    choices = [u.parameter.starts for u in shapes]
    total = math.prod(map(len, choices))
    if total <= _ENUMERATED_MAX:
        combinations = itertools.product(*choices)
    else:
        rng = np.random.default_rng(_SEED)
        combinations = (tuple(rng.choice(starts) for starts in choices) for _ in range(4 * _COMBINATIONS_MAX))
    groups = _interchangeable(unknowns, shapes)
    distinct = list(dict.fromkeys(_ordered(values, groups) for values in combinations))
    distinct = [values for values in distinct if values is not None]
    if len(distinct) > _COMBINATIONS_MAX:
        kept = np.random.default_rng(_SEED).choice(len(distinct), _COMBINATIONS_MAX, replace=False)
        distinct = [distinct[index] for index in np.sort(kept)]
    y = np.array([0.5 * (lo + hi) for lo, hi in zip(*unknowns.bounds(), strict=True)])
    rows = np.tile(y, (len(distinct), 1))
    for row, values in zip(rows, distinct, strict=True):
        for unknown, value in zip(shapes, values, strict=True):
            row[unknown.offset] = value * value if unknown.parameter.fit_square else value
    return rows


def _interchangeable(unknowns: Unknowns, shapes: list[Unknown]) -> list[list[int]]:
    """Places among `shapes` of the slopes of lobes whose exchange changes nothing: one model, equal in all but what
    is free."""
    groups: dict[object, list[int]] = {}
    for place, unknown in enumerate(shapes):
        if unknown.parameter.slope:
            model = split(unknowns.template)[unknown.lobe]
            free = {u.parameter.name for u in unknowns.free if u.lobe == unknown.lobe}
            held = {
                p.name: np.asarray(getattr(model, p.name)).tolist() for p in parameters(model) if p.name not in free
            }
            chosen = {c.name: getattr(model, c.name) for c in choices_of(model)}
            key = (name_of(model), unknown.parameter.name, sorted(free), sorted(held.items()), sorted(chosen.items()))
            groups.setdefault(repr(key), []).append(place)
    return list(groups.values())


def _ordered(values: tuple[float, ...], groups: list[list[int]]) -> tuple[float, ...] | None:
    """The combination with the slopes of each group in rising order; None if two of a group are equal."""
    result = list(values)
    for places in groups:
        slopes = sorted(values[place] for place in places)
        if len(set(slopes)) < len(slopes):
            return None
        for place, value in zip(places, slopes, strict=True):
            result[place] = value
    return tuple(result)


@eqx.filter_jit
def scan(
    unknowns: Unknowns,
    rows: Float[Array, "m k"],
    samples: Samples,
    lower: Float[Array, " k"],
    upper: Float[Array, " k"],
) -> tuple[Float[Array, "m k"], Float[Array, " m"]]:
    """Solves for the colours of every candidate on a few samples.

    **Returns:**

    - shape (m, k): the candidates with their colours.
    - shape (m,): their costs.
    """
    chunk = jax.tree.map(lambda array: array[0, ..., :_SAMPLES], samples)
    colours = [u for u in unknowns.free if u.parameter.kind == "color"]

    def improve(y: Float[Array, " k"]) -> tuple[Float[Array, " k"], Float[Array, ""]]:
        def distance(y: Float[Array, " k"]) -> Float[Array, "3 n"]:
            return residual(unknowns.model(y), chunk)

        if not colours:
            return y, 0.5 * jnp.sum(distance(y) ** 2)

        def step(_: Int[Array, ""], y: Float[Array, " k"]) -> Float[Array, " k"]:
            r, push = jax.linearize(distance, y)
            columns = jnp.stack([push(jnp.zeros_like(y).at[u.elements].set(1.0)) for u in colours])
            matrix = jnp.einsum("gcn,hcn->cgh", columns, columns)
            value = jnp.stack([y[u.elements] for u in colours], axis=1)
            right = jnp.einsum("cgh,ch->cg", matrix, value) - jnp.einsum("gcn,cn->cg", columns, r)
            low = jnp.stack([lower[u.elements] for u in colours], axis=1)
            high = jnp.stack([upper[u.elements] for u in colours], axis=1)
            value = jax.vmap(bounded_quadratic)(matrix, right, value, low, high)
            for place, unknown in enumerate(colours):
                y = y.at[unknown.elements].set(value[:, place])
            return y

        y = jax.lax.fori_loop(0, _STEPS, step, y)
        return y, 0.5 * jnp.sum(distance(y) ** 2)

    return jax.lax.map(improve, rows)


def bounded_quadratic(
    matrix: Float[Array, "g g"],
    right: Float[Array, " g"],
    x: Float[Array, " g"],
    lower: Float[Array, " g"],
    upper: Float[Array, " g"],
) -> Float[Array, " g"]:
    """Minimises `x^T A x / 2 - b^T x` inside bounds, by coordinate descent from `x`."""
    diagonal = jnp.maximum(jnp.diagonal(matrix), jnp.finfo(matrix.dtype).tiny)

    def sweep(_: Int[Array, ""], x: Float[Array, " g"]) -> Float[Array, " g"]:
        for index in range(x.size):
            slope = right[index] - matrix[index] @ x
            x = x.at[index].set(jnp.clip(x[index] + slope / diagonal[index], lower[index], upper[index]))
        return x

    return jax.lax.fori_loop(0, _SWEEPS, sweep, x)
