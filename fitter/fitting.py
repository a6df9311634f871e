"""Fits a reflectance model to a measurement: start, coarse, fine, judge."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import numpy as np

from brdf.errors import UserError
from brdf.frame import HORIZON
from brdf.material import Material, check_parameter, load_material
from brdf.model import AbstractBRDF
from brdf.registry import build, expression_of, nearest

from .formats import read
from .identify import certainty
from .loss import LOSSES
from .minimise import Minimum, Problem, minimise
from .normal import Assessment
from .reflectance import Reflectance
from .result import FitResult
from .samples import arrange
from .start import candidates, interchangeable, scan, sort_lobes
from .unknowns import Unknowns, Wishes, choose
from .weights import weights as weights_of

# Chunks, a random part of the samples, on which starts are refined; the best one goes on to all.
_COARSE = 4
# Starts are refined until the lowest cost has been found twice, at least and at most so many.
_STARTS_MIN, _STARTS_MAX = 2, 6
_SAME = 1e-6
# A step that would lower the cost by a smaller share is not assessed: it moves no parameter by a hundredth of its
# standard error. On a part of the samples that share stays below what the other samples will change.
_RTOL, _RTOL_COARSE, _RTOL_ALL = 1e-10, 1e-6, 1e-7
# Mean square of the residuals that counts as an exact fit: rounding of float64 values up to log(1 + 1e4).
_EXACT = 1e-29
# Samples that are looked at for it.
_AZIMUTH_SAMPLES = 4096
# Azimuths of the half vector that differ by more than this, in radians, show that the sample was turned.
_AZIMUTHS = 1e-3


def fit(
    model: str | AbstractBRDF | Material,
    data: Reflectance | str | os.PathLike[str],
    *,
    fixed: Mapping[str, Any] | None = None,
    tied: Mapping[str, str] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    free: Sequence[str] = (),
    start: Material | AbstractBRDF | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    loss: str = "log",
    weights: str = "samples",
    max_theta_deg: float = 80.0,
    progress: Callable[[str], None] | None = None,
) -> FitResult:
    """Fits the parameters of a model to a measurement.

    Names of parameters are `"alpha"`, or `"ggx.alpha"` where several lobes have it.

    **Arguments:**

    - `model`: an expression such as `"lambert+ggx"`, or a model or material whose parameters stand where they are fixed
      and whose static choices are kept.
    - `data`: a measurement, or the path of one.
    - `fixed`: parameters and static choices that are held, such as `{"alpha": 0.2, "ggx.masking": "smith"}`.
    - `tied`: pairs of parameters that are to be equal, such as `{"alpha_x": "alpha_y"}`.
    - `bounds`: parameter -> (lower, upper), inside its declared bounds.
    - `free`: parameters to fit although the model's declaration holds them by default (see `Parameter.held`).
    - `start`: a material (or the path of one) of the same lobes, from which alone the fit starts, or values of single
      parameters from which it starts instead of scanning them.
    - `loss`: a key of `fitter.loss.LOSSES`.
    - `weights`: one of `fitter.weights.WEIGHTS`.
    - `max_theta_deg`: samples whose incident or outgoing polar angle is this or more, in degrees (0, 90], are left out:
      measurements at grazing angles are seldom reliable.
    - `progress`: called with a sentence at the beginning of each stage.

    **Returns:**

    The result with parameters, errors and what was left out. A fit that did not converge is returned too; its `status`
    says what happened and what to try.

    **Raises:** `UserError` for an unknown model, parameter or loss, a value out of bounds, or data without a sample
    inside `max_theta_deg`; `FileError` for a file that cannot be read.
    """
    started = time.perf_counter()
    say = progress or (lambda sentence: None)
    if loss not in LOSSES:
        raise UserError(f"`{loss}` is not a loss. {nearest(loss, LOSSES)}")
    if isinstance(model, Material):
        model = model.brdf
    elif isinstance(model, str):
        model = build(model)
    wishes = Wishes(fixed or {}, tied or {}, bounds or {}, free)
    # A user's mistake in a name is told before a large file is read.
    choose(model, wishes)
    if not isinstance(data, Reflectance):
        say(f"reading {os.fspath(data)}")
        data = read(data)
    data = _cut(data, max_theta_deg)
    # The fit runs in float64 whatever the caller's setting: stopping tests of float32 sit in its rounding noise.
    with jax.enable_x64(True):
        unknowns = choose(model, wishes, _has_azimuths(data))
        weight = weights_of(data, weights, LOSSES[loss])
        if not (weight > 0).all():
            keep = np.asarray(np.all(weight > 0, axis=1))
            data, weight = data.select(keep, "weight 0"), weight[keep]
        problem = Problem(unknowns, arrange(data, LOSSES[loss], weight), loss)
        solution = _solve(problem, start, say)
        found, problem = solution.assessment, solution.problem
        hessian, scores = np.asarray(found.equations.hessian), np.asarray(found.scores)
        sure = certainty(problem.unknowns, solution.y, hessian, scores, len(data))
    return FitResult(
        brdf=problem.unknowns.settled(solution.y, sure.at_bound),
        initial=problem.unknowns.settled(solution.start, np.zeros(len(solution.y), bool)),
        unknowns=problem.unknowns,
        certainty=sure,
        errors=_errors(found, data),
        converged=solution.converged,
        status=solution.status,
        steps=solution.steps,
        passes=solution.passes,
        seconds=time.perf_counter() - started,
        data=data,
        loss=loss,
        weights=weights,
        max_theta_deg=max_theta_deg,
    )


def _cut(data: Reflectance, max_theta_deg: float) -> Reflectance:
    if not 0 < max_theta_deg <= 90:
        raise UserError(f"`max_theta_deg = {max_theta_deg}` is outside (0, 90]. Its default is 80.")
    # Samples exactly at the limit are left out, and rounding must not decide about them.
    limit = max(math.cos(math.radians(max_theta_deg)) + 1e-12, HORIZON)
    keep = (data.wi[:, 2] > limit) & (data.wo[:, 2] > limit)
    if not keep.any():
        raise UserError(
            f"{data.source}: every sample lies beyond `max_theta_deg = {max_theta_deg:g}`. Raise it, at most to 90."
        )
    return data if keep.all() else data.select(keep, f"theta >= {max_theta_deg:g} deg")


def _has_azimuths(data: Reflectance) -> bool:
    """Whether the half vectors of a measurement lie at several azimuths."""
    some = slice(None, None, max(len(data) // _AZIMUTH_SAMPLES, 1))
    half = data.wi[some, :2] + data.wo[some, :2]
    long = np.hypot(half[:, 0], half[:, 1]) > _AZIMUTHS
    if not long.any():
        return False
    # Half a turn is the same axis: the doubled angle, against that of the first.
    direction = half[long, 0] + 1j * half[long, 1]
    turned = (direction / direction[0]) ** 2
    return bool((np.abs(np.angle(turned)) > 2 * _AZIMUTHS).any())


@dataclasses.dataclass(frozen=True)
class _Solution:
    """Where a fit ended; `assessment` holds the scores too, and `problem` the values at which parameters are held."""

    problem: Problem
    y: np.ndarray
    start: np.ndarray
    assessment: Assessment
    converged: bool
    status: str
    steps: int
    passes: float


def _solve(problem: Problem, start: Any, say: Callable[[str], None]) -> _Solution:
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
    steps = found.steps
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
        steps = found.steps
    y = sort_lobes(found.y, interchangeable(problem.unknowns))
    # The products of single samples' gradients are a sample statistic: the subset tells them well enough.
    last = problem.assess(y, scores=True)
    if len(arranged.slabs) > 1:
        last = last._replace(scores=last.scores / arranged.share)
        equations = _sorted_equations(found, y, last, arranged.share)
        last = Assessment(equations, found.assessment.log_abs, found.assessment.log_square, last.scores)
    converged, status = _status(found, steps)
    passes = sum(variant.passes for variant in variants)
    return _Solution(problem, y, origin, last, converged, status, steps, passes)


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
    return [(variant, row) for _, _, variant, row in found]


def _given(unknowns: Unknowns, start: Mapping[str, Any]) -> dict[int, float]:
    """The solver's elements of the values from which a user wants to start."""
    given: dict[int, float] = {}
    labels = [unknown.label for unknown in unknowns.free]
    for key, value in start.items():
        found = [u for u in unknowns.free if key in (u.label, u.parameter.name)]
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
    for tried, (problem, y) in enumerate(starts[:_STARTS_MAX]):
        count = min(_COARSE, problem.arranged.subset.count)
        atol = _EXACT * count * 1024
        found = minimise(
            lambda y, problem=problem, count=count: problem.assess(y, count=count),
            y,
            problem.lower,
            problem.upper,
            rtol=_RTOL_COARSE,
            atol=atol,
        )
        is_same = best is not None and abs(found.cost - best[1].cost) <= _SAME * best[1].cost
        if best is None or found.cost < best[1].cost:
            best, origin = (problem, found), y
        if found.cost <= atol or (is_same and tried + 1 >= _STARTS_MIN):
            break
    assert best is not None
    return best, origin


def _errors(found: Assessment, data: Reflectance) -> dict[str, float]:
    numbers = 3 * len(data)
    return {
        "log_mae": float(found.log_abs) / numbers,
        "log_rms": math.sqrt(float(found.log_square) / numbers),
        "cost": float(found.equations.cost),
    }


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
