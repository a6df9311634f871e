"""Fits a reflectance model to a measurement: start, coarse, fine, judge."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable, Mapping
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float, Int

from brdf.errors import UserError
from brdf.material import Material
from brdf.model import AbstractBRDF
from brdf.registry import build, nearest

from .formats import read
from .identify import certainty
from .loss import LOSSES, Samples, arrange, difference
from .normal import NormalEquations, normal_equations, score_products
from .reflectance import Reflectance
from .result import FitResult
from .solver import BoundedLevenbergMarquardt
from .start import candidates, scan
from .unknowns import Unknowns, choose

# How many starts are refined on the first chunk, a random subset; the best one goes on to all samples.
_STARTS = 3
_MAX_STEPS = 200
# A step that would lower the cost by a smaller share is not worth its evaluation: for a million samples it moves no
# parameter by more than a fiftieth of its standard error.
_RTOL = 1e-10
# Mean square of the residuals that counts as an exact fit: rounding of float64 values up to log(1 + 1e4).
_EXACT = 1e-29


def fit(
    model: str | AbstractBRDF | Material,
    data: Reflectance | str | os.PathLike[str],
    *,
    fixed: Mapping[str, Any] | None = None,
    loss: str = "log",
    max_theta_deg: float = 80.0,
    progress: Callable[[str], None] | None = None,
) -> FitResult:
    """Fits the parameters of a model to a measurement.

    **Arguments:**

    - `model`: an expression such as `"lambert+ggx"`, or a model or material whose parameters stand where they are fixed
      and whose static choices are kept.
    - `data`: a measurement, or the path of one.
    - `fixed`: parameters and static choices that are held, such as `{"alpha": 0.2, "ggx.masking": "smith"}`.
    - `loss`: `"log"` or `"log_squares"`, see `fitter.loss`.
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
    unknowns = choose(model, fixed or {})
    if not isinstance(data, Reflectance):
        say(f"reading {os.fspath(data)}")
        data = read(data)
    data = _cut(data, max_theta_deg)
    if not data.weight.all():
        data = data.select(data.weight > 0, "weight 0")
    # The fit runs in float64 whatever the caller's setting: stopping tests of float32 sit in its rounding noise.
    with jax.enable_x64(True):
        solution = _run(unknowns, data, loss, say)
        y = np.asarray(solution.y)
        sure = certainty(unknowns, y, np.asarray(solution.hessian), np.asarray(solution.scores), len(data.value))
    return FitResult(
        brdf=unknowns.settled(y, sure.at_bound),
        initial=unknowns.settled(solution.start, np.zeros(len(y), bool)),
        unknowns=unknowns,
        certainty=sure,
        errors=solution.errors,
        converged=solution.converged,
        status=solution.status,
        steps=solution.steps,
        seconds=time.perf_counter() - started,
        data=data,
        loss=loss,
        max_theta_deg=max_theta_deg,
    )


def _cut(data: Reflectance, max_theta_deg: float) -> Reflectance:
    if not 0 < max_theta_deg <= 90:
        raise UserError(f"`max_theta_deg = {max_theta_deg}` is outside (0, 90]. Its default is 80.")
    # Samples exactly at the limit are left out, and rounding must not decide about them.
    limit = math.cos(math.radians(max_theta_deg)) + 1e-12
    keep = (data.wi[:, 2] > limit) & (data.wo[:, 2] > limit)
    if not keep.any():
        raise UserError(
            f"{data.source}: every sample lies beyond `max_theta_deg = {max_theta_deg:g}`. Raise it, at most to 90."
        )
    return data if keep.all() else data.select(keep, f"theta >= {max_theta_deg:g} deg")


@dataclasses.dataclass(frozen=True)
class _Solution:
    y: Array
    start: np.ndarray
    hessian: Array
    scores: Array
    errors: dict[str, float]
    converged: bool
    status: str
    steps: int


