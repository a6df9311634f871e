"""How far an element that ended at a bound could lie from it: the profile of the cost.

There the cost has a slope, and a standard error means nothing. The element is moved away from its bound, all others are
fitted again, and the limit is where the cost has risen as much as a 95 % interval allows (Venzon, Moolgavkar 1988, "A
Method for Computing Profile-Likelihood-Based Confidence Intervals").
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Float

from .identify import NORMAL_95, Certainty
from .levenberg import NormalEquations
from .minimise import Minimum, Problem, minimise
from .samples import CHUNK

# Chunks of samples on which the profile is taken, refinements of the limit, and the tolerance of each fit.
_CHUNKS = 8
_ROUNDS = 4
_RTOL = 1e-6
_CLOSE = 0.05


def profiled(
    problem: Problem, y: Float[np.ndarray, " k"], sure: Certainty, equations: NormalEquations, scores: np.ndarray
) -> Certainty:
    """The certainty with intervals for the elements at a bound, from the bound to their limit.

    **Arguments:**

    - `y`, `sure`: the solution and what is known of it; `sure.inflation` widens the limits too.
    - `equations`, `scores`: of all samples there, see `fitter.normal`.
    """
    stuck = np.flatnonzero(sure.at_bound & (problem.upper > problem.lower))
    if stuck.size == 0:
        return sure
    count = min(_CHUNKS, problem.arranged.subset.count)
    samples = len(problem.arranged.rows)
    # All samples together rise faster than this share of them.
    share = min(count * CHUNK, samples) / samples * problem.arranged.share
    own = np.flatnonzero(np.isfinite(sure.standard_errors))
    # Slopes at a bound are no scatter.
    gradient = np.asarray(equations.gradient)
    scores = scores - np.outer(gradient, gradient) * problem.arranged.share / samples
    intervals = sure.intervals.copy()
    for element in stuck:
        scatter = _scatter(np.asarray(equations.hessian), scores, np.append(own, element))
        rise = 0.5 * NORMAL_95**2 * sure.inflation * share * scatter
        # Of data without any scatter nothing is known to be possible but the bound.
        limit = y[element]
        if rise > 0:
            limit = _limit(problem, y, int(element), float(gradient[element]) * share, rise, count)
        ends = y.copy(), y.copy()
        ends[0][element], ends[1][element] = sorted((y[element], limit))
        intervals[element] = [problem.unknowns.values(end)[element] for end in ends]
    return dataclasses.replace(sure, intervals=intervals)


def _scatter(hessian: np.ndarray, scores: np.ndarray, elements: np.ndarray) -> float:
    """The variance of the last of some elements over that of a cost of unit variance (Huber 1967, see `identify`)."""
    place = np.ix_(elements, elements)
    root = np.sqrt(np.maximum(np.diagonal(hessian)[elements], np.finfo(float).tiny))
    scale = np.outer(root, root)
    inverse = np.linalg.pinv(hessian[place] / scale, rcond=1e-10, hermitian=True)
    variance = (inverse @ (scores[place] / scale) @ inverse)[-1, -1]
    return float(max(variance, 0.0) / inverse[-1, -1]) if inverse[-1, -1] > 0 else 0.0


def _limit(
    problem: Problem, y: Float[np.ndarray, " k"], element: int, gradient: float, rise: float, count: int
) -> float:
    """Where the profile of an element has risen by `rise`, in the solver's units.

    Its slope at the bound is that of all samples, `gradient`; how it bends is seen on the first `count` chunks.
    """
    lower, upper = problem.lower[element], problem.upper[element]
    length = upper - lower
    bound, sign = (lower, 1.0) if y[element] - lower < upper - y[element] else (upper, -1.0)

    def refit(point: np.ndarray, step: float) -> Minimum:
        start, low, high = point.copy(), problem.lower.copy(), problem.upper.copy()
        start[element] = low[element] = high[element] = bound + sign * step
        return minimise(lambda y: problem.assess(y, count=count), start, low, high, rtol=_RTOL, atol=0.0, max_steps=6)

    base = refit(y, 0.0)
    own = sign * float(base.assessment.equations.gradient[element])
    slope = max(sign * gradient, 0.0)
    # The others held, it bends too much: the first step is too short, if anything.
    step = min(_reach(slope, float(base.assessment.equations.hessian[element, element]), rise), length)
    inner, outer = 0.0, np.inf
    point = base.y
    for _ in range(_ROUNDS):
        found = refit(point, step)
        point, risen = found.y, found.cost - base.cost + (slope - own) * step
        if abs(risen / rise - 1) < _CLOSE or (step >= length and risen < rise):
            break
        inner, outer = (step, outer) if risen < rise else (inner, step)
        guess = _reach(slope, 2 * max(risen - slope * step, 0.0) / step**2, rise)
        if np.isinf(outer):
            step = float(np.clip(guess, 1.1 * inner, min(4 * inner, length)))
        else:
            margin = 0.05 * (outer - inner)
            step = float(np.clip(guess, inner + margin, outer - margin))
    return float(bound + sign * step)


def _reach(slope: float, bend: float, rise: float) -> float:
    """Where a parabola has risen by `rise`."""
    return 2 * rise / max(slope + math.sqrt(slope * slope + 2 * bend * rise), np.finfo(float).tiny)
