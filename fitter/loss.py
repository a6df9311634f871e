"""How a fit compares a model with a measurement, and the samples in the layout in which it does so.

A fit minimises the sum of squares of `residual`: the difference of log-compressed values (Low 2012), which follows the
eye's sense of brightness and keeps a highlight from drowning the rest. The default loss, `log`, softens it beyond one
e-fold, where it grows like a root, so that its square grows linearly: a saturated or shifted highlight that no model
can follow then pulls less at everything else. Below that it is the plain difference to second order. `log_squares` is
the plain one.

- Low, Kronander, Ynnerman, Unger 2012, "BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces".
- Charbonnier, Blanc-Feraud, Aubert, Barlaud 1997, "Deterministic edge-preserving regularization in computed imaging"
  (the softened square).
"""

from __future__ import annotations

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from brdf.model import AbstractBRDF

from .reflectance import Reflectance

# Samples per chunk: one chunk's values and derivatives stay in a core's second-level cache.
CHUNK = 4096
_SEED = 20120101


class Samples(eqx.Module):
    """The samples of a fit in shuffled chunks, channels before samples, so that arithmetic runs along memory.

    The first chunk is a random subset of all samples, on which a fit can start. Empty places have weight zero.

    - `wi`, `wo`: shape (chunks, 3, CHUNK).
    - `target`: shape (chunks, 3, CHUNK), the compressed measurement (see `compress`).
    - `root_weight`: shape (chunks, 1, CHUNK), the square root of each sample's weight over their mean.
    - `loss`: a key of `LOSSES`.
    """

    wi: Float[Array | np.ndarray, "chunks 3 size"]
    wo: Float[Array | np.ndarray, "chunks 3 size"]
    target: Float[Array | np.ndarray, "chunks 3 size"]
    root_weight: Float[Array | np.ndarray, "chunks 1 size"]
    loss: str = eqx.field(static=True)

    def chunk(self, index: int | Array) -> Samples:
        """One chunk, without its first axis."""
        return jax.tree.map(lambda array: jax.lax.dynamic_index_in_dim(array, index, keepdims=False), self)


def _soften(x: Float[Array, "3 n"]) -> Float[Array, "3 n"]:
    """The number whose square is `2 (sqrt(1 + x^2) - 1)` (Charbonnier 1997), with the sign of x."""
    return x * jnp.sqrt(2 / (1 + jnp.sqrt(1 + x * x)))


LOSSES: dict[str, Callable[[Array], Array]] = {"log": _soften, "log_squares": lambda x: x}


def compress(value: Float[Array | np.ndarray, "3 n"], cos_i: Float[Array | np.ndarray, "1 n"]) -> Float[Array, "3 n"]:
    """The log compression `log(1 + f cos_i)` of Low 2012 in which a fit measures its distance."""
    return jnp.log1p(value * cos_i)


def arrange(data: Reflectance, loss: str) -> Samples:
    """The samples of a measurement as a fit wants them.

    The number of chunks is rounded up to 1, 2, 3, 4, 6, 8, 12, 16, ..., so that measurements of similar size share
    their compiled programs.
    """
    count = len(data.value)
    needed = -(-count // CHUNK)
    power = 1 << (needed - 1).bit_length()
    chunks = power * 3 // 4 if needed <= power * 3 // 4 else power
    order = np.random.default_rng(_SEED).permutation(count)
    padded = np.full(chunks * CHUNK, -1)
    padded[:count] = order

    def layout(array: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(array[padded].reshape(chunks, CHUNK, 3).transpose(0, 2, 1))

    # Only the ratios of weights matter.
    weight = np.sqrt(data.weight / data.weight.mean())[padded]
    weight[count:] = 0
    target = np.log1p(data.value * data.wi[:, 2:3])
    return Samples(layout(data.wi), layout(data.wo), layout(target), weight.reshape(chunks, 1, CHUNK), loss)


def difference(model: AbstractBRDF, chunk: Samples) -> Float[Array, "3 n"]:
    """The compressed model minus the compressed measurement on one chunk, unweighted."""
    value = jax.vmap(model, in_axes=-1, out_axes=-1)(chunk.wi, chunk.wo)
    return compress(value, chunk.wi[2:3]) - chunk.target


def residual(model: AbstractBRDF, chunk: Samples) -> Float[Array, "3 n"]:
    """What a fit minimises the squares of, on one chunk."""
    return LOSSES[chunk.loss](difference(model, chunk)) * chunk.root_weight
