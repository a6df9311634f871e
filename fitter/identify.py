"""How sure a fit is of its parameters.

- Huber 1967, "The behavior of maximum likelihood estimates under nonstandard conditions".
- White 1980, "A Heteroskedasticity-Consistent Covariance Matrix Estimator".
"""

from __future__ import annotations

import dataclasses

import numpy as np

from .unknowns import Unknowns

# Scaled singular values below this share of the largest one belong to directions that the data do not determine.
_RANK_TOLERANCE = 1e-10
# An element with a larger share than this in an undetermined direction is undetermined itself.
_LOOSE = 1e-4
# An element closer to its bound than this share of its range counts as at the bound.
_BOUND_TOLERANCE = 1e-7


@dataclasses.dataclass(frozen=True)
class Certainty:
    """Standard errors and correlations at a solution.

    - `standard_errors`: shape (k,), in the parameters' own units; NaN for elements at a bound or not determined.
    - `correlations`: shape (k, k), by the Hessian alone: how elements can trade off against each other; NaN likewise.
    - `at_bound`: shape (k,), whether each element lies at a bound.
    - `rank`, `condition`: of the scaled Hessian of the elements that are not at a bound.
    """

    standard_errors: np.ndarray
    correlations: np.ndarray
    at_bound: np.ndarray
    rank: int
    condition: float


def certainty(unknowns: Unknowns, y: np.ndarray, hessian: np.ndarray, scores: np.ndarray, samples: int) -> Certainty:
    """Standard errors of the elements that are not at a bound, by the delta method in their own units.

    The covariance is `H^+ S H^+` with the sum S of the products of the samples' gradients (Huber 1967, White 1980):
    right for any loss, weights, and channels that err together. It takes the samples as independent of each other;
    where the model misses the shape of the data they are not, and the true uncertainty is larger.

    **Arguments:**

    - `y`: shape (k,), the solver's vector at the solution.
    - `hessian`, `scores`: shape (k, k), there; see `fitter.normal`.
    - `samples`: how many samples were used.
    """
    lower, upper = unknowns.bounds()
    at_bound = (y - lower <= _BOUND_TOLERANCE * (upper - lower)) | (upper - y <= _BOUND_TOLERANCE * (upper - lower))
    k = len(y)
    free = np.flatnonzero(~at_bound)
    errors, correlations = np.full(k, np.nan), np.full((k, k), np.nan)
    if free.size == 0:
        return Certainty(errors, correlations, at_bound, 0, 1.0)
    hessian, scores = hessian[np.ix_(free, free)], scores[np.ix_(free, free)]
    root = np.sqrt(np.maximum(np.diagonal(hessian), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(hessian / root[:, None] / root[None, :])
    determined = values > _RANK_TOLERANCE * max(values[-1], np.finfo(float).tiny)
    inverse = (vectors[:, determined] / values[determined]) @ vectors[:, determined].T
    # An element with a share in an undetermined direction has no finite error. Neither has any if nothing is left over.
    loose = np.any(np.abs(vectors[:, ~determined]) > _LOOSE, axis=1) | (np.diagonal(hessian) <= 0)
    spare = 3 * samples - free.size
    if spare > 0 and samples > 1:
        covariance = inverse @ (scores / root[:, None] / root[None, :]) @ inverse * (3 * samples / spare)
        deviation = np.sqrt(np.maximum(np.diagonal(covariance), 0))
        errors[free] = np.where(loose, np.nan, deviation / root * unknowns.scale(y)[free])
    known = np.flatnonzero(~loose)
    spread = np.sqrt(np.diagonal(inverse)[known])
    pairs = inverse[np.ix_(known, known)] / spread[:, None] / spread[None, :]
    correlations[np.ix_(free[known], free[known])] = pairs
    rank = int(determined.sum())
    return Certainty(errors, correlations, at_bound, rank, float(values[-1] / max(values[0], 1e-300)))
