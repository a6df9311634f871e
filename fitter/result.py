"""What a fit gives back: the material, how sure it is, and a report to read."""

from __future__ import annotations

import dataclasses
import functools
import importlib.metadata
import math
from typing import Any

import numpy as np

from brdf.material import Material
from brdf.model import AbstractBRDF
from brdf.registry import expression_of

from .identify import Certainty
from .reflectance import Reflectance
from .unknowns import Unknowns

# Correlations below this are left out of the report; above the second one they are a warning.
_CORRELATION_SHOWN = 0.1
_CORRELATION_WARNED = 0.95
_CORRELATIONS_WARNED_MAX = 3
# A mean log error above the first is a misfit that shows; above the second the data are likely in another unit.
_MISFIT_WARNED = 0.08
_UNITS_WARNED = 1.5
# Polar angles that all lie below this were most likely radians, of which a right angle has 1.57.
_RADIANS_DEG = 1.6


@dataclasses.dataclass(frozen=True)
class FitResult:
    """The outcome of `fitter.fit`.

    - `brdf`: the fitted model; `material` is the same with its provenance.
    - `initial`: the model at the start that was chosen.
    - `unknowns`, `certainty`: what was free, and standard errors and correlations of it.
    - `errors`: `log_mae` and `log_rms`, the unweighted mean absolute and root mean square of
      |log(1 + f cos_i) - log(1 + y cos_i)| over the samples used; `cost`, half the sum of squared residuals.
    - `converged`, `status`, `steps`: how the solver ended, as a sentence, and after how many steps.
    - `passes`: what the fit cost, in passes over all samples.
    - `seconds`: wall time of the whole fit, compilation included.
    - `data`: the samples that were used; its `dropped` counts the others.
    - `loss`, `weights`, `max_theta_deg`: as given.
    """

    brdf: AbstractBRDF
    initial: AbstractBRDF
    unknowns: Unknowns
    certainty: Certainty
    errors: dict[str, float]
    converged: bool
    status: str
    steps: int
    passes: float
    seconds: float
    data: Reflectance
    loss: str
    weights: str
    max_theta_deg: float

    @property
    def samples(self) -> int:
        """How many samples were used."""
        return len(self.data.value)

    @property
    def dropped(self) -> dict[str, int]:
        """Reason -> how many samples were left out."""
        return dict(self.data.dropped)

    @functools.cached_property
    def material(self) -> Material:
        """The fitted model with its provenance, ready for `brdf.save_material`."""
        provenance = {
            "tool": f"brdf-fitter {importlib.metadata.version('brdf-fitter')}",
            "source": self.data.source,
            "loss": self.loss,
            "max_theta_deg": self.max_theta_deg,
            "samples": self.samples,
            "dropped": self.dropped,
            "errors": self.errors,
            "standard_errors": self.standard_errors(),
            "status": self.status,
        }
        return Material(self.brdf, provenance)

    def standard_errors(self) -> dict[str, float | None]:
        """Standard error of each free element, such as `"ggx.alpha"` or `"ggx.f0.r"`; None where there is none."""
        errors = self.certainty.standard_errors
        labels = self.unknowns.element_labels
        return {label: float(e) if math.isfinite(e) else None for label, e in zip(labels, errors, strict=True)}

    def at_bound(self) -> list[str]:
        """The free elements that ended at a bound."""
        labels = self.unknowns.element_labels
        return [label for label, stuck in zip(labels, self.certainty.at_bound, strict=True) if stuck]

    def correlations(self, above: float = _CORRELATION_SHOWN) -> list[tuple[str, str, float]]:
        """Pairs of free elements whose correlation is larger than `above` in magnitude, strongest first."""
        labels, matrix = self.unknowns.element_labels, self.certainty.correlations
        pairs = [(labels[i], labels[j], float(matrix[i, j])) for i in range(len(labels)) for j in range(i)]
        pairs = [pair for pair in pairs if math.isfinite(pair[2]) and abs(pair[2]) > above]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))

    def to_dict(self) -> dict[str, Any]:
        """The result as one JSON object."""
        return {
            "material": self.material.to_dict(),
            "errors": self.errors,
            "status": self.status,
            "seconds": self.seconds,
            "samples": self.samples,
            "dropped": self.dropped,
            "clamped": self.data.clamped,
            "converged": self.converged,
            "steps": self.steps,
            "standard_errors": self.standard_errors(),
            "at_bound": self.at_bound(),
            "correlations": [list(pair) for pair in self.correlations()],
        }

    def report(self) -> str:
        """The result for reading: statistics, parameters with standard errors, correlations, warnings."""
        lines = [
            f"[[Fit of {expression_of(self.brdf)}]]",
            f"    data          {self.data.source}",
            f"    samples       {self.samples} used, {sum(self.dropped.values())} left out{_reasons(self.dropped)}",
            f"    loss          {self.loss}, theta < {self.max_theta_deg:g} deg",
            f"    status        {self.status}",
            f"    log error     mean {self.errors['log_mae']:.5f}, rms {self.errors['log_rms']:.5f}"
            "  (of log(1 + f cos_i); 0.01 is about 1 % where f is large)",
            f"    time          {self.seconds:.2f} s",
            "[[Parameters]]",
            *self._parameter_lines(),
        ]
        strong = self.correlations()
        if strong:
            lines.append(f"[[Correlations]] (above {_CORRELATION_SHOWN:g} in magnitude; the strongest 10)")
            width = max(len(f"{a}, {b}") for a, b, _ in strong[:10])
            lines += [f"    {f'{a}, {b}':{width}}  {rho:+.3f}" for a, b, rho in strong[:10]]
        warnings = self.warnings()
        if warnings:
            lines.append("[[Notes]]")
            lines += [f"    {warning}" for warning in warnings]
        return "\n".join(lines)

    def _parameter_lines(self) -> list[str]:
        unknowns = self.unknowns
        free = dict(zip(unknowns.element_labels, self.certainty.standard_errors, strict=True))
        initial = _elements(self.initial)
        stuck = set(self.at_bound())
        lines = []
        elements = _elements(self.brdf)
        width = max(len(label) for label in elements)
        for label, value in elements.items():
            line = f"    {label:{width}}  {_digits(value):<12}"
            if isinstance(value, str):
                line += "(choice)"
            elif label not in free:
                line += "(fixed)"
            elif label in stuck:
                line += f"(at its bound)          (init = {initial[label]:.4g})"
            elif not math.isfinite(free[label]):
                line += f"(not determined)        (init = {initial[label]:.4g})"
            else:
                percent = f"{100 * free[label] / abs(value):.2f} %" if value else "-"
                line += f"+/- {free[label]:<9.3g} ({percent:>8})  (init = {initial[label]:.4g})"
            lines.append(line)
        return lines

    def warnings(self) -> list[str]:
        """What a user should know before trusting the numbers, one sentence each."""
        notes = [
            "Standard errors take the samples as independent. Where the model misses the shape of the data, as the log "
            "error shows, the true uncertainty is larger."
        ]
        if self.errors["log_mae"] > _MISFIT_WARNED:
            notes.insert(0, _misfit(self.errors["log_mae"]))
        if (
            np.degrees(np.arccos(np.clip(min(self.data.wi[:, 2].min(), self.data.wo[:, 2].min()), -1, 1)))
            < _RADIANS_DEG
        ):
            notes.insert(0, f"All polar angles are below {_RADIANS_DEG} degrees: were they given in radians?")
        if 3 * self.samples <= self.unknowns.size:
            notes.append(f"{self.samples} samples are too few for {self.unknowns.size} free numbers and their errors.")
        if self.at_bound():
            notes.append(f"At a bound: {', '.join(self.at_bound())}. Their standard errors are not defined.")
        for a, b, rho in self.correlations(_CORRELATION_WARNED)[:_CORRELATIONS_WARNED_MAX]:
            notes.append(f"{a} and {b} trade off against each other ({rho:+.3f}): fix one of them to pin the other.")
        free = int(np.sum(~self.certainty.at_bound))
        if self.certainty.rank < free:
            notes.append(f"The data determine only {self.certainty.rank} of {free} free numbers. Fix some of them.")
        if self.data.clamped:
            notes.append(f"{self.data.clamped} negative channel values were set to 0 for the fit.")
        return notes


def _misfit(log_mae: float) -> str:
    if log_mae > _UNITS_WARNED:
        return (
            f"THE MODEL MISSES THE DATA (mean log error {log_mae:.2f}). Check the data's units: 1/sr, without cosine."
        )
    return (
        f"The model misses the data: {log_mae:.2f} is about {100 * math.expm1(log_mae):.0f} % where f is large. "
        "Look at the --plot, and try another model or one more lobe."
    )


def _reasons(dropped: dict[str, int]) -> str:
    return " (" + ", ".join(f"{reason}: {count}" for reason, count in dropped.items()) + ")" if dropped else ""


def _elements(model: AbstractBRDF) -> dict[str, Any]:
    """Every number and choice of a model by label, such as `"ggx.f0.r"`, in the order of the declaration."""
    found: dict[str, Any] = {}
    for lobe, values in Material(model).to_dict()["parameters"].items():
        for name, value in values.items():
            if isinstance(value, list):
                found |= {f"{lobe}.{name}.{channel}": x for channel, x in zip("rgb", value, strict=True)}
            else:
                found[f"{lobe}.{name}"] = value
    return found


def _digits(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"
