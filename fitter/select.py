"""Which of several models a measurement supports: each is judged at angles of incidence that it was not fitted to.

    import fitter.select
    selection = fitter.select.select("gold.binary")
    print(selection.report())
    selection.result.material

More lobes always follow the samples that they are fitted to better, and information criteria believe every sample to be
independent, which neighbours in a table are not. So each model is fitted again with blocks of angles left out (see
`fitter.held_out`) and judged there. Of the models that come within a tolerance of the smallest error the one with the
fewest free numbers is taken, unless it is worse than `lambert+ggx` on all samples.

`"auto"` climbs a ladder of sums whose lobes start where those of the one below ended: a Lambertian base alone, with
`ggx`, with `general_gtr`, that over a rough base (`eon`) where the measurement can tell, and, unless a thousandth is
left to explain, with two `general_gtr`.
"""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import jax
import numpy as np

from brdf.errors import UserError
from brdf.model import AbstractBRDF, evaluate
from brdf.parameter import choices, parameters
from brdf.registry import build, expression_of, split

from .fitting import fit
from .formats import read
from .held_out import Blocks, blocks
from .reflectance import Reflectance
from .result import FitResult
from .selection import Candidate, Selection

AUTO = "auto"
REFERENCE = "lambert+ggx"
# Errors that differ by less, relative or absolute (mean |log(1 + f cos_i)|), count as the same.
_RELATIVE, _ABSOLUTE = 0.03, 3e-4
# An error below this is beyond what instruments repeat: "auto" tries no larger sum.
_ENOUGH = 1e-3
# Light and viewer at the same height up to this: the samples cannot tell diffuse bases apart.
_SAME_HEIGHT = 1e-6
# Folds fit at most so many samples: they judge a model, they do not deliver it.
_FOLD_SAMPLES_MAX = 1 << 16
_SEED = 19740101


def select(
    data: Reflectance | str | os.PathLike[str],
    models: str | Sequence[str | AbstractBRDF] = AUTO,
    *,
    fixed: Mapping[str, Any] | None = None,
    loss: str = "log",
    weights: str = "samples",
    max_theta_deg: float = 80.0,
    progress: Callable[[str], None] | None = None,
) -> Selection:
    """Fits several models and takes the simplest of those that predict angles of incidence best.

    **Arguments:**

    - `data`: a measurement, or the path of one.
    - `models`: `"auto"`, or expressions such as `("lambert+ggx", "oren_nayar+beckmann")`; a model in place of an
      expression brings its static choices.
    - `fixed`, `loss`, `weights`, `max_theta_deg`: as for `fitter.fit`, for every model. A parameter that a model does
      not have fails that model alone.
    - `progress`: called with a sentence at the beginning of each fit.

    **Returns:** the table and the fit that was taken. A model whose fit fails is a row that says why; one that did not
    converge is taken only if none did.

    **Raises:** `UserError` for an unknown model, if there is no model or none could be fitted; `FileError` for a file
    that cannot be read.
    """
    say = progress or (lambda sentence: None)
    is_auto = isinstance(models, str) and models == AUTO
    built = [] if is_auto else [build(one) if isinstance(one, str) else one for one in _listed(models)]
    if not isinstance(data, Reflectance):
        say(f"reading {os.fspath(data)}")
        data = read(data)
    options = {"fixed": fixed, "loss": loss, "weights": weights, "max_theta_deg": max_theta_deg}
    trial = _Trial(data, options, say)
    found: list[Candidate] = []
    for model in _ladder(data, found) if is_auto else built:
        found.append(trial.run(model, found if is_auto else []))
    return _choose(found, trial.blocks)


def _listed(models: str | Sequence[str | AbstractBRDF]) -> list[str | AbstractBRDF]:
    listed: list[str | AbstractBRDF] = [models] if isinstance(models, str) else list(models)
    if not listed:
        raise UserError('`models` is empty. Name one or more, or pass `"auto"`.')
    return listed


def _ladder(data: Reflectance, found: list[Candidate]) -> Iterator[AbstractBRDF]:
    """The models of "auto", each chosen after those before it were judged."""
    yield from map(build, ("lambert", REFERENCE, "lambert+general_gtr"))
    if (np.abs(data.wi[:, 2] - data.wo[:, 2]) > _SAME_HEIGHT).any():
        yield build("eon+general_gtr")
    best = min(_usable(found), key=_error, default=None)
    if best is None or max(_error(best), best.log_mae) > _ENOUGH:
        base = "eon" if best and best.expression.startswith("eon") else "lambert"
        yield build(f"{base}+general_gtr+general_gtr")


