"""How far an element that ended at a bound could lie from it: the profile of the cost.

There the cost has a slope, and a standard error means nothing. The element is moved away from its bound, all others are
fitted again, and the limit is where the cost has risen as much as a 95 % interval allows (Venzon, Moolgavkar 1988, "A
Method for Computing Profile-Likelihood-Based Confidence Intervals").
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float

from .identify import NORMAL_95, Certainty
from .levenberg import NormalEquations
from .minimise import Problem, minimise

# Chunks of samples on which the profile is taken, refinements of the limit, and the tolerance of each fit.
_CHUNKS = 8
_ROUNDS = 3
_RTOL = 1e-6
_CLOSE = 0.05


def profiled(problem: Problem, y: Float[np.ndarray, " k"], sure: Certainty) -> Certainty:
    """The certainty with intervals for the elements at a bound, from the bound to their limit.

    **Arguments:**

    - `y`, `sure`: the solution and what is known of it; `sure.inflation` widens the limits too.
    """
    stuck = np.flatnonzero(sure.at_bound & ~sure.idle & (problem.upper > problem.lower))
    if stuck.size == 0:
        return sure
    count = min(_CHUNKS, problem.arranged.subset.count)
    free = minimise(
        lambda y: problem.assess(y, count=count),
        y,
        problem.lower,
        problem.upper,
        rtol=_RTOL,
        atol=0.0,
        max_steps=4,
    )
    residuals = max(3 * min(count * 1024, len(problem.arranged.rows)) - len(y), 1)
    share = count / problem.arranged.subset.count * problem.arranged.share
    # Cost is half a sum of squares of this variance; all samples together rise faster than this share of them.
    rise = 0.5 * NORMAL_95**2 * sure.inflation * share * 2 * free.cost / residuals
    intervals = sure.intervals.copy()
    for element in stuck:
        limit = _limit(problem, free.y, free.assessment.equations, int(element), rise, count)
        ends = y.copy(), y.copy()
        ends[0][element], ends[1][element] = sorted((y[element], limit))
        intervals[element] = [problem.unknowns.values(end)[element] for end in ends]
    return dataclasses.replace(sure, intervals=intervals)


def _limit(
    problem: Problem,
    y: Float[np.ndarray, " k"],
    equations: NormalEquations,
    element: int,
    rise: float,
    count: int,
) -> float:
    """Where the profile of an element has risen by `rise`, in the solver's units."""
    lower, upper = problem.lower[element], problem.upper[element]
    sign = 1.0 if y[element] - lower < upper - y[element] else -1.0
    length = upper - lower
    base = float(equations.cost)
    slope = max(sign * float(equations.gradient[element]), 0.0)
    bend = max(float(equations.hessian[element, element]), 1e-300)
    # Where a parabola would have risen as much, the others held: too near, if anything.
    step = min(2 * rise / (slope + np.sqrt(slope * slope + 2 * bend * rise)), length)
    inner, outer, risen = 0.0, length, 0.0
    point = y
    for _ in range(_ROUNDS):
        start, low, high = point.copy(), problem.lower.copy(), problem.upper.copy()
        start[element] = low[element] = high[element] = y[element] + sign * step
        found = minimise(lambda y: problem.assess(y, count=count), start, low, high, rtol=_RTOL, atol=0.0, max_steps=6)
        point, risen = found.y, found.cost - base
        if abs(risen / rise - 1) < _CLOSE or (step >= length and risen < rise):
            break
        inner, outer = (step, outer) if risen < rise else (inner, step)
        # A rise between linear and quadratic: one and a half powers.
        guess = step * (rise / max(risen, 0.05 * rise)) ** (1 / 1.5)
        step = float(np.clip(guess, inner + 0.05 * (outer - inner), outer))
    return float(y[element] + sign * step)
