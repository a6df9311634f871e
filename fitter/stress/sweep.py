"""Counts what no evaluation may give, over millions of points: NaN, Inf, negative values, light below the horizon."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from brdf.frame import HORIZON
from brdf.model import AbstractBRDF

from . import points
from .evaluation import FAULTS, Array, Evaluate, values_and_gradients, with_leaves

# Points that are made at once.
_BLOCK = 1 << 16
# Directions per set of parameters in GLSL, where these are uniforms.
_PAIRS = 4096
_SHOWN = 3


@dataclasses.dataclass(frozen=True)
class Offender:
    """One point at which a model breaks, with all that is needed to try it again.

    - `fault`: one of `FAULTS`.
    - `arithmetic`: such as `"JAX float32"`.
    - `model`: with this point's choices and parameters.
    - `value`: (3,) as it came out.
    - `gradient`: what it was by each parameter and direction, for a fault of the gradient.
    """

    fault: str
    arithmetic: str
    model: AbstractBRDF
    wi: Array
    wo: Array
    value: Array
    gradient: dict[str, Array]


@dataclasses.dataclass
class Counts:
    """How many points were tried in one arithmetic, and how often each of `FAULTS` occurred."""

    arithmetic: str
    points: int = 0
    faults: dict[str, int] = dataclasses.field(default_factory=lambda: dict.fromkeys(FAULTS, 0))
    offenders: list[Offender] = dataclasses.field(default_factory=list)

    def add(self, fault: str, where: Any, offender: Callable[[int], Offender]) -> None:
        """Counts the true elements of `where`, and keeps the first few offenders of the fault."""
        found = np.flatnonzero(where)
        self.faults[fault] += len(found)
        kept = sum(one.fault == fault for one in self.offenders)
        self.offenders += [offender(int(index)) for index in found[: max(_SHOWN - kept, 0)]]


def sweep_jax(
    model: AbstractBRDF, rng: np.random.Generator, count: int, counts: Counts, precision: str
) -> Iterator[None]:
    """Tries `count` points on one structure of a model, its gradient included; yields now and then."""
    for start in range(0, count, _BLOCK):
        size = min(_BLOCK, count - start)
        leaves = points.parameter_sets(model, rng, size, precision)
        wi, wo = points.directions(points.widths(model, leaves, rng, size), rng, precision)
        value, gradient, faults = values_and_gradients(model, leaves, wi, wo)
        counts.points += size
        if faults.any():
            _collect(counts, model, [*leaves, wi, wo], value, gradient, faults)
        yield


def _collect(
    counts: Counts, model: AbstractBRDF, inputs: list[Array], value: Array, gradient: Array, faults: Array
) -> None:
    *leaves, wi, wo = inputs
    names = [f"{lobe}.{parameter.name}" for lobe, parameter in points.declared(model)] + ["wi", "wo"]
    ends = np.cumsum([array[0].size for array in inputs])[:-1]
    for bit, fault in enumerate(FAULTS):

        def offender(index: int, fault: str = fault) -> Offender:
            here = with_leaves(model, [leaf[index, ...] for leaf in leaves])
            by_name = dict(zip(names, np.split(gradient[index], ends), strict=True))
            by_name = by_name if fault.startswith("gradient") else {}
            return Offender(fault, counts.arithmetic, here, wi[index], wo[index], value[index], by_name)

        counts.add(fault, (faults >> bit) & 1, offender)


def sweep_glsl(
    model: AbstractBRDF, rng: np.random.Generator, count: int, counts: Counts, evaluate: Evaluate
) -> Iterator[None]:
    """Tries at least `count` points on one structure of a model in GLSL; yields after every set of parameters."""
    # At least 16 sets of parameters, also in a short run.
    pairs = min(_PAIRS, -(-count // (16 * points.KINDS)) * points.KINDS)
    sets = -(-count // pairs)
    leaves = points.parameter_sets(model, rng, sets, np.float32)
    width = points.widths(model, leaves, rng, sets)
    for number in range(sets):
        here = with_leaves(model, [leaf[number, ...] for leaf in leaves])
        wi, wo = points.directions(np.full(pairs, width[number]), rng, np.float32)
        value = evaluate(here, wi, wo)
        below = (wi[:, 2] <= HORIZON) | (wo[:, 2] <= HORIZON)
        faults: list[Array] = [np.isnan(value), np.isinf(value), value < 0, (value != 0) & below[:, None]]
        for fault, where in zip(FAULTS, faults, strict=False):

            def offender(index: int, fault: str = fault) -> Offender:
                return Offender(fault, counts.arithmetic, here, wi[index], wo[index], value[index], {})  # noqa: B023

            counts.add(fault, np.any(where, axis=1), offender)
        counts.points += pairs
        yield
