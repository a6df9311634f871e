"""Evaluations per second: the compiled model, the same formula in NumPy, and Mitsuba 3, in interleaved rounds."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from brdf.model import AbstractBRDF
from brdf.parameter import Parameter, is_absent, parameters
from brdf.registry import combine, split

from .numpy_program import NumpyProgram

Array = NDArray[Any]
# A contestant runs this long per round, in CPU seconds, in as many calls as it takes.
_ROUND_SECONDS = 0.02
# Smaller values are compared as if they were so large: XLA takes subnormal numbers for zero.
NEGLIGIBLE = 1e-30


@dataclasses.dataclass(frozen=True)
class Cost:
    """What one evaluation of a compiled model costs.

    - `flops`: floating-point operations that XLA counts after it has simplified the program.
    - `operations`: the length of the program before, in array operations.
    - `per_second`: evaluations.
    """

    flops: float
    operations: int
    per_second: float


@dataclasses.dataclass(frozen=True)
class Speed:
    """Evaluations per second of a model.

    - `value`, `gradient`: of the compiled model: the value alone, and with its derivatives.
    - `numpy_value`, `numpy_gradient`: of the same formulas in NumPy.
    - `derivatives`: how many there are: one per parameter, three per colour where channels mix.
    - `difference`: the largest relative difference of both values, as a check that both did the same work.
    """

    value: float
    gradient: float
    numpy_value: float
    numpy_gradient: float
    derivatives: int
    difference: float


def directions(count: int, dtype: str) -> tuple[Array, Array]:
    """`wi` and `wo`, each (3, count), uniform over the hemisphere."""
    rng = np.random.default_rng(0)
    cosine, phi = rng.uniform(0, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    sine = np.sqrt(1 - cosine * cosine)
    wi, wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=1).astype(dtype)
    return wi, wo


def rates(contestants: Mapping[str, tuple[Callable[[], Any], int]], rounds: int) -> dict[str, float]:
    """Evaluations per CPU second: the median of interleaved rounds, after a first run that is not counted.

    **Arguments:** name -> a run and the number of evaluations in it; and the number of rounds.
    """
    calls, seconds = {}, {name: [] for name in contestants}
    for name, (run, _) in contestants.items():
        run()
        calls[name] = max(1, round(_ROUND_SECONDS / max(_timed(run, 1), 1e-6)))
    for _ in range(rounds):
        for name, (run, _) in contestants.items():
            seconds[name].append(_timed(run, calls[name]))
    return {name: count / statistics.median(seconds[name]) for name, (_, count) in contestants.items()}


def _timed(run: Callable[[], Any], calls: int) -> float:
    """CPU seconds of one call: another process on the core does not count."""
    start = time.process_time()
    for _ in range(calls):
        run()
    return (time.process_time() - start) / calls


def value(model: AbstractBRDF, wi: Any, wo: Any) -> Any:
    """The values of all pairs at once, (3, n): with each component in one piece, vector instructions are of use."""
    return jax.vmap(model, in_axes=-1, out_axes=-1)(wi, wo)


def value_and_gradient(model: AbstractBRDF, wi: Any, wo: Any) -> Any:
    """Values and their derivatives in forward mode, which is what a fit takes: one per parameter, and one per channel
    of a colour where a model mixes channels."""
    lobes = split(model)
    derivatives = []
    for name, p in ((name, p) for name, lobe in lobes.items() for p in parameters(lobe)):

        def along(number: Any, name: str = name, p: Parameter = p) -> Any:
            changed = dataclasses.replace(lobes[name], **{p.name: number})
            return value(combine(lobes | {name: changed}), wi, wo)

        number = getattr(lobes[name], p.name)
        each = p.size == 3 and lobes[name].mixes_channels
        for tangent in np.eye(3, dtype=number.dtype) if each else [jnp.ones_like(number)]:
            derivatives.append(jax.jvp(along, (number,), (tangent,))[1])
    return value(model, wi, wo), derivatives


def _prepared(model: AbstractBRDF, points: int, dtype: str) -> tuple[AbstractBRDF, Array, Array]:
    def number(leaf: Any) -> Any:
        return leaf if is_absent(leaf) else jnp.asarray(leaf, dtype)

    return jax.tree.map(number, (model, *directions(points, dtype)))


def speed(model: AbstractBRDF, points: int, dtype: str, rounds: int) -> Speed:
    """Measures a model at its parameters; see `Speed`."""
    with jax.enable_x64(dtype == "float64"):
        arguments = _prepared(model, points, dtype)
        on_host = jax.tree.map(np.asarray, arguments)
        contestants, found = {}, {}
        for name, function in (("value", value), ("gradient", value_and_gradient)):
            compiled = jax.jit(function).lower(*arguments).compile()
            program = NumpyProgram(function, *on_host)
            contestants[name] = (lambda run=compiled: jax.block_until_ready(run(*arguments)), points)
            contestants[f"numpy_{name}"] = (lambda run=program: run(*on_host), points)
            found[name] = [np.asarray(leaf) for leaf in jax.tree.leaves(compiled(*arguments))], program(*on_host)
        measured = rates(contestants, rounds)
    ours, theirs = found["value"]
    return Speed(**measured, derivatives=len(found["gradient"][0]) - 1, difference=difference(theirs[0], ours[0]))


def cost(model: AbstractBRDF, points: int, dtype: str, rounds: int) -> Cost:
    """Measures what one value of a model costs; see `Cost`."""
    with jax.enable_x64(dtype == "float64"):
        model, wi, wo = _prepared(model, points, dtype)
        numbers, absent = eqx.partition(model, eqx.is_array)
        arguments = (numbers, wi, wo)

        def function(numbers: AbstractBRDF, wi: Array, wo: Array) -> Array:
            return value(eqx.combine(numbers, absent), wi, wo)

        compiled = jax.jit(function).lower(*arguments).compile()
        run = lambda: jax.block_until_ready(compiled(*arguments))  # noqa: E731
        per_second = rates({"value": (run, points)}, rounds)["value"]
        flops = float((compiled.cost_analysis() or {}).get("flops", float("nan"))) / points
        return Cost(flops, NumpyProgram(function, *jax.tree.map(np.asarray, arguments)).size, per_second)


def difference(found: Array, truth: Array) -> float:
    """The largest difference relative to the truth, or to `NEGLIGIBLE` where the truth is smaller."""
    return float(np.max(np.abs(found - truth) / np.maximum(np.abs(truth), NEGLIGIBLE)))
