"""How sure a fit is of its parameters."""

from __future__ import annotations

import dataclasses

import numpy as np

from .normal import NormalEquations
from .unknowns import Unknowns

# Scaled singular values below this share of the largest one belong to directions that the data do not determine.
_RANK_TOLERANCE = 1e-10
# An element closer to its bound than this share of its range counts as at the bound.
_BOUND_TOLERANCE = 1e-7


@dataclasses.dataclass(frozen=True)
class Certainty:
    """Standard errors and correlations at a solution.

    - `standard_errors`: shape (k,), in the parameters' own units; NaN for elements at a bound or not determined.
    - `correlations`: shape (k, k); NaN likewise.
    - `at_bound`: shape (k,), whether each element lies at a bound.
    - `rank`, `condition`: of the scaled Hessian of the elements that are not at a bound.
    """

    standard_errors: np.ndarray
    correlations: np.ndarray
    at_bound: np.ndarray
    rank: int
    condition: float


def certainty(unknowns: Unknowns, y: np.ndarray, equations: NormalEquations, residuals: int) -> Certainty:
    """Standard errors `s^2 (J^T J)^+` of the elements that are not at a bound, by the delta method in their own units.

    They hold for independent errors of measurement. Where the model does not fit, the misfit is what they measure.

    **Arguments:**

    - `y`: the solver's vector at the solution, and `equations` there.
    - `residuals`: how many residuals were used.
    """
    lower, upper = unknowns.bounds()
    at_bound = (y - lower <= _BOUND_TOLERANCE * (upper - lower)) | (upper - y <= _BOUND_TOLERANCE * (upper - lower))
    k = len(y)
    free = np.flatnonzero(~at_bound)
    errors, correlations = np.full(k, np.nan), np.full((k, k), np.nan)
    if free.size == 0:
        return Certainty(errors, correlations, at_bound, 0, 1.0)
    hessian = np.asarray(equations.hessian)[np.ix_(free, free)]
    root = np.sqrt(np.maximum(np.diagonal(hessian), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(hessian / root[:, None] / root[None, :])
    determined = values > _RANK_TOLERANCE * values[-1]
    inverse = (vectors[:, determined] / values[determined]) @ vectors[:, determined].T
    # An element with a share in an undetermined direction has no finite error.
    loose = np.any(np.abs(vectors[:, ~determined]) > 1e-4, axis=1) | (np.diagonal(hessian) <= 0)
    variance = 2 * float(equations.cost) / max(residuals - free.size, 1)
    deviation = np.sqrt(np.maximum(np.diagonal(inverse), 0) * variance) / root
    errors[free] = np.where(loose, np.nan, deviation * unknowns.scale(y)[free])
    spread = np.sqrt(np.maximum(np.diagonal(inverse), np.finfo(float).tiny))
    correlations[np.ix_(free, free)] = inverse / spread[:, None] / spread[None, :]
    rank = int(determined.sum())
    return Certainty(errors, correlations, at_bound, rank, float(values[-1] / max(values[0], 1e-300)))
