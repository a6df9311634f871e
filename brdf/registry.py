"""Finds the models: the file `brdf/models/NAME.py` holds exactly one, and `"lambert+ggx"` is the sum of two.

Names need no more than a look into the folder; JAX is loaded with the first model.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import pathlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from .errors import UserError, nearest

if TYPE_CHECKING:
    from .model import AbstractBRDF

_LOBES_MAX = 6
_FOLDER = pathlib.Path(__file__).parent / "models"


class _Models(Mapping[str, type[Any]]):
    """Model name -> class; a model's file is imported when it is first asked for."""

    @functools.cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(sorted(file.stem for file in _FOLDER.glob("[!_]*.py")))

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> type[Any]:
        if name not in self._names:
            raise KeyError(name)
        from .model import AbstractBRDF

        module = importlib.import_module(f".models.{name}", __package__)
        found = [
            value
            for _, value in inspect.getmembers(module, inspect.isclass)
            if issubclass(value, AbstractBRDF) and value.__module__ == module.__name__
        ]
        if len(found) != 1:
            raise ImportError(f"brdf/models/{name}.py holds {len(found)} models; it must hold exactly one.")
        return found[0]


MODELS = _Models()


def lobe_models(expression: str) -> dict[str, str]:
    """Lobe name -> model name of an expression such as `"lambert+ggx+ggx"`, whose lobes are lambert, ggx, ggx_2.

    Raises `UserError` for an unknown model, naming the nearest one.
    """
    lobes: dict[str, str] = {}
    counts: dict[str, int] = {}
    names = [part.strip() for part in expression.split("+")]
    if len(names) > _LOBES_MAX:
        raise UserError(
            f"`{expression}` has {len(names)} lobes. At most {_LOBES_MAX} can be told apart in a measurement."
        )
    for name in names:
        if name not in MODELS:
            raise UserError(f"`{name}` in `{expression}` is not a model. {nearest(name, MODELS)}")
        counts[name] = counts.get(name, 0) + 1
        lobes[name if counts[name] == 1 else f"{name}_{counts[name]}"] = name
    return lobes


def combine(lobes: Mapping[str, AbstractBRDF]) -> AbstractBRDF:
    """One model from named lobes: the lobe itself if it is alone, their `Sum` otherwise."""
    if len(lobes) == 1:
        return next(iter(lobes.values()))
    from .model import Sum

    return Sum(tuple(lobes.values()), tuple(lobes))


def split(model: AbstractBRDF) -> dict[str, AbstractBRDF]:
    """The named lobes of a model: the inverse of `combine`."""
    from .model import Sum

    if isinstance(model, Sum):
        return dict(zip(model.names, model.lobes, strict=True))
    return {name_of(model): model}


def name_of(model: AbstractBRDF) -> str:
    """The registered name of a model that is not a sum: the stem of the file that defines it."""
    return type(model).__module__.rpartition(".")[2]


def build(expression: str) -> AbstractBRDF:
    """The model of an expression such as `"oren_nayar+ggx"`, with every parameter at its default."""
    return combine({lobe: MODELS[name]() for lobe, name in lobe_models(expression).items()})


def expression_of(model: AbstractBRDF) -> str:
    """The expression that `build` turns into a model of this structure."""
    return "+".join(name_of(lobe) for lobe in split(model).values())
