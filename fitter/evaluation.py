"""The values of a model by a program that is kept on disk: a new process need not trace it."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Float

from brdf.integrate import evaluate_in_chunks
from brdf.model import AbstractBRDF, specialized

from .program import kept
from .unknowns import Unknowns

Batch = Float[np.ndarray, "n 3"]


def values(model: AbstractBRDF, wi: Batch, wo: Batch) -> Batch:
    """The values of a model in 1/sr, without the cosine, at any number of pairs of directions, in float64."""
    return evaluate_in_chunks(model, wi, wo, _evaluate)


def _evaluate(model: AbstractBRDF, wi: Batch, wo: Batch) -> jax.Array:
    model = specialized(model)
    leaves, static = eqx.partition(model, eqx.is_array)
    arrays, tree = jax.tree.flatten(leaves)

    def run(*arguments):
        model = eqx.combine(jax.tree.unflatten(tree, arguments[:-2]), static)
        return (jax.vmap(model)(*arguments[-2:]),)

    arguments = [*arrays, wi, wo]
    return kept(f"evaluate {Unknowns(model, ()).structure}", run, arguments)(*arguments)[0]
