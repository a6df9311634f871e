"""What the GLSL of a lobe needs of its model's functions, beyond what the model declares: only here JAX is loaded."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF


@dataclasses.dataclass(frozen=True, eq=False)
class Traced:
    """It depends on a lobe's choices and on which weights are 0, not on other values.

    - `tables`: coefficients of the functions that its text calls, by name, see `brdf.chebyshev`; None for one that the
      choices leave unused.
    - `proposals`: the number of specular lobes that it proposes to sample.
    """

    tables: Mapping[str, NDArray[np.float64] | None]
    proposals: int


def trace(lobe: AbstractBRDF) -> Traced:
    """What a model that is not a sum says of itself."""
    tables = {name: None if table is None else table.coefficients for name, table in lobe.tables().items()}
    return Traced(tables, _proposal_count(lobe))


def _proposal_count(lobe: AbstractBRDF) -> int:
    import equinox as eqx
    import jax
    import jax.numpy as jnp

    from brdf.model import specialized

    lobe = specialized(lobe)
    # Its value does not matter, nothing is computed; its precision is that of the material's own numbers.
    numbers = (leaf for leaf in jax.tree.leaves(lobe) if eqx.is_inexact_array(leaf))
    cos_o = jax.ShapeDtypeStruct((), jnp.result_type(*numbers))
    return len(eqx.filter_eval_shape(lobe.proposals, cos_o).specular)
