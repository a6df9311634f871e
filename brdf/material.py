"""A material: a model with its parameters and where they came from, as JSON on disk.

    {"model": "lambert+ggx",
     "parameters": {"lambert": {"albedo": [r, g, b]}, "ggx": {"f0": [r, g, b], "alpha": 0.2, "masking": "smith"}},
     "provenance": {...}}

A lobe that occurs twice is `ggx` and `ggx_2`; static choices stand beside the parameters of their lobe; a colour may be
one number (grey); what is left out has its default.
"""

from __future__ import annotations

import dataclasses
import difflib
import json
import math
import os
import pathlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .atomic import atomic_path
from .errors import FileError, UserError, nearest
from .parameter import Choice, Parameter, choices, parameters
from .plain import Declaration, PlainLobe, declared
from .registry import combine, expression_of, lobe_models, split

if TYPE_CHECKING:
    from .model import AbstractBRDF

_KEYS = ("model", "parameters", "provenance")
# A material file holds a few numbers and their provenance; anything beyond this is another kind of file.
_SIZE_MAX = 16 * 2**20
_Found = TypeVar("_Found")


@dataclasses.dataclass(frozen=True)
class Material:
    """A named model with its parameters and their provenance.

    **Arguments:**

    - `brdf`: the model.
    - `provenance`: JSON-serialisable: what made it, from which file, with which error.
    """

    brdf: AbstractBRDF
    provenance: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    @property
    def model(self) -> str:
        """The expression of the model, such as `"lambert+ggx"`."""
        return expression_of(self.brdf)

    def to_dict(self) -> dict[str, Any]:
        """The material as the JSON object of the module's docstring; inverse of `from_dict`."""
        lobes = {}
        for lobe, model in split(self.brdf).items():
            values: dict[str, Any] = {}
            for parameter in parameters(model):
                values[parameter.name] = np.asarray(getattr(model, parameter.name), np.float64).tolist()
            for choice in choices(model):
                values[choice.name] = getattr(model, choice.name)
            lobes[lobe] = values
        result: dict[str, Any] = {"model": self.model, "parameters": lobes}
        if self.provenance:
            result["provenance"] = dict(self.provenance)
        return result


def check_parameter(value: Any, parameter: Parameter, where: str) -> float | list[float]:
    """The value as a float or three floats, if it suits the declaration; raises `UserError` if it does not.

    **Arguments:**

    - `value`: a number, or three for a colour (one number means grey); plain or NumPy.
    - `parameter`: the declaration.
    - `where`: the lobe's name, for the message.
    """
    name = f"{where}.{parameter.name}"
    value = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    numbers = list(value) if isinstance(value, list | tuple) else [value]
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in numbers):
        raise UserError(f"`{name} = {value}` is not numeric. Give {_shape(parameter)}.")
    if len(numbers) == 1 and parameter.size == 3:
        numbers = numbers * 3
    if len(numbers) != parameter.size:
        raise UserError(f"`{name} = {value}` holds {len(numbers)} numbers. Give {_shape(parameter)}.")
    for x in numbers:
        if not math.isfinite(x) or not parameter.lower <= x <= parameter.upper:
            is_roughness = parameter.slope and x > parameter.upper
            hint = " If it is a perceptual roughness, use `alpha = roughness**2`." if is_roughness else ""
            raise UserError(
                f"`{name} = {x}` is outside [{parameter.lower:g}, {parameter.upper:g}].{hint} "
                f"It is the {parameter.doc}{'' if parameter.unit == '1' else f', in {parameter.unit}'}."
            )
    return [float(x) for x in numbers] if parameter.size == 3 else float(numbers[0])


def _shape(parameter: Parameter) -> str:
    span = f"[{parameter.lower:g}, {parameter.upper:g}]"
    return f"three numbers in {span}, or one for grey" if parameter.size == 3 else f"one number in {span}"


def check_choice(value: Any, choice: Choice, where: str) -> str:
    """The option, if the choice has it; raises `UserError`, naming the nearest one, if not."""
    if value not in choice.options:
        raise UserError(f"`{where}.{choice.name} = {value}` is not an option. {nearest(str(value), choice.options)}")
    return value


def from_dict(data: Any) -> Material:
    """The material of a JSON object (see the module's docstring), every name and bound checked.

    Raises `UserError` for a missing or unknown name (with the nearest known one) and for a value out of bounds.
    """
    lobes = plain_from_dict(data, declared)
    return Material(combine({name: lobe.build() for name, lobe in lobes.items()}), data.get("provenance", {}))


