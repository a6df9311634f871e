"""The samples of a measurement in the layout in which a fit reads them.

Channels stand before samples, so that arithmetic runs along memory, in chunks that stay in a core's cache, in slabs of
a fixed number of chunks: a compiled program serves measurements of every size. A large measurement is fitted to a
random slab first, and only its last steps see all samples.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from .loss import Loss
from .reflectance import Reflectance

CHUNK = 1024
CHUNKS = 64
SLAB = CHUNK * CHUNKS
_SEED = 20120101


class Samples(eqx.Module):
    """One slab. Empty places have weight zero.

    - `wi`, `wo`, `value`: shape (chunks, 3, CHUNK).
    - `weight`: shape (chunks, 1 or 3, CHUNK), over their mean.
    - `scale`: the compressed value that Huber's threshold is a share of.
    """

    wi: Float[Array | np.ndarray, "*chunks 3 size"]
    wo: Float[Array | np.ndarray, "*chunks 3 size"]
    value: Float[Array | np.ndarray, "*chunks 3 size"]
    weight: Float[Array | np.ndarray, "*chunks _ size"]
    scale: Float[Array | np.ndarray, ""]

    def chunk(self, index: int | Int[Array, ""]) -> Samples:
        """One chunk, without its first axis."""
        arrays = (self.wi, self.wo, self.value, self.weight)
        wi, wo, value, weight = (jax.lax.dynamic_index_in_dim(array, index, keepdims=False) for array in arrays)
        return Samples(wi, wo, value, weight, self.scale)


@dataclasses.dataclass(frozen=True)
class Slab:
    """A slab on the device and how many of its chunks hold samples."""

    samples: Samples
    count: int


@dataclasses.dataclass(frozen=True)
class Arranged:
    """A measurement as a fit reads it.

    - `subset`: all samples in random order, or of a large measurement a random part of them; its first chunks are a
      random part again. `rows` says which samples, in order.
    - `slabs`: all samples.
    - `share`: the part of the total weight that is in `subset`.
    """

    subset: Slab
    rows: Int[np.ndarray, " m"]
    slabs: tuple[Slab, ...]
    share: float


def arrange(data: Reflectance, loss: Loss, weight: Float[np.ndarray, "n _"]) -> Arranged:
    """Lays a measurement out for a fit.

    **Arguments:**

    - `data`: n samples.
    - `loss`: for the scale of its compression.
    - `weight`: shape (n, 1) or (n, 3), not negative, not all zero; only their ratios matter.
    """
    count = len(data)
    weight = weight / weight.mean()
    rng = np.random.default_rng(_SEED)
    if count <= SLAB:
        rows = rng.permutation(count)
    else:
        # One sample at random from each of as many equal parts of the file: no part of the angles is missed.
        edges = np.linspace(0, count, SLAB + 1).astype(int)
        rows = rng.permutation(edges[:-1] + (rng.random(SLAB) * np.diff(edges)).astype(int))
    scale = _scale(data, loss, rows[: 8 * CHUNK])
    subset = _slab(data, weight, rows, scale)
    if count <= SLAB:
        return Arranged(subset, rows, (subset,), 1.0)
    slabs = tuple(_slab(data, weight, slice(start, start + SLAB), scale) for start in range(0, count, SLAB))
    return Arranged(subset, rows, slabs, float(weight[rows].sum() / weight.sum()))


def arrange_blocks(
    data: Reflectance,
    weight: Float[np.ndarray, "n _"],
    blocks: Sequence[Int[np.ndarray, " _"]],
    chunks: int,
    scale: Float[Array | np.ndarray, ""],
) -> Samples:
    """A slab in which each block of rows fills its own `chunks` chunks."""
    size = chunks * CHUNK
    rows = np.full((CHUNKS // chunks, size), -1)
    for row, block in zip(rows, blocks, strict=False):
        row[: len(block)] = block
    empty = rows.ravel() < 0
    rows = np.where(empty, 0, rows.ravel())
    weight = np.where(empty[:, None], 0.0, (weight / weight.mean())[rows])
    return _layout(data.wi[rows], data.wo[rows], data.value[rows], weight, scale)


def arrange_directions(wi: np.ndarray, wo: np.ndarray, value: np.ndarray) -> Samples:
    """A slab whose chunks hold the given directions and values, of weight 1: each (chunks, n, 3), n at most CHUNK."""
    full = np.zeros((CHUNKS, CHUNK, 10))
    full[..., :6] = 3**-0.5
    given = np.concatenate([wi, wo, value, np.ones_like(wi[..., :1])], axis=-1)
    full[: wi.shape[0], : wi.shape[1]] = given
    flat = full.reshape(-1, 10)
    return _layout(flat[:, :3], flat[:, 3:6], flat[:, 6:9], flat[:, 9:], np.asarray(1.0))


def _scale(data: Reflectance, loss: Loss, rows: np.ndarray) -> np.ndarray:
    """The median of the compressed values of some samples, where it is needed."""
    if not loss.needs_scale:
        return np.asarray(1.0)
    value, cos_i = data.value[rows].T, data.wi[rows, 2][None]
    median = np.median(np.asarray(loss.compress(value, cos_i)))
    return np.asarray(np.maximum(median, np.finfo(float).tiny))


def _slab(data: Reflectance, weight: np.ndarray, rows: np.ndarray | slice, scale: np.ndarray) -> Slab:
    parts = data.wi[rows], data.wo[rows], data.value[rows], weight[rows]
    return Slab(_layout(*parts, scale), -(-len(parts[0]) // CHUNK))


def _layout(
    wi: np.ndarray, wo: np.ndarray, value: np.ndarray, weight: np.ndarray, scale: Array | np.ndarray
) -> Samples:
    def layout(array: np.ndarray, empty: float) -> Array:
        if len(array) < SLAB:
            array = np.concatenate([array, np.full((SLAB - len(array), array.shape[1]), empty)])
        return jax.device_put(np.ascontiguousarray(array.reshape(CHUNKS, CHUNK, -1).transpose(0, 2, 1)))

    # Directions of empty places only have to be unit and above the horizon: (1, 1, 1) / sqrt(3).
    diagonal = 3**-0.5
    return Samples(layout(wi, diagonal), layout(wo, diagonal), layout(value, 0.0), layout(weight, 0.0), scale)
