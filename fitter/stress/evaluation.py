"""One compiled program per structure of a model and precision: values, gradients and what is wrong with them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from brdf.frame import above_horizon
from brdf.model import AbstractBRDF

# The gradient is of this sum of the channels: unequal, so that no two channels can cancel.
CHANNEL_WEIGHTS = (0.5, 1.0, 1.75)
FAULTS = ("value NaN", "value Inf", "value negative", "value below the horizon", "gradient NaN", "gradient Inf")

Array = NDArray[Any]
# Points per call: large enough that calling costs nothing, small enough to stay in the cache.
_CHUNK = 1 << 14
# For XLA; none, so that what is tested is what users run.
_COMPILER_OPTIONS: dict[str, str] = {}
# How a caller that may use OpenGL hands its GLSL evaluation in: model, wi and wo (n, 3) -> values (n, 3).
Evaluate = Callable[[AbstractBRDF, Array, Array], Array]


def with_leaves(model: AbstractBRDF, leaves: list[Any]) -> AbstractBRDF:
    """The model with other parameter values, whatever their type and batch shape."""
    return jax.tree.unflatten(jax.tree.structure(model), leaves)


def values_and_gradients(
    model: AbstractBRDF, leaves: list[Array], wi: Array, wo: Array, weights: tuple[float, ...] = CHANNEL_WEIGHTS
) -> tuple[Array, Array, Array]:
    """Evaluates one structure of a model at n points, in the precision of `wi`.

    **Arguments:**

    - `model`: gives the structure: which lobes and choices. A new one compiles, and so does another precision.
    - `leaves`: the parameters' values, n of each, in the order of the model's leaves.
    - `wi`, `wo`: (n, 3).
    - `weights`: the gradient is of the sum of the channels with these weights.

    **Returns:** values (n, 3); gradients (n, parameters + 6), by every leaf, `wi` and `wo`; and n integers in which bit
    k stands for the fault k of `FAULTS`.
    """
    found = []
    with jax.enable_x64(wi.dtype == np.float64):
        program = _program(jax.tree.structure(model))
        for start in range(0, len(wi), _CHUNK):
            part = [_filled(array[start : start + _CHUNK]) for array in (*leaves, wi, wo)]
            found.append([np.asarray(x) for x in program(part[:-2], part[-2], part[-1], np.asarray(weights, wi.dtype))])
    value, gradient, faults = (np.concatenate(parts)[: len(wi)] for parts in zip(*found, strict=True))
    return value, gradient, faults


def _filled(array: Array) -> Array:
    """An array of `_CHUNK` rows: a program is compiled for one number of points."""
    return array if len(array) == _CHUNK else np.resize(array, (_CHUNK, *array.shape[1:]))


@functools.lru_cache(maxsize=4)
def _program(structure: Any) -> Callable[..., Any]:
    def one(leaves: list[Any], wi: Any, wo: Any, weights: Any) -> Any:
        value, pull = jax.vjp(lambda leaves, wi, wo: jax.tree.unflatten(structure, leaves)(wi, wo), leaves, wi, wo)
        gradient = jnp.concatenate([g.reshape(-1) for g in jax.tree.leaves(pull(weights))])
        faults = [
            jnp.isnan(value).any(),
            jnp.isinf(value).any(),
            (value < 0).any(),
            (value != 0).any() & ~above_horizon(wi, wo),
            jnp.isnan(gradient).any(),
            jnp.isinf(gradient).any(),
        ]
        return value, gradient, sum(fault.astype(jnp.int32) << bit for bit, fault in enumerate(faults))

    return jax.jit(jax.vmap(one, (0, 0, 0, None)), compiler_options=_COMPILER_OPTIONS)