def plain_from_dict(data: Any, declaration_of: Callable[[str], Declaration]) -> dict[str, PlainLobe]:
    """The named lobes of a JSON object, checked as `from_dict` does.

    **Arguments:** `declaration_of`: from a registered model's name to what it declares.
    """
    if not isinstance(data, Mapping):
        raise UserError("A material is a JSON object with the keys `model` and `parameters`.")
    if not isinstance(data.get("model"), str):
        raise UserError('The key `model` is missing or not a string. Write for example `"model": "lambert+ggx"`.')
    for key in data:
        if key not in _KEYS:
            close = difflib.get_close_matches(str(key), _KEYS, 1, 0.7)
            remedy = f"Did you mean `{close[0]}`?" if close else "Choices stand among the parameters of their lobe."
            raise UserError(f"`{key}` is not a key of a material, which are `{'`, `'.join(_KEYS)}`. {remedy}")
    lobes = lobe_models(data["model"])
    given = data.get("parameters", {})
    if not isinstance(given, Mapping):
        raise UserError('`parameters` must be an object with one object per lobe, as in {"ggx": {"alpha": 0.2}}.')
    for lobe in given:
        if lobe not in lobes:
            raise UserError(f"`{lobe}` in `parameters` is not a lobe of `{data['model']}`. {nearest(lobe, lobes)}")
    checked = {lobe: _lobe(model, declaration_of(model), lobe, given.get(lobe, {})) for lobe, model in lobes.items()}
    if not isinstance(data.get("provenance", {}), Mapping):
        raise UserError("`provenance` must be a JSON object; remove it if in doubt.")
    return checked


def _lobe(model: str, declaration: Declaration, lobe: str, given: Any) -> PlainLobe:
    if not isinstance(given, Mapping):
        raise UserError(f"`{lobe}` must be an object of parameter names and values.")
    numbers = {p.name: p for p in declaration.parameters}
    names = {c.name: c for c in declaration.choices}
    values: dict[str, Any] = {p.name: [p.default] * 3 if p.size == 3 else p.default for p in declaration.parameters}
    options = {c.name: c.default for c in declaration.choices}
    for name, value in given.items():
        if name in numbers:
            values[name] = check_parameter(value, numbers[name], lobe)
        elif name in names:
            options[name] = check_choice(value, names[name], lobe)
        else:
            raise UserError(f"`{name}` is not a parameter of `{lobe}`. {nearest(name, [*numbers, *names])}")
    for name in given:
        if name in numbers and not numbers[name].is_live_under(options):
            raise _no_effect(numbers[name], lobe)
    arrays = {name: np.asarray(value, np.float64) for name, value in values.items()}
    return PlainLobe(model, declaration, arrays, options)


def check_live(parameter: Parameter, model: AbstractBRDF, where: str) -> None:
    """Raises `UserError`, naming the choices that it needs, for a parameter that the model's choices leave unused."""
    if not parameter.is_live(model):
        raise _no_effect(parameter, where)


def _no_effect(parameter: Parameter, where: str) -> UserError:
    needed = ", ".join(f"`{choice}` = {' or '.join(options)}" for choice, options in parameter.when)
    return UserError(f"`{where}.{parameter.name}` has no effect here. It needs {needed}.")


def load_material(path: str | os.PathLike[str]) -> Material:
    """Reads a material from a JSON file.

    Raises `FileError`, naming the file and the place in it, if it cannot be read or is not a material.
    """
    return _load(path, from_dict)


def load_plain(path: str | os.PathLike[str], declaration_of: Callable[[str], Declaration]) -> dict[str, PlainLobe]:
    """The named lobes of a JSON file; use it where a material's numbers are needed and not its functions.

    **Arguments:** `declaration_of`: as in `plain_from_dict`.

    Raises what `load_material` raises.
    """
    return _load(path, lambda data: plain_from_dict(data, declaration_of))


def _load(path: str | os.PathLike[str], understand: Callable[[Any], _Found]) -> _Found:
    file = pathlib.Path(path)
    try:
        if file.stat().st_size > _SIZE_MAX:
            raise FileError(path, f"It is larger than {_SIZE_MAX >> 20} MiB.", "A material is a small JSON file.")
        data = json.loads(file.read_text(encoding="utf-8-sig"), object_pairs_hook=_once)
    except FileError:
        raise
    except OSError as error:
        raise FileError(path, f"It cannot be read: {error.strerror}.", "Check the path and its permissions.") from None
    except UnicodeDecodeError as error:
        remedy = "A material is a JSON file; a measurement goes to `brdf fit` first."
        raise FileError(path, f"It is not text (byte {error.start}).", remedy) from None
    except (json.JSONDecodeError, RecursionError, ValueError) as error:
        if isinstance(error, UserError):
            raise FileError(path, str(error), "") from None
        place = f" (line {error.lineno}: {error.msg})" if isinstance(error, json.JSONDecodeError) else ""
        remedy = "A material is written by `brdf fit -o material.json`."
        raise FileError(path, f"It is not valid JSON{place}.", remedy) from None
    try:
        return understand(data)
    except FileError:
        raise
    except UserError as error:
        raise FileError(path, str(error), "`brdf models` lists models and parameters.") from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object, unless a key stands in it twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise UserError(f"`{next(key for key in keys if keys.count(key) > 1)}` stands twice. Remove one of the two.")
    return found


def save_material(material: Material, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes a material as JSON, whole or not at all; floats keep every digit.

    Raises `FileError` if `path` exists and `force` is not given, or if it cannot be written.
    """
    text = json.dumps(material.to_dict(), indent=2, allow_nan=False) + "\n"
    with atomic_path(path, force) as temporary:
        temporary.write_text(text, encoding="utf-8")
