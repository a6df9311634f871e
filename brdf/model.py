"""What a reflectance model is, and the sum of several."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Mapping
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .chebyshev import Chebyshev
from .frame import Color, Direction, Geometry, Scalar, above_horizon, geometry
from .parameter import ABSENT, parameters
from .sampling import Proposals, density, draw

Batch = Float[Array | np.ndarray, "n 3"]


@dataclasses.dataclass(frozen=True)
class Claims:
    """What a model claims, to which the tests of the laws hold it.

    - `reciprocal`: the value is the same when `wi` and `wo` are exchanged.
    - `albedo_max`: the largest share of the light from one direction that it reflects, whatever its parameters;
      infinite where the published model promises nothing.
    """

    reciprocal: bool = True
    albedo_max: float = 1.0


class AbstractBRDF(eqx.Module):
    """A reflectance model with its parameters: a pytree that JAX differentiates, maps and compiles.

    A model is final: it declares its fields (see `brdf.parameter`), `reflect` and `proposals`, and `claims` if it keeps
    less than the laws. Everything else finds it through the registry.
    """

    # Whether a channel of the value depends on another channel of a colour (as Disney's tint does). A fit of a model
    # that does not mix them needs one derivative per colour instead of three.
    mixes_channels: ClassVar[bool] = False

    @abc.abstractmethod
    def reflect(self, g: Geometry) -> Color:
        """The value of the BRDF in 1/sr, without the cosine, for directions above the horizon."""

    @abc.abstractmethod
    def proposals(self, cos_o: Scalar) -> Proposals:
        """The densities that imitate the model for a viewer at this cosine, weighted by the light that each stands for.

        A weight needs no normalisation and decides only the noise; together the densities cover every direction that
        the model reflects to.
        """

    def claims(self) -> Claims:
        """What the model claims under its static choices."""
        return Claims()

    def tables(self) -> Mapping[str, Chebyshev | None]:
        """The tables that its GLSL twin calls as functions, by name; None for one that the choices leave unused."""
        return {}

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

    def sample(self, wo: Direction, u: Float[Array | np.ndarray, "3"]) -> Direction:
        """A direction to the light with the density `pdf`; it may end below the horizon, where the value is zero.

        **Arguments:**

        - `wo`: shape (3,), unit, to the viewer, above the horizon.
        - `u`: shape (3,), uniform in [0, 1): the first chooses the density, the others the direction.

        **Returns:** shape (3,), unit.
        """
        return draw(self.proposals(wo[2]), wo, u)

    def pdf(self, wi: Direction, wo: Direction) -> Scalar:
        """The density of `sample` in 1/sr, zero where either direction is below the horizon.

        **Arguments:** `wi`, `wo`: shape (3,), unit, to the light and to the viewer.
        """
        above = above_horizon(wi, wo)
        normal = jnp.array([0, 0, 1], wi.dtype)
        g = geometry(jnp.where(above, wi, normal), jnp.where(above, wo, normal))
        value = density(self.proposals(g.cos_o), g)
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

    def proposals(self, cos_o: Scalar) -> Proposals:
        parts = [lobe.proposals(cos_o) for lobe in self.lobes]
        diffuse = parts[0].diffuse
        for part in parts[1:]:
            diffuse = diffuse + part.diffuse
        return Proposals(diffuse, tuple(lobe for part in parts for lobe in part.specular))

    def claims(self) -> Claims:
        """Lobes that each keep the energy may together reflect more than all light: a sum claims nothing there."""
        reciprocal = all(lobe.claims().reciprocal for lobe in self.lobes)
        return Claims(reciprocal, sum(lobe.claims().albedo_max for lobe in self.lobes))


def specialized(model: AbstractBRDF) -> AbstractBRDF:
    """The model with every weight that is exactly 0 marked as absent, so that what it scales is not even compiled.

    Only plain numbers are looked at: a weight that JAX is tracing stays as it is.
    """
    if isinstance(model, Sum):
        return Sum(tuple(specialized(lobe) for lobe in model.lobes), model.names)
    absent = {
        parameter.name: ABSENT
        for parameter in parameters(model)
        if parameter.weight and _is_zero(getattr(model, parameter.name))
    }
    return dataclasses.replace(model, **absent) if absent else model


def _is_zero(value: object) -> bool:
    return isinstance(value, np.ndarray) and not value.any()


def evaluate(model: AbstractBRDF, wi: Batch, wo: Batch) -> Batch:
    """The values of a model in 1/sr, without the cosine, for n pairs of directions; see `AbstractBRDF.__call__`."""
    return _evaluate(specialized(model), wi, wo)


@eqx.filter_jit
def _evaluate(model: AbstractBRDF, wi: Batch, wo: Batch) -> Batch:
    return jax.vmap(model)(wi, wo)
