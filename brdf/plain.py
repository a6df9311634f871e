"""Lobes as plain numbers: what models declare and what a material gives, without the models' functions.

Most of what is done with a material, checking, packing, generating its shader, needs no more, and so no JAX.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .parameter import Choice, Parameter, choices, parameters
from .registry import MODELS, name_of, split

if TYPE_CHECKING:
    from .model import AbstractBRDF


@dataclasses.dataclass(frozen=True)
class Declaration:
    """What a model declares, in order.

    - `parameters`: all, whatever the choices.
    - `choices`: all.
    """

    parameters: tuple[Parameter, ...]
    choices: tuple[Choice, ...]


def declared(name: str) -> Declaration:
    """What a registered model declares; its file is imported for it, which loads JAX."""
    return Declaration(parameters(MODELS[name]), choices(MODELS[name]))


@dataclasses.dataclass(frozen=True, eq=False)
class PlainLobe:
    """One lobe of a material.

    - `model`: its registered name.
    - `declaration`: what that model declares.
    - `values`: of every parameter, shape () or (3,).
    - `options`: of every choice.
    """

    model: str
    declaration: Declaration
    values: Mapping[str, NDArray[np.generic]]
    options: Mapping[str, str]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those that the choices leave in use."""
        return tuple(one for one in self.declaration.parameters if one.is_live_under(self.options))

    @property
    def absent(self) -> tuple[str, ...]:
        """The weights in use that are exactly 0: what they scale is not even compiled."""
        return tuple(one.name for one in self.parameters if one.weight and not self.values[one.name].any())

    def build(self) -> AbstractBRDF:
        """The lobe as a model."""
        return MODELS[self.model](**self.values, **self.options)


def plain_lobes(model: AbstractBRDF) -> dict[str, PlainLobe]:
    """The named lobes of a model as plain numbers."""
    return {lobe: _plain(one) for lobe, one in split(model).items()}


def _plain(model: AbstractBRDF) -> PlainLobe:
    declaration = declared(name_of(model))
    values = {one.name: np.asarray(getattr(model, one.name)) for one in declaration.parameters}
    options = {one.name: str(getattr(model, one.name)) for one in declaration.choices}
    return PlainLobe(name_of(model), declaration, values, options)
