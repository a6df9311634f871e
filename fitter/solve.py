"""The road of a fit: starts, the best of them on a few samples, then on more, then on all.

A random part of the samples finds the solution; all of them only move it by what that part could not know. So a large
measurement is passed over about three times, whatever the number of steps.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Mapping
from typing import Any

import jax
import numpy as np

from brdf.errors import UserError, nearest
from brdf.material import Material, check_parameter, load_material
from brdf.model import AbstractBRDF
from brdf.registry import expression_of

from .minimise import Minimum, Problem, minimise
from .normal import Assessment
from .samples import CHUNK
from .start import candidates, elsewhere, interchangeable, near, scan, sort_lobes
from .unknowns import Unknowns

# Chunks, a random part of the samples, on which starts are refined; the best one goes on to all.
_COARSE = 4
# Starts that are not near each other are refined until the lowest cost has been found again once for each shape
# parameter, or so often, and at most so many of them.
_REPEATED_MAX, _STARTS_MAX = 3, 16
# Steps after which a start must have come within this factor of the lowest cost, and steps that it then gets.
_TRIAL_STEPS, _PROMISING, _MORE_STEPS = 25, 2.0, 60
_SAME = 1e-6
# Candidates whose costs differ by a smaller share than this are one: rounding, as of an azimuth without anisotropy.
_IDLE = 1e-9
# A step that would lower the cost by a smaller share is not assessed: it moves no parameter by a hundredth of its
# standard error. On a part of the samples that share stays below what the other samples will change.
_RTOL, _RTOL_COARSE, _RTOL_ALL = 1e-10, 1e-6, 1e-6
# Mean square of the residuals that counts as an exact fit: rounding of float64 values up to log(1 + 1e4).
_EXACT = 1e-29


@dataclasses.dataclass(frozen=True)
class Solution:
    """Where a fit ended; `assessment` holds the scores too, and `problem` the values at which parameters are held."""

    problem: Problem
    y: np.ndarray
    start: np.ndarray
    assessment: Assessment
    curvature: np.ndarray | None
    converged: bool
    status: str
    steps: int
    passes: float


def solve(problem: Problem, start: Any, say: Callable[[str], None]) -> Solution:
    arranged = problem.arranged
    variants = [problem.varied(unknowns) for unknowns in problem.unknowns.variants()]
    starts = _starts(variants, start, say)
    say("fitting a subset")
    best, origin = _coarse(starts)
    problem, coarse = best
    atol = _EXACT * arranged.rows.size
    found = minimise(
        problem.assess,
        coarse.y,
        problem.lower,
        problem.upper,
        rtol=_RTOL if len(arranged.slabs) == 1 else _RTOL_COARSE,
        atol=atol,
        curvature=_scaled(coarse, arranged.subset.count / min(_COARSE, arranged.subset.count)),
    )
    steps = coarse.steps + found.steps
    if len(arranged.slabs) > 1:
        say(f"fitting all samples, {sum(slab.count for slab in arranged.slabs)} thousand")
        found = minimise(
            problem.everywhere,
            found.y,
            problem.lower,
            problem.upper,
            rtol=_RTOL_ALL,
            atol=atol / arranged.share,
            curvature=_scaled(found, 1 / arranged.share),
        )
        steps += found.steps
    y = sort_lobes(found.y, interchangeable(problem.unknowns))
    # The products of single samples' gradients are a sample statistic: the subset tells them well enough.
    last = problem.assess(y, scores=True)
    if len(arranged.slabs) > 1:
        last = last._replace(scores=last.scores / arranged.share)
        equations = _sorted_equations(found, y, last, arranged.share)
        last = Assessment(equations, found.assessment.log_abs, found.assessment.log_square, last.scores)
    converged, status = _status(found, steps)
    passes = sum(variant.passes for variant in variants)
    curvature = found.curvature if np.array_equal(y, found.y) else None
    if curvature is not None:
        curvature = curvature * arranged.share
    return Solution(problem, y, origin, last, curvature, converged, status, steps, passes)


def _sorted_equations(found: Minimum, y: np.ndarray, last: Assessment, share: float) -> Any:
    """The equations at the solution: those of all samples unless lobes were exchanged after them."""
    if np.array_equal(y, found.y):
        return found.assessment.equations
    return jax.tree.map(lambda part: part / share, last.equations)._replace(cost=found.assessment.equations.cost)


def _scaled(found: Minimum, factor: float) -> np.ndarray | None:
    return None if found.curvature is None else found.curvature * factor


def _starts(variants: list[Problem], start: Any, say: Callable[[str], None]) -> list[tuple[Problem, np.ndarray]]:
    """Where to start, the most promising first."""
    problem = variants[0]
    if isinstance(start, str | os.PathLike):
        start = load_material(start)
    if isinstance(start, Material):
        start = start.brdf
    if isinstance(start, AbstractBRDF):
        wanted, got = expression_of(problem.unknowns.template), expression_of(start)
        if wanted != got:
            raise UserError(f"The start is `{got}`, but `{wanted}` is fitted. Start from a material of the same lobes.")
        return [(variant, variant.unknowns.vector(start)) for variant in variants]
    rows = candidates(problem.unknowns, _given(problem.unknowns, start or {}))
    say(f"trying {len(rows) * len(variants)} starts")
    found = []
    for variant in variants:
        solved, costs = scan(variant, rows)
        found += [(cost, place, variant, row) for place, (cost, row) in enumerate(zip(costs, solved, strict=True))]
    found.sort(key=lambda one: one[:2])
    return [(variant, row) for _, _, variant, row in _distinct(found)]


def _distinct(
    found: list[tuple[float, int, Problem, np.ndarray]],
) -> list[tuple[float, int, Problem, np.ndarray]]:
    """The candidates in order, the best one of each variant first.

    Those that differ from a better one in nothing but what has no effect are left out: they would find the same minimum
    twice and so pass for a proof of it.
    """
    first, others = [], []
    last: dict[int, float] = {}
    for one in found:
        cost, variant = one[0], id(one[2])
        if variant not in last:
            first.append(one)
        elif cost > last[variant] * (1 + _IDLE):
            others.append(one)
        else:
            continue
        last[variant] = cost
    return first + others


def _given(unknowns: Unknowns, start: Mapping[str, Any]) -> dict[int, float]:
    """The solver's elements of the values from which a user wants to start."""
    given: dict[int, float] = {}
    labels = [unknown.label for unknown in unknowns.free]
    for key, value in start.items():
        found = [u for u in unknowns.free if any(key in (name, f"{lobe}.{name}") for lobe, name in u.places)]
        if len(found) != 1:
            raise UserError(f"`{key}` is not one free parameter here. {nearest(key, labels)}")
        unknown = found[0]
        elements = np.atleast_1d(unknown.inward(check_parameter(value, unknown.parameter, unknown.lobe)))
        given |= {unknown.offset + place: float(x) for place, x in enumerate(elements)}
    return given


