"""The unknowns of a fit: which parameters of a model are free, and how they stand in the solver's vector."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from brdf.model import AbstractBRDF
from brdf.parameter import Parameter, choices, is_absent, parameters
from brdf.registry import combine, split

_CHANNELS = ("r", "g", "b")
# A parameter that is fitted as its square stays above the root of this: at 0 the root has no derivative.
_SQUARE_MIN = 1e-10

# A lobe's name and a field of it.
Place = tuple[str, str]


@dataclasses.dataclass(frozen=True)
class Unknown:
    """A free parameter, or several that are tied to be equal, and its place in the solver's vector.

    - `parameter`: its declaration, with the bounds and starts of this fit.
    - `offset`: its first element in the vector; a colour has three.
    - `places`: the fields that have its value; the first one names it, as in `"ggx.alpha"`.
    """

    parameter: Parameter
    offset: int
    places: tuple[Place, ...]

    @property
    def lobe(self) -> str:
        return self.places[0][0]

    @property
    def label(self) -> str:
        return ".".join(self.places[0])

    @property
    def elements(self) -> slice:
        return slice(self.offset, self.offset + self.parameter.size)

    @property
    def element_labels(self) -> tuple[str, ...]:
        if self.parameter.size == 1:
            return (self.label,)
        return tuple(f"{self.label}.{channel}" for channel in _CHANNELS)

    def inward(self, value: Any) -> np.ndarray:
        """The solver's elements of a value of the parameter."""
        value = np.asarray(value, np.float64)
        return np.asarray(np.maximum(value * value, _SQUARE_MIN)) if self.parameter.fit_square else value

    def outward(self, elements: Any) -> Any:
        """The parameter's value of the solver's elements, inside JAX."""
        return jnp.sqrt(elements) if self.parameter.fit_square else elements


class Unknowns(eqx.Module):
    """The free parameters of a model and the model that holds the fixed ones.

    - `template`: the model with the fixed parameters and choices in place, fixed weights of 0 marked as absent.
    - `free`: in the order of lobes and declaration.
    - `held`: the fields that the fit holds of its own accord (see `Parameter.held`), and their values.
    """

    template: AbstractBRDF
    free: tuple[Unknown, ...] = eqx.field(static=True)
    held: tuple[tuple[Place, tuple[float, ...]], ...] = eqx.field(static=True, default=())

    @property
    def size(self) -> int:
        """The length of the solver's vector."""
        return sum(unknown.parameter.size for unknown in self.free)

    @property
    def element_labels(self) -> tuple[str, ...]:
        return tuple(label for unknown in self.free for label in unknown.element_labels)

    def declaration(self, place: Place) -> Parameter:
        """The declaration of a parameter, free or not."""
        lobe, name = place
        return next(p for p in parameters(type(split(self.template)[lobe])) if p.name == name)

    @property
    def structure(self) -> str:
        """All that decides about a program that is compiled for these unknowns, besides our source."""
        lobes = [
            (
                name,
                type(lobe).__qualname__,
                [getattr(lobe, choice.name) for choice in choices(lobe)],
                [p.name for p in parameters(lobe) if is_absent(getattr(lobe, p.name))],
            )
            for name, lobe in split(self.template).items()
        ]
        return repr((lobes, [(u.places, u.parameter.size, u.parameter.fit_square) for u in self.free]))

    def mixes_channels(self, unknown: Unknown) -> bool:
        """Whether a channel of the value depends on another channel of this unknown."""
        lobes = split(self.template)
        return any(lobes[lobe].mixes_channels for lobe, _ in unknown.places)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds of the solver's vector."""
        lower = [u.inward(u.parameter.lower) for u in self.free for _ in range(u.parameter.size)]
        upper = [u.inward(u.parameter.upper) for u in self.free for _ in range(u.parameter.size)]
        return np.array(lower, np.float64), np.array(upper, np.float64)

    def model(self, y: Float[Array | np.ndarray, " k"]) -> AbstractBRDF:
        """The model whose free parameters have the values of the solver's vector; inverse of `vector`."""
        lobes = split(self.template)
        for unknown in self.free:
            at = y[unknown.elements] if unknown.parameter.size == 3 else y[unknown.offset]
            for lobe, name in unknown.places:
                lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: unknown.outward(at)})
        return combine(lobes)

    def vector(self, model: AbstractBRDF) -> np.ndarray:
        """The solver's vector of a model of the same lobes, put inside the bounds."""
        lobes = split(model)
        lower, upper = self.bounds()
        y = np.zeros(self.size)
        for unknown in self.free:
            lobe, name = unknown.places[0]
            y[unknown.elements] = unknown.inward(getattr(lobes[lobe], name))
        return np.clip(y, lower, upper)

    def depending(self, model: AbstractBRDF, unknown: Unknown, at: Array) -> list[AbstractBRDF]:
        """The lobes of a model that depend on an unknown, with the solver's elements `at` of it in place."""
        lobes = split(model)
        changed: dict[str, AbstractBRDF] = {}
        for lobe, name in unknown.places:
            changed[lobe] = dataclasses.replace(changed.get(lobe, lobes[lobe]), **{name: unknown.outward(at)})
        return list(changed.values())

    def variants(self) -> list[Unknowns]:
        """The same unknowns with every combination of the values at which the fit may hold parameters."""
        found = []
        for values in itertools.product(*(options for _, options in self.held)):
            lobes = split(self.template)
            for ((lobe, name), options), value in zip(self.held, values, strict=True):
                if len(options) > 1:
                    # A JAX array: no value of it is known beforehand, so that all variants share their program.
                    lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: jnp.asarray(value)})
            found.append(Unknowns(combine(lobes), self.free, self.held))
        return found

    def settled(self, y: np.ndarray, at_bound: np.ndarray) -> AbstractBRDF:
        """The model of a solution, in NumPy arrays, with the elements at a bound put on the declared bound exactly."""
        lobes = split(self.template)
        for u in self.free:
            value = np.sqrt(y[u.elements]) if u.parameter.fit_square else y[u.elements]
            low, high = u.parameter.lower, u.parameter.upper
            value = np.where(at_bound[u.elements], np.where(value - low < high - value, low, high), value)
            value = np.clip(value, low, high)
            value = value if u.parameter.size == 3 else value[0]
            for lobe, name in u.places:
                lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: value})
        for name, lobe in lobes.items():
            plain = {p.name: np.asarray(getattr(lobe, p.name)) for p in parameters(lobe)}
            plain |= {p.name: 0.0 for p in parameters(lobe) if is_absent(getattr(lobe, p.name))}
            lobes[name] = dataclasses.replace(lobe, **plain)
        return combine(lobes)

    def values(self, y: Float[np.ndarray, "*points k"]) -> Float[np.ndarray, "*points k"]:
        """The parameters' own numbers of one or many of the solver's vectors."""
        values = np.array(y, np.float64)
        for u in self.free:
            if u.parameter.fit_square:
                square = values[..., u.elements]
                values[..., u.elements] = np.where(square > _SQUARE_MIN, np.sqrt(np.maximum(square, 0.0)), 0.0)
        return values

    def scale(self, y: np.ndarray) -> np.ndarray:
        """The derivative of the parameters by the solver's vector, for standard errors by the delta method."""
        parts = [
            0.5 / np.sqrt(y[u.elements]) if u.parameter.fit_square else np.ones(u.parameter.size) for u in self.free
        ]
        return np.concatenate(parts) if parts else np.zeros(0)
