"""The one declaration of a model's parameters.

A model is an Equinox module whose fields are declared with `scalar()`, `color()` and `choice()`. The fit's bounds and
starts, the GLSL struct and uniform block, the command line, the JSON file, `brdf models` and the table in the README
all read this declaration; none of them keeps a list of its own.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

_KEY = "brdf"


class _Absent(float):
    """A zero that is known before anything is compiled."""


# In place of a weight that is exactly 0: a model leaves out what it scales. Made by `brdf.model.specialized`.
ABSENT = _Absent(0.0)
# 24 slopes from 0.002 to 1: neighbours differ by a factor 1.31, inside the basin of a log-loss fit of one lobe.
_SLOPE_STARTS = tuple(0.002 * (1 / 0.002) ** (i / 23) for i in range(24))


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One continuous parameter of a model, as declared on its field.

    **Arguments:**

    - `name`: snake_case; the Python field, GLSL member, JSON key and command-line key.
    - `kind`: `"scalar"` or `"color"` (three channels, linear Rec. 709).
    - `lower`, `upper`: inclusive bounds, the same for every channel.
    - `default`: inside the bounds.
    - `unit`: `"1"` for a plain number, else the unit.
    - `doc`: one sentence.
    - `slope`: whether it is the RMS-like slope of a specular lobe.
    - `starts`: values that the global start of a fit scans; a colour has none, its start is solved for.
    - `fit_square`: whether the fit's unknown is its square, for a model that is even in it.
    - `weight`: whether it scales a part of the model that vanishes with it; where it is 0 that part costs nothing.
    - `when`: pairs of a choice and its options with which alone the parameter is live; the others ignore it.
    - `held`: values at which a fit holds it unless told otherwise, since measurements alone cannot tell it from others;
      of several the one that fits best. `because`: from which others and when, as the predicate of a sentence.
    - `azimuthal`: whether only data that turn the sample about its normal tell anything of it.
    """

    name: str
    kind: Literal["scalar", "color"]
    lower: float
    upper: float
    default: float
    unit: str
    doc: str
    slope: bool = False
    starts: tuple[float, ...] = ()
    fit_square: bool = False
    weight: bool = False
    when: tuple[tuple[str, tuple[str, ...]], ...] = ()
    held: tuple[float, ...] = ()
    because: str = ""
    azimuthal: bool = False

    @property
    def size(self) -> int:
        """The number of values: 1 for a scalar, 3 for a colour."""
        return 3 if self.kind == "color" else 1

    def is_live(self, model: Any) -> bool:
        """Whether the static choices of a model let it depend on the parameter."""
        return self.is_live_under({choice: getattr(model, choice) for choice, _ in self.when})

    def is_live_under(self, options: Mapping[str, str]) -> bool:
        """`is_live` of a model by its options alone."""
        return all(options[choice] in needed for choice, needed in self.when)


@dataclasses.dataclass(frozen=True)
class Choice:
    """One static choice of a model, as declared on its field.

    **Arguments:**

    - `name`: snake_case; the Python field, the JSON key and, with the model's name before it, the GLSL `#define`.
    - `options`: the values that may be chosen, the default first.
    - `doc`: one sentence.
    """

    name: str
    options: tuple[str, ...]
    doc: str

    @property
    def default(self) -> str:
        return self.options[0]


def _floating(value: Any) -> Any:
    """Makes a plain number or list a float64 NumPy array, so that no digit read from a file is lost where JAX is in
    float32 mode; leaves JAX arrays, tracers and the placeholders of tree operations as they are."""
    is_plain = isinstance(value, int | float | list | tuple | np.ndarray | np.generic) and not isinstance(
        value, _Absent
    )
    return np.asarray(value, np.float64) if is_plain else value


def _color(value: Any) -> Any:
    array = _floating(value)
    return np.full(3, array) if isinstance(array, np.ndarray) and array.ndim == 0 else array


def scalar(
    lower: float,
    upper: float,
    default: float,
    doc: str,
    *,
    unit: str = "1",
    starts: tuple[float, ...] = (),
    fit_square: bool = False,
    weight: bool = False,
    when: Mapping[str, tuple[str, ...]] | None = None,
    held: tuple[float, ...] = (),
    because: str = "",
    azimuthal: bool = False,
) -> Any:
    """Declares a scalar parameter of a model; see `Parameter` for the arguments."""
    declared = Parameter(
        "",
        "scalar",
        lower,
        upper,
        default,
        unit,
        doc,
        starts=starts or (default,),
        fit_square=fit_square,
        weight=weight,
        held=held,
        because=because,
        azimuthal=azimuthal,
    )
    return _declare(declared, when)


def slope(
    lower: float, upper: float, default: float, doc: str, *, when: Mapping[str, tuple[str, ...]] | None = None
) -> Any:
    """Declares a microfacet slope parameter, conventionally called `alpha`; see `Parameter` for the arguments."""
    starts = tuple(start for start in _SLOPE_STARTS if lower <= start <= upper)
    return _declare(Parameter("", "scalar", lower, upper, default, "1", doc, True, starts), when)


def rotation(
    doc: str = "angle by which the tangent frame is turned about the normal",
    *,
    when: Mapping[str, tuple[str, ...]] | None = None,
) -> Any:
    """Declares the angle of an anisotropic lobe's axes in radians; half a turn changes nothing."""
    return scalar(-1.5707963, 1.5707963, 0.0, doc, unit="rad", starts=(-0.8, 0.0, 0.8), when=when, azimuthal=True)


def color(
    lower: float,
    upper: float,
    default: float,
    doc: str,
    *,
    unit: str = "1",
    weight: bool = False,
    when: Mapping[str, tuple[str, ...]] | None = None,
) -> Any:
    """Declares a colour parameter, linear Rec. 709, three channels; a single number means grey."""
    return _declare(Parameter("", "color", lower, upper, default, unit, doc, weight=weight), when)


def _declare(declared: Parameter, when: Mapping[str, tuple[str, ...]] | None) -> Any:
    if not declared.lower <= declared.default <= declared.upper:
        bounds = f"[{declared.lower}, {declared.upper}]"
        raise ValueError(f"The default `{declared.default}` is outside its own bounds {bounds}.")
    declared = dataclasses.replace(declared, when=tuple((when or {}).items()))
    import equinox as eqx  # loads JAX, which models need and their declarations do not

    converter = _color if declared.kind == "color" else _floating
    return eqx.field(default=declared.default, converter=converter, metadata={_KEY: declared})


def choice(*options: str, doc: str) -> Any:
    """Declares a static choice among `options`, the first being the default; it becomes a `#define` in GLSL."""
    import equinox as eqx  # as above

    return eqx.field(default=options[0], static=True, metadata={_KEY: Choice("", options, doc)})


def _declared(model: Any, kind: type) -> list[Any]:
    found = []
    for field in dataclasses.fields(model):
        declared = field.metadata.get(_KEY)
        if isinstance(declared, kind):
            found.append(dataclasses.replace(declared, name=field.name))  # type: ignore[type-var]
    return found


def is_absent(value: Any) -> bool:
    """Whether a weight is known to be 0 before anything is compiled."""
    return isinstance(value, _Absent)


def parameters(model: Any) -> tuple[Parameter, ...]:
    """The continuous parameters in the order of their declaration: all of a model class, the live ones of a model."""
    found = _declared(model, Parameter)
    return tuple(found if inspect.isclass(model) else [one for one in found if one.is_live(model)])


def choices(model: Any) -> tuple[Choice, ...]:
    """The static choices of a model class or instance, in the order of their declaration."""
    return tuple(_declared(model, Choice))
