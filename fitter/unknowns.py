"""The unknowns of a fit: which parameters of a model are free, and how they stand in the solver's vector."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from brdf.errors import UserError
from brdf.material import check_choice, check_live, check_parameter
from brdf.model import AbstractBRDF, specialized
from brdf.parameter import Parameter, choices, is_absent, parameters
from brdf.registry import combine, nearest, split

_CHANNELS = ("r", "g", "b")
# A parameter that is fitted as its square stays above the root of this: at 0 the root has no derivative.
_SQUARE_MIN = 1e-10


@dataclasses.dataclass(frozen=True)
class Unknown:
    """A free parameter of one lobe and its place in the solver's vector.

    - `lobe`, `parameter`: whose it is; `label` is `"ggx.alpha"`.
    - `offset`: its first element in the vector; a colour has three.
    """

    lobe: str
    parameter: Parameter
    offset: int

    @property
    def label(self) -> str:
        return f"{self.lobe}.{self.parameter.name}"

    @property
    def elements(self) -> slice:
        return slice(self.offset, self.offset + self.parameter.size)

    @property
    def element_labels(self) -> tuple[str, ...]:
        if self.parameter.size == 1:
            return (self.label,)
        return tuple(f"{self.label}.{channel}" for channel in _CHANNELS)


class Unknowns(eqx.Module):
    """The free parameters of a model and the model that holds the fixed ones.

    - `template`: the model with the fixed parameters and choices in place, fixed weights of 0 marked as absent.
    - `free`: in the order of lobes and declaration.
    """

    template: AbstractBRDF
    free: tuple[Unknown, ...] = eqx.field(static=True)

    @property
    def size(self) -> int:
        """The length of the solver's vector."""
        return sum(unknown.parameter.size for unknown in self.free)

    @property
    def element_labels(self) -> tuple[str, ...]:
        return tuple(label for unknown in self.free for label in unknown.element_labels)

    @property
    def mixes_channels(self) -> bool:
        return any(lobe.mixes_channels for lobe in split(self.template).values())

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds of the solver's vector."""
        lower = [_inward(u.parameter, u.parameter.lower) for u in self.free for _ in range(u.parameter.size)]
        upper = [_inward(u.parameter, u.parameter.upper) for u in self.free for _ in range(u.parameter.size)]
        return np.array(lower, np.float64), np.array(upper, np.float64)

    def model(self, y: Float[Array, " k"]) -> AbstractBRDF:
        """The model whose free parameters have the values of the solver's vector; inverse of `vector`."""
        lobes = split(self.template)
        for unknown in self.free:
            value = y[unknown.elements] if unknown.parameter.size == 3 else y[unknown.offset]
            value = _outward(unknown.parameter, value)
            lobes[unknown.lobe] = dataclasses.replace(lobes[unknown.lobe], **{unknown.parameter.name: value})
        return combine(lobes)

    def settled(self, y: np.ndarray, at_bound: np.ndarray) -> AbstractBRDF:
        """The model of a solution, in NumPy arrays, with the elements at a bound put on the declared bound exactly."""
        lobes = split(self.template)
        for u in self.free:
            value = np.sqrt(y[u.elements]) if u.parameter.fit_square else y[u.elements]
            low, high = u.parameter.lower, u.parameter.upper
            value = np.where(at_bound[u.elements], np.where(value - low < high - value, low, high), value)
            value = np.clip(value, low, high)
            value = value if u.parameter.size == 3 else value[0]
            lobes[u.lobe] = dataclasses.replace(lobes[u.lobe], **{u.parameter.name: value})
        for name, lobe in lobes.items():
            zeros = {p.name: 0.0 for p in parameters(lobe) if is_absent(getattr(lobe, p.name))}
            lobes[name] = dataclasses.replace(lobe, **zeros)
        return combine(lobes)

    def scale(self, y: np.ndarray) -> np.ndarray:
        """The derivative of the parameters by the solver's vector, for standard errors by the delta method."""
        parts = [
            0.5 / np.sqrt(y[u.elements]) if u.parameter.fit_square else np.ones(u.parameter.size) for u in self.free
        ]
        return np.concatenate(parts) if parts else np.zeros(0)


def _inward(parameter: Parameter, value: Any) -> np.ndarray:
    value = np.asarray(value, np.float64)
    return np.asarray(np.maximum(value * value, _SQUARE_MIN)) if parameter.fit_square else value


def _outward(parameter: Parameter, value: Any) -> Any:
    return jnp.sqrt(value) if parameter.fit_square else value


def choose(model: AbstractBRDF, fixed: Mapping[str, Any]) -> Unknowns:
    """The unknowns of a model after the user's `fixed` parameters and choices are set.

    **Arguments:**

    - `model`: any model; its own values stand where nothing else is said.
    - `fixed`: `{"alpha": 0.2, "lambert.albedo": [0.5, 0.5, 0.5], "masking": "smith"}`; a lobe's name is needed only
      where several lobes have the parameter.

    Raises `UserError` for an unknown or ambiguous name and for a value out of bounds.
    """
    lobes = split(model)
    held: set[tuple[str, str]] = set()
    named = [(*_find(lobes, key), value) for key, value in fixed.items()]
    # Choices first: they decide which parameters there are.
    for lobe, name, value in named:
        chosen = next((c for c in choices(lobes[lobe]) if c.name == name), None)
        if chosen is not None:
            lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: check_choice(value, chosen, lobe)})
    for lobe, name, value in named:
        declared = next((p for p in parameters(type(lobes[lobe])) if p.name == name), None)
        if declared is not None:
            check_live(declared, lobes[lobe], lobe)
            lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: check_parameter(value, declared, lobe)})
            held.add((lobe, name))
    free, offset = [], 0
    for lobe, part in lobes.items():
        for parameter in parameters(part):
            if (lobe, parameter.name) not in held:
                free.append(Unknown(lobe, parameter, offset))
                offset += parameter.size
    return Unknowns(specialized(combine(lobes)), tuple(free))


def _find(lobes: Mapping[str, AbstractBRDF], key: str) -> tuple[str, str]:
    known = [(lobe, field.name) for lobe, part in lobes.items() for field in (*parameters(type(part)), *choices(part))]
    found = [(lobe, name) for lobe, name in known if key in (name, f"{lobe}.{name}")]
    if len(found) == 1:
        return found[0]
    if found:
        options = " or ".join(f"`{lobe}.{name}`" for lobe, name in found)
        raise UserError(f"`{key}` is a parameter of several lobes. Write {options}.")
    raise UserError(f"`{key}` is not a parameter here. {nearest(key, [f'{lobe}.{name}' for lobe, name in known])}")
