"""The host's side of a fit: a compiled pass over the samples, and the loop that calls it.

The pass (`fitter.normal.assess`) is the only program that depends on the model; it is compiled once, for slabs of one
size, whatever the measurement. The loop runs on the host, where it costs less than a millisecond per step and nothing
to compile.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import functools
import os
from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float

from .levenberg import NormalEquations, State, advance, begin
from .normal import Assessment, assess
from .program import kept
from .samples import Arranged, Samples, Slab
from .unknowns import Unknowns

Vector = Float[np.ndarray, " k"]
MAX_STEPS = 200


class Problem:
    """What is fitted to what: assesses points, and counts what that costs.

    **Arguments:**

    - `unknowns`, `arranged`, `loss`: see there.

    `passes` is the number of evaluations so far, in units of one pass over all samples.
    """

    def __init__(self, unknowns: Unknowns, arranged: Arranged, loss: str):
        self.unknowns, self.arranged, self.loss = unknowns, arranged, loss
        self.lower, self.upper = unknowns.bounds()
        self.passes = 0.0
        self._chunks = sum(slab.count for slab in arranged.slabs)
        leaves, static = eqx.partition(unknowns, eqx.is_array)
        self._leaves, tree = jax.tree.flatten(leaves)
        count = len(self._leaves)

        def run(*arguments):
            unknowns = eqx.combine(jax.tree.unflatten(tree, arguments[:count]), static)
            samples = Samples(*arguments[count + 1 : count + 6])
            found = assess(unknowns, arguments[count], samples, loss, *arguments[count + 6 :])
            return tuple(jax.tree.leaves(found))

        example = self._arguments(self.lower, arranged.subset.samples, 0, 0, False)
        self._program = kept(f"assess {loss} {unknowns.structure}", run, example)

    def varied(self, unknowns: Unknowns) -> Problem:
        """The same problem with other values of the parameters that are not free."""
        return Problem(unknowns, self.arranged, self.loss)

    def assess(
        self, y: Vector, slab: Slab | None = None, first: int = 0, count: int | None = None, scores: bool = False
    ) -> Assessment:
        """Assesses a point over some chunks of a slab; over the whole subset by default."""
        slab = slab or self.arranged.subset
        count = slab.count if count is None else count
        self.passes += count / self._chunks
        return self.assess_samples(y, slab.samples, first, count, scores)

    def assess_samples(self, y: Vector, samples: Samples, first: int, count: int, scores: bool = False) -> Assessment:
        """Assesses a point over some chunks of any samples of the same layout."""
        # The setting is a thread's own, and slabs are assessed in several.
        with jax.enable_x64(True):
            found = self._program(*self._arguments(y, samples, first, count, scores))
        cost, gradient, hessian, *rest = map(np.asarray, found)
        return Assessment(NormalEquations(cost, gradient, hessian), *rest)

    def _arguments(self, y: Vector, samples: Samples, first: int, count: int, scores: bool) -> list[Any]:
        arrays = (samples.wi, samples.wo, samples.value, samples.weight, samples.scale)
        return [*self._leaves, y, *arrays, np.int32(first), np.int32(count), np.bool_(scores)]

    def everywhere(self, y: Vector) -> Assessment:
        """Assesses a point over all samples, the slabs side by side on the machine's cores."""
        slabs = self.arranged.slabs
        if len(slabs) == 1:
            return self.assess(y, slabs[0])
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            parts = list(pool.map(lambda slab: self.assess(y, slab), slabs))
        return jax.tree.map(lambda *numbers: sum(numbers), *parts)


@dataclasses.dataclass(frozen=True)
class Minimum:
    """Where a minimisation ended.

    - `y`: the solution; `state`: of the method; `steps`: how many points were assessed.
    - `assessment`: of the last point that was accepted, a last tiny step before `y`.
    """

    y: Vector
    state: State
    assessment: Assessment
    steps: int

    @property
    def cost(self) -> float:
        return float(self.state.equations.cost)

    @property
    def curvature(self) -> Float[np.ndarray, "k k"] | None:
        """What J^T J leaves out of the Hessian, if the method trusts its estimate."""
        return np.asarray(self.state.curvature) if self.state.trusted else None


def minimise(
    evaluate: Callable[[Vector], Assessment],
    y: Vector,
    lower: Vector,
    upper: Vector,
    *,
    rtol: float,
    atol: float,
    max_steps: int = MAX_STEPS,
    curvature: Float[np.ndarray, "k k"] | None = None,
    damping: float | None = None,
) -> Minimum:
    """Minimises a cost inside bounds.

    A last step that would lower the cost by less than `rtol` of it is taken without being assessed.

    **Arguments:**

    - `evaluate`: from a vector to its `Assessment`.
    - `y`, `lower`, `upper`: where to start, and the bounds; elements whose bounds are equal stay.
    - `rtol`, `atol`: see `fitter.levenberg.advance`.
    - `curvature`, `damping`: what an earlier minimisation learnt, see `fitter.levenberg.begin`.
    """
    state = begin(y, lower, upper, curvature) if damping is None else begin(y, lower, upper, curvature, damping)
    if not y.size:
        found = evaluate(y)
        return Minimum(y, state._replace(equations=found.equations, done=np.ones((), bool)), found, 0)
    assessment = None
    steps = 0
    while steps < max_steps:
        found = evaluate(np.asarray(state.trial))
        steps += 1
        before = float(state.equations.cost)
        state = _advance(state, found.equations, lower, upper, rtol, atol)
        if assessment is None or float(state.equations.cost) < before:
            assessment = found
        if state.done or state.failed or state.stuck:
            break
    assert assessment is not None
    last = np.asarray(state.y) + (np.asarray(state.delta) if state.done and state.decrease > 0 else 0.0)
    return Minimum(np.clip(last, lower, upper), state, assessment, steps)


def _advance(state: State, trial: NormalEquations, lower: Vector, upper: Vector, rtol: float, atol: float) -> State:
    leaves, tree = jax.tree.flatten(state)
    arguments = [*leaves, *trial, lower, upper, np.float64(rtol), np.float64(atol)]
    return jax.tree.unflatten(tree, map(np.asarray, _advance_program(len(lower))(*arguments)))


@functools.cache
def _advance_program(size: int) -> Callable[..., Sequence[Array]]:
    vector, matrix, zero = np.zeros(size), np.zeros((size, size)), np.zeros(())
    blank = NormalEquations(zero, vector, matrix)
    leaves, tree = jax.tree.flatten(begin(vector, vector, vector))

    def run(*arguments):
        state = jax.tree.unflatten(tree, arguments[: len(leaves)])
        cost, gradient, hessian, *rest = arguments[len(leaves) :]
        return tuple(jax.tree.leaves(advance(state, NormalEquations(cost, gradient, hessian), *rest)))

    return kept("advance", run, [*leaves, *blank, vector, vector, zero, zero])
