"""What a fit gives back: the material, how sure it is, and a report to read."""

from __future__ import annotations

import dataclasses
import functools
import importlib.metadata
import math
from collections.abc import Mapping
from typing import Any

from brdf.material import Material
from brdf.model import AbstractBRDF

from .advice import Advice
from .identify import Certainty
from .judge import Judgement, judge
from .quality import Finding
from .reflectance import Reflectance
from .report import CORRELATION_SHOWN, notes, report
from .unknowns import Unknowns


@dataclasses.dataclass(frozen=True)
class FitResult:
    """The outcome of `fitter.fit`.

    - `brdf`: the fitted model; `material` is the same with its provenance.
    - `initial`: the model at the start that was chosen.
    - `unknowns`, `certainty`: what was free, and standard errors and correlations of it.
    - `errors`: `log_mae` and `log_rms`, the unweighted mean absolute and root mean square of
      |log(1 + f cos_i) - log(1 + y cos_i)| over the samples used; `cost`, what the loss adds up to.
    - `converged`, `status`, `steps`: how the solver ended, as a sentence, and after how many steps.
    - `passes`: what the fit cost, in passes over all samples.
    - `seconds`: wall time of the whole fit, compilation included.
    - `data`: the samples that were used; its `dropped` counts the others.
    - `loss`, `weights`, `max_theta_deg`: as given.
    - `findings`: what is remarkable about the measurement itself, see `fitter.quality`.
    - `advice`: what to measure next, if it was asked for.
    - `looks`: loss -> mean Delta E ITP of its fit, where the loss was chosen by that.
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
    findings: tuple[Finding, ...] = ()
    advice: list[Advice] | None = None
    looks: Mapping[str, float] | None = None

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
            "weights": self.weights,
            "max_theta_deg": self.max_theta_deg,
            "samples": self.samples,
            "dropped": self.dropped,
            "errors": self.errors,
            "standard_errors": self.standard_errors(),
            "status": self.status,
        }
        return Material(self.brdf, provenance)

    @functools.cached_property
    def judgement(self) -> Judgement:
        """How different the fit looks from the measurement (Delta E ITP), see `fitter.judge`."""
        return judge(self.brdf, self.data)

    def intervals(self) -> dict[str, list[float] | None]:
        """The 95 % interval of each free element; None where there is none."""
        labels = self.unknowns.element_labels
        rows = zip(labels, self.certainty.intervals.tolist(), strict=True)
        return {label: row if all(map(math.isfinite, row)) else None for label, row in rows}

    def standard_errors(self) -> dict[str, float | None]:
        """Standard error of each free element, such as `"ggx.alpha"` or `"ggx.f0.r"`; None where there is none."""
        errors = self.certainty.standard_errors
        labels = self.unknowns.element_labels
        return {label: float(e) if math.isfinite(e) else None for label, e in zip(labels, errors, strict=True)}

    def at_bound(self) -> list[str]:
        """The free elements that ended at a bound and have an effect there."""
        rows = zip(self.unknowns.element_labels, self.certainty.at_bound & ~self.certainty.idle, strict=True)
        return [label for label, stuck in rows if stuck]

    def correlations(self, above: float = CORRELATION_SHOWN) -> list[tuple[str, str, float]]:
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
            "passes": self.passes,
            "delta_e_itp": self.judgement.to_dict(),
            "standard_errors": self.standard_errors(),
            "intervals_95": self.intervals(),
            "errors_from": "bootstrap over incident angles" if self.certainty.inflation > 1 else "independent samples",
            "at_bound": self.at_bound(),
            "correlations": [list(pair) for pair in self.correlations()],
            "singular_values": self.certainty.singular_values.tolist(),
            "freedoms": [list(labels) for labels in self.certainty.freedoms],
            "held": {".".join(place): list(values) for place, values in self.unknowns.held},
            "looks": None if self.looks is None else dict(self.looks),
            "advice": None if self.advice is None else [advice.sentence() for advice in self.advice],
            "notes": notes(self),
        }

    def report(self) -> str:
        """The result for reading: statistics, parameters with errors, what the data leave open, notes."""
        return report(self)