def _coarse(starts: list[tuple[Problem, np.ndarray]]) -> tuple[tuple[Problem, Minimum], np.ndarray]:
    """The best minimum on a few chunks, and where it started."""
    best: tuple[Problem, Minimum] | None = None
    origin = starts[0][1]
    scalars = sum(unknown.parameter.kind == "scalar" for unknown in starts[0][0].unknowns.free)
    enough, repeated = min(max(scalars, 1), _REPEATED_MAX), 0
    tried: list[tuple[Problem, np.ndarray]] = []
    for problem, y in starts:
        if any(problem is other and near(problem.unknowns, y, before) for other, before in tried):
            continue
        tried.append((problem, y))
        lowest = math.inf if best is None else best[1].cost
        found = _refined(problem, y, lowest)
        if _exact(problem) < found.cost < lowest * (1 - _SAME):
            others = [_refined(problem, other, found.cost) for other in elsewhere(problem.unknowns, found.y)]
            found = min([found, *others], key=lambda one: one.cost)
        if abs(found.cost - lowest) <= _SAME * lowest:
            repeated += 1
        elif found.cost < lowest:
            repeated = 0
        if best is None or found.cost < lowest:
            best, origin = (problem, found), y
        if found.cost <= _exact(problem) or repeated >= enough or len(tried) >= _STARTS_MAX:
            break
    assert best is not None
    return best, origin


def _exact(problem: Problem) -> float:
    """The cost on a few chunks that counts as none."""
    return _EXACT * min(_COARSE, problem.arranged.subset.count) * CHUNK


def _refined(problem: Problem, y: np.ndarray, lowest: float) -> Minimum:
    """The minimum on a few chunks, left early unless it comes near the lowest cost of other starts."""
    count = min(_COARSE, problem.arranged.subset.count)

    def descend(y: np.ndarray, steps: int, earlier: Minimum | None = None) -> Minimum:
        return minimise(
            lambda y: problem.assess(y, count=count),
            y,
            problem.lower,
            problem.upper,
            rtol=_RTOL_COARSE,
            atol=_exact(problem),
            max_steps=steps,
            curvature=None if earlier is None else earlier.curvature,
            damping=None if earlier is None else float(earlier.state.damping),
        )

    found = descend(y, _TRIAL_STEPS)
    if found.state.done or found.state.failed or found.state.stuck or found.cost > _PROMISING * lowest:
        return found
    return descend(found.y, _MORE_STEPS, found)


def _status(found: Minimum, steps: int) -> tuple[bool, str]:
    if found.state.failed:
        return False, "The model is not finite at the start. Check the values of the fixed parameters."
    if found.state.stuck:
        return False, (
            f"Stopped after {steps} steps: no step lowers the error, yet the slope is not zero. "
            "Fix the parameters that trade off, or start from another model."
        )
    if not found.state.done:
        return False, (
            f"Stopped after {steps} steps, still improving: two parameters may trade off against each other. "
            "Fix one of them, or fit fewer lobes."
        )
    return True, f"Converged in {steps} step{'' if steps == 1 else 's'}."