def _run(unknowns: Unknowns, data: Reflectance, loss: str, say: Callable[[str], None]) -> _Solution:
    samples = arrange(data, loss)
    chunks = samples.wi.shape[0]
    # On the device once, not at each call.
    samples = jax.tree.map(jnp.asarray, samples)
    lower, upper = (jnp.asarray(bound) for bound in unknowns.bounds())
    rows = candidates(unknowns)
    say(f"trying {len(rows)} starts")
    refined, costs = scan(unknowns, jnp.asarray(rows), samples, lower, upper)
    order = np.argsort(np.asarray(costs))[:_STARTS]
    starts = [refined[index] for index in order]
    count = jnp.asarray(chunks)
    if not unknowns.free:
        equations = normal_equations(unknowns, starts[0], samples, count)
        return _judge(unknowns, starts[0], starts[0], equations, samples, count, optx.RESULTS.successful, 0)
    say("fitting a subset")
    coarse = [_solve(unknowns, samples, jnp.asarray(1), y, lower, upper) for y in starts]
    best = int(np.argmin([float(solution.state.equations.cost) for solution in coarse]))
    solution, steps = coarse[best], int(coarse[best].stats["num_steps"])
    if chunks > 1:
        say(f"fitting {len(data.value)} samples")
        solution = _solve(unknowns, samples, count, solution.value, lower, upper)
        steps = int(solution.stats["num_steps"])
    equations = solution.state.equations
    return _judge(unknowns, starts[best], solution.value, equations, samples, count, solution.result, steps)


def _judge(
    unknowns: Unknowns,
    start: Array,
    y: Array,
    equations: NormalEquations,
    samples: Samples,
    count: Int[Array, ""],
    result: optx.RESULTS,
    steps: int,
) -> _Solution:
    errors = {name: float(value) for name, value in _errors(unknowns, y, samples, count).items()}
    errors["cost"] = float(equations.cost)
    converged, status = _status(result, steps)
    scores = eqx.filter_jit(score_products)(unknowns, y, samples, count)
    return _Solution(y, np.asarray(start), equations.hessian, scores, errors, converged, status, steps)


@eqx.filter_jit
def _solve(
    unknowns: Unknowns,
    samples: Samples,
    count: Int[Array, ""],
    y: Float[Array, " k"],
    lower: Float[Array, " k"],
    upper: Float[Array, " k"],
) -> optx.Solution:
    """Minimises the loss over the first `count` chunks, from `y`."""
    solver = BoundedLevenbergMarquardt(
        rtol=_RTOL,
        atol=_EXACT * samples.root_weight.size,
        normal_equations=lambda y, args: normal_equations(unknowns, y, *args),
    )
    return optx.least_squares(
        lambda y, args: y,  # the solver forms its own normal equations, chunk by chunk
        solver,
        y,
        (samples, count),
        {"lower": lower, "upper": upper},
        max_steps=_MAX_STEPS,
        throw=False,
    )


@eqx.filter_jit
def _errors(unknowns: Unknowns, y: Float[Array, " k"], samples: Samples, count: Int[Array, ""]) -> dict[str, Array]:
    """Mean absolute and root mean square difference of `log(1 + f cos_i)`, every sample counting the same."""
    model = unknowns.model(y)

    def add(index: Array, total: Float[Array, "3"]) -> Float[Array, "3"]:
        chunk = samples.chunk(index)
        used = (chunk.root_weight > 0).astype(y.dtype)
        distance = jnp.abs(difference(model, chunk))
        return total + jnp.stack([3 * used.sum(), (distance * used).sum(), (distance * distance * used).sum()])

    total = jax.lax.fori_loop(0, count, add, jnp.zeros(3, y.dtype))
    return {"log_mae": total[1] / total[0], "log_rms": jnp.sqrt(total[2] / total[0])}


def _status(result: optx.RESULTS, steps: int) -> tuple[bool, str]:
    if result == optx.RESULTS.successful:
        return True, f"Converged in {steps} step{'' if steps == 1 else 's'}."
    if result == optx.RESULTS.nonlinear_max_steps_reached:
        return False, (
            f"Stopped after {steps} steps, still improving: two parameters may trade off against each other. "
            "Fix one of them, or fit fewer lobes."
        )
    if result == optx.RESULTS.nonlinear_divergence:
        return False, (
            f"Stopped after {steps} steps: no step lowers the error, yet the slope is not zero. "
            "Fix the parameters that trade off, or start from another model."
        )
    return False, "The model is not finite at the start. Check the values of the fixed parameters."
