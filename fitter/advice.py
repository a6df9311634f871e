"""What to measure next: the scans that would tell most about what a fit leaves uncertain."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float

from .evaluation import values
from .identify import Certainty
from .minimise import Problem
from .samples import arrange_directions

# Scans that are considered: outgoing directions along an arc, in and across the plane of incidence, at these angles.
_INCIDENT_DEG = (5, 20, 35, 50, 60, 70, 75, 80)
_ARCS = {"in": 0.0, "across": 90.0}
_OUTGOING_DEG = np.linspace(-80, 80, 161)
# Of as many samples as this share of the measurement.
_SHARE = 0.05
_SHOWN = 3
# What an element's error must fall by to be worth a sentence.
_WORTH = 0.05


@dataclasses.dataclass(frozen=True)
class Advice:
    """One scan and what it would do.

    - `theta_i_deg`, `arc`: the incident angle, and whether the scan lies `in` or `across` the plane of incidence.
    - `label`: the element that gains most; `factor`: its new standard error over the old one, 0 if it has none now.
    """

    theta_i_deg: float
    arc: str
    label: str
    factor: float

    def sentence(self) -> str:
        """The advice for reading."""
        gain = "would determine it" if self.factor == 0 else f"lowers its standard error by {1 - self.factor:.0%}"
        return f"{self.label}: a scan {self.arc} the plane of incidence at theta_i = {self.theta_i_deg:g} deg {gain}."


def advise(
    problem: Problem, y: Float[np.ndarray, " k"], hessian: Float[np.ndarray, "k k"], sure: Certainty
) -> list[Advice]:
    """The scans that lower the standard error of single elements most, the best first.

    It takes the errors of the new samples to be those of the old ones, and each scan to have a twentieth of their
    number.

    **Arguments:**

    - `y`, `hessian`, `sure`: the solution, the Hessian of all samples there, and what is known of it.
    """
    free = np.flatnonzero(~sure.at_bound & ~sure.idle)
    if free.size == 0:
        return []
    scans = [(theta, arc) for theta in _INCIDENT_DEG for arc in _ARCS]
    wi, wo = zip(*(_scan(theta, _ARCS[arc]) for theta, arc in scans), strict=True)
    wi, wo = np.stack(wi), np.stack(wo)
    model = problem.unknowns.settled(y, sure.at_bound)
    value = values(model, wi.reshape(-1, 3), wo.reshape(-1, 3)).reshape(wi.shape)
    samples = arrange_directions(wi, wo, value)
    weight = _SHARE * len(problem.arranged.rows) / problem.arranged.share / wi.shape[1]
    before = _deviations(hessian[np.ix_(free, free)])
    labels = np.array(problem.unknowns.element_labels)[free]
    found = []
    for place, (theta, arc) in enumerate(scans):
        added = problem.assess_samples(y, samples, place, 1).equations.hessian
        after = _deviations((hessian + weight * np.asarray(added))[np.ix_(free, free)])
        factor = np.where(np.isfinite(before), after / np.where(np.isfinite(before), before, 1.0), 0.0)
        factor = np.where(np.isfinite(after), factor, 1.0)
        best = int(np.argmin(factor))
        if factor[best] < 1 - _WORTH:
            found.append(Advice(float(theta), arc, str(labels[best]), float(factor[best])))
    return sorted(found, key=lambda one: one.factor)[:_SHOWN]


def _scan(theta_i_deg: float, azimuth_deg: float) -> tuple[np.ndarray, np.ndarray]:
    theta_i, theta_o, phi = np.radians(theta_i_deg), np.radians(_OUTGOING_DEG), np.radians(azimuth_deg)
    wi = np.broadcast_to([-np.sin(theta_i), 0.0, np.cos(theta_i)], (theta_o.size, 3))
    wo = np.stack([np.sin(theta_o) * np.cos(phi), np.sin(theta_o) * np.sin(phi), np.cos(theta_o)], axis=-1)
    return wi, wo


def _deviations(hessian: Float[np.ndarray, "k k"]) -> Float[np.ndarray, " k"]:
    """Standard errors up to a common factor; infinite where the Hessian does not determine an element."""
    root = np.sqrt(np.maximum(np.diagonal(hessian), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(hessian / root[:, None] / root[None, :])
    loose = values <= 1e-10 * values[-1]
    inverse = np.where(loose, 0.0, 1 / np.where(loose, 1.0, values))
    deviation = np.sqrt((vectors**2) @ inverse) / root
    return np.where((np.abs(vectors[:, loose]) > 1e-4).any(axis=1), np.inf, deviation)
