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

from brdf.errors import UserError, nearest
from brdf.frame import HORIZON
from brdf.material import Material
from brdf.model import AbstractBRDF
from brdf.registry import build

from .advice import advise
from .bootstrap import bootstrapped
from .formats import read
from .identify import certainty
from .loss import LOSSES
from .minimise import Problem
from .normal import Assessment
from .profile import profiled
from .quality import inspect
from .reflectance import Reflectance
from .result import FitResult
from .samples import arrange
from .solve import solve
from .weights import weights as weights_of
from .wishes import Wishes, choose

ADAPTIVE = "adaptive"
# Compressions from the darkest to the brightest emphasis.
_ADAPTIVE_LOSSES = ("log", "cube_root", "square_root", "cosine")
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
    advice: bool = False,
    quick: bool = False,
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
    - `loss`: a key of `fitter.loss.LOSSES`; or `"adaptive"`, which fits with several of them and keeps the fit that
      looks most like the measurement (Bieron and Peers 2020; see `fitter.judge`).
    - `weights`: one of `fitter.weights.WEIGHTS`.
    - `max_theta_deg`: samples whose incident or outgoing polar angle is this or more, in degrees (0, 90], are left out:
      measurements at grazing angles are seldom reliable.
    - `advice`: whether to work out which further scans would help most (`FitResult.advice`).
    - `quick`: leaves out the bootstrap, the profiles at bounds and the inspection of the data; standard errors then
      take samples as independent.
    - `progress`: called with a sentence at the beginning of each stage.

    **Returns:**

    The result with parameters, errors and what was left out. A fit that did not converge is returned too; its `status`
    says what happened and what to try.

    **Raises:** `UserError` for an unknown model, parameter or loss, a value out of bounds, or data without a sample
    inside `max_theta_deg`; `FileError` for a file that cannot be read.
    """
    say = progress or (lambda sentence: None)
    if loss not in LOSSES and loss != ADAPTIVE:
        raise UserError(f"`{loss}` is not a loss. {nearest(loss, [*LOSSES, ADAPTIVE])}")
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
    options = _Options(wishes, start, weights, max_theta_deg, advice, quick)
    if loss != ADAPTIVE:
        return _fit(model, data, loss, options, say)
    results = {}
    for one in _ADAPTIVE_LOSSES:
        say(f"loss {one}")
        results[one] = _fit(model, data, one, options, say)
    looks = {one: result.judgement.mean for one, result in results.items()}
    return dataclasses.replace(results[min(looks, key=lambda one: looks[one])], looks=looks)


@dataclasses.dataclass(frozen=True)
class _Options:
    """The arguments of `fit` that it hands on; see there."""

    wishes: Wishes
    start: Any
    weights: str
    max_theta_deg: float
    advice: bool
    quick: bool


def _fit(model: AbstractBRDF, data: Reflectance, loss: str, options: _Options, say: Callable[[str], None]) -> FitResult:
    started = time.perf_counter()
    weights, max_theta_deg = options.weights, options.max_theta_deg
    findings = () if options.quick else tuple(inspect(data))
    data = _cut(data, max_theta_deg)
    # The fit runs in float64 whatever the caller's setting: stopping tests of float32 sit in its rounding noise.
    with jax.enable_x64(True):
        unknowns = choose(model, options.wishes, _has_azimuths(data))
        weight = weights_of(data, weights, LOSSES[loss])
        if not (weight > 0).all():
            keep = np.asarray(np.all(weight > 0, axis=1))
            data, weight = data.select(keep, "weight 0"), weight[keep]
        problem = Problem(unknowns, arrange(data, LOSSES[loss], weight), loss)
        solution = solve(problem, options.start, say)
        found, problem = solution.assessment, solution.problem
        hessian, scores = np.asarray(found.equations.hessian), np.asarray(found.scores)
        sure = certainty(problem.unknowns, solution.y, hessian, scores, len(data))
        if not options.quick:
            share = problem.arranged.share
            sure = bootstrapped(problem, solution.y, sure, scores * share, solution.curvature, data, weight)
            sure = profiled(problem, solution.y, sure, found.equations, scores)
        advised = advise(problem, solution.y, hessian, sure) if options.advice else None
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
        findings=findings,
        advice=advised,
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


def _errors(found: Assessment, data: Reflectance) -> dict[str, float]:
    numbers = 3 * len(data)
    return {
        "log_mae": float(found.log_abs) / numbers,
        "log_rms": math.sqrt(float(found.log_square) / numbers),
        "cost": float(found.equations.cost),
    }