@dataclasses.dataclass
class _Trial:
    """Fits and judges one model after the other on the same samples."""

    data: Reflectance
    options: Mapping[str, Any]
    say: Callable[[str], None]
    blocks: Blocks | None = None

    def run(self, model: AbstractBRDF, earlier: Sequence[Candidate]) -> Candidate:
        """Fits a model to all samples, then without each fold; lobes of `earlier` ones start where they ended."""
        expression = expression_of(model)
        started = time.perf_counter()
        result, held_out, error, note = None, math.nan, math.nan, ""
        try:
            self.say(f"fitting {expression}")
            result = self._fit(model, self.data, _start(model, earlier))
            if not math.isfinite(result.errors["log_mae"]):
                result, note = None, "The fitted model is not finite. Fix a parameter, or leave the model out."
            else:
                note = "" if result.converged else result.status
                held_out, error = self._judge(model, result)
        except (UserError, ArithmeticError, np.linalg.LinAlgError) as failure:
            note = str(failure)
        return Candidate(expression, _chosen(model), result, held_out, error, time.perf_counter() - started, note)

    def _fit(self, model: AbstractBRDF, data: Reflectance, start: Any) -> FitResult:
        return fit(model, data, start=start, **self.options)

    def _judge(self, model: AbstractBRDF, result: FitResult) -> tuple[float, float]:
        """The mean held-out error and its standard error; NaN where nothing can be held out."""
        data = _thinned(result.data)
        parts = self.blocks = blocks(data)
        error = np.full(len(data), np.nan)
        for fold in range(parts.folds):
            self.say(f"judging {expression_of(model)}, {fold + 1} of {parts.folds}")
            out = parts.held_out(fold)
            # The fit to all samples is only where it starts: its own minimum is found anew.
            # It delivers no error bars, which take longer than the fit where parameters end at bounds.
            seen = fit(model, data.select(~out, "held out"), start=result.brdf, quick=True, **self.options)
            error[out] = log_error(seen.brdf, data.select(out, "not held out"))
        if not parts.folds:
            return math.nan, math.nan
        counts = np.bincount(parts.block, minlength=parts.count)
        means = np.bincount(parts.block, error, parts.count) / counts
        share = counts / counts.sum()
        mean = float(share @ means)
        # Blocks, not samples, are independent.
        scatter = float(np.sqrt(np.sum((share * (means - mean)) ** 2) * parts.count / (parts.count - 1)))
        return mean, scatter


def log_error(model: AbstractBRDF, data: Reflectance) -> np.ndarray:
    """|log(1 + f cos_i) - log(1 + y cos_i)| of each sample, the mean of its channels; shape (n,)."""
    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, data.wi, data.wo))
    cos_i = data.wi[:, 2:3]
    return np.abs(np.log1p(value * cos_i) - np.log1p(data.value * cos_i)).mean(axis=1)


def _thinned(data: Reflectance) -> Reflectance:
    """A random part of the samples, always the same, where there are more than folds need."""
    if len(data) <= _FOLD_SAMPLES_MAX:
        return data
    keep = np.zeros(len(data), bool)
    keep[np.random.default_rng(_SEED).choice(len(data), _FOLD_SAMPLES_MAX, replace=False)] = True
    return data.select(keep, "not needed to judge")


def _chosen(model: AbstractBRDF) -> str:
    """The static choices that are not the default, as `ggx.masking=kelemen`, for a row's name."""
    return ", ".join(
        f"{name}.{choice.name}={getattr(lobe, choice.name)}"
        for name, lobe in split(model).items()
        for choice in choices(lobe)
        if getattr(lobe, choice.name) != choice.default
    )


def _start(model: AbstractBRDF, earlier: Sequence[Candidate]) -> dict[str, float]:
    """Where the shapes of the lobes start that an earlier sum has too: where they ended; the others are scanned."""
    own = split(model)
    best: dict[str, float] = {}
    for candidate in sorted(_usable(earlier), key=_error):
        assert candidate.result is not None
        fitted = {name: lobe for name, lobe in split(candidate.result.brdf).items() if name in own}
        free = {place for unknown in candidate.result.unknowns.free for place in unknown.places}
        known = {
            f"{name}.{parameter.name}": float(getattr(lobe, parameter.name))
            for name, lobe in fitted.items()
            for parameter in parameters(lobe)
            if parameter.kind == "scalar" and (name, parameter.name) in free
        }
        if len(known) > len(best):
            best = known
    return best


def _error(candidate: Candidate) -> float:
    """What decides: the held-out error, or where there is none, that of all samples."""
    return candidate.held_out if math.isfinite(candidate.held_out) else candidate.log_mae


def _usable(found: Sequence[Candidate]) -> list[Candidate]:
    """Those that may be taken: converged ones, or if there is none, all that have an error."""
    fitted = [one for one in found if one.result is not None and math.isfinite(_error(one))]
    return [one for one in fitted if one.result and one.result.converged] or fitted


def _limit(error: float) -> float:
    return error + max(_RELATIVE * error, _ABSOLUTE)


def _choose(found: list[Candidate], parts: Blocks | None) -> Selection:
    usable = _usable(found)
    if not usable:
        told = " ".join(f"`{one.name}`: {one.note}" for one in found)
        raise UserError(f"No model could be fitted. {told}")
    reference = next((one for one in usable if one.expression == REFERENCE and not one.choices), None)
    fair = [one for one in usable if reference is None or one.log_mae <= reference.log_mae]
    best = min(fair, key=_error)
    close = [one for one in fair if _error(one) <= _limit(_error(best))]
    chosen = min(close, key=lambda one: (one.numbers or 0, _error(one)))
    folds = parts.folds if parts else 0
    where = f"at held-out {parts.angle}" if parts and folds else "on all samples, since no angle could be held out"
    reason = f"{chosen.name} has the smallest error {where}."
    if chosen is not best:
        reason = f"{chosen.name} is as good as {best.name} {where} to {100 * _RELATIVE:g} %, with fewer numbers."
    return Selection(tuple(found), chosen, parts.angle if parts else "", folds, reason)
