"""What a reflectance model is, and the sum of several."""

from __future__ import annotations

import abc
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .frame import Direction, Geometry, above_horizon, geometry

Color = Float[Array | np.ndarray, "3"]
Batch = Float[Array | np.ndarray, "n 3"]


class AbstractBRDF(eqx.Module):
    """A reflectance model with its parameters: a pytree that JAX differentiates, maps and compiles.

    A model is final: it declares its fields (see `brdf.parameter`) and `reflect`. Everything else finds it through the
    registry.
    """

    # Whether a channel of the value depends on another channel of a colour (as Disney's tint does). A fit of a model
    # that does not mix them needs one derivative per colour instead of three.
    mixes_channels: ClassVar[bool] = False
    # What the model claims, and the tests of its laws hold it to: the same value when `wi` and `wo` are exchanged, and
    # the largest share of the light from one direction that it reflects.
    is_reciprocal: ClassVar[bool] = True
    albedo_max: ClassVar[float] = 1.0

    @abc.abstractmethod
    def reflect(self, g: Geometry) -> Color:
        """The value of the BRDF in 1/sr, without the cosine, for directions above the horizon."""

    def __call__(self, wi: Direction, wo: Direction) -> Color:
        """The value of the BRDF in 1/sr, without the cosine, for one pair of directions.

        **Arguments:**

        - `wi`, `wo`: shape (3,), unit, to the light and to the viewer, in the local frame with normal +z.

        **Returns:**

        Shape (3,), linear Rec. 709; zero where either direction is below the horizon.
        """
        wi, wo = jnp.asarray(wi), jnp.asarray(wo)
        above = above_horizon(wi, wo)
        normal = jnp.array([0, 0, 1], wi.dtype)
        value = self.reflect(geometry(jnp.where(above, wi, normal), jnp.where(above, wo, normal)))
        return jnp.where(above, value, jnp.zeros_like(value))


class Sum(AbstractBRDF):
    """The sum of several models, such as a diffuse base under specular lobes.

    **Arguments:**

    - `lobes`: the summands, in order.
    - `names`: one per lobe: the model's name, and from its second use on with a number, as in `ggx`, `ggx_2`.
    """

    lobes: tuple[AbstractBRDF, ...]
    names: tuple[str, ...] = eqx.field(static=True)

    def reflect(self, g: Geometry) -> Color:
        total = self.lobes[0].reflect(g)
        for lobe in self.lobes[1:]:
            total = total + lobe.reflect(g)
        return total


@eqx.filter_jit
def evaluate(model: AbstractBRDF, wi: Batch, wo: Batch) -> Batch:
    """The values of a model in 1/sr, without the cosine, for n pairs of directions; see `AbstractBRDF.__call__`."""
    return jax.vmap(model)(wi, wo)
