"""How sure a fit is of its parameters, and which of them the data cannot tell apart.

- Huber 1967, "The behavior of maximum likelihood estimates under nonstandard conditions".
- White 1980, "A Heteroskedasticity-Consistent Covariance Matrix Estimator".
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Bool, Float

from .unknowns import Unknowns

# Scaled singular values below this share of the largest one belong to directions that the data do not determine.
_RANK_TOLERANCE = 1e-10
# An element with a larger share than this in an undetermined direction is undetermined itself.
_LOOSE = 1e-4
# One with a larger share than this is named when the direction is described.
_NAMED = 0.05
# An element closer to its bound than this share of its range counts as at the bound.
_BOUND_TOLERANCE = 1e-7
# Two-sided 95 % of a normal distribution.
NORMAL_95 = 1.959964


@dataclasses.dataclass(frozen=True)
class Certainty:
    """Standard errors and correlations at a solution.

    - `standard_errors`: shape (k,), in the parameters' own units; NaN for elements at a bound or not determined.
    - `intervals`: shape (k, 2), 95 %, in the parameters' own units; NaN likewise, but for elements at a bound from the
      bound to as far as the profile of the cost allows.
    - `correlations`: shape (k, k), by the Hessian alone: how elements can trade off against each other; NaN likewise.
    - `at_bound`: shape (k,), whether each element lies at a bound.
    - `idle`: shape (k,), whether an element has no effect at all at the solution, wherever it lies.
    - `singular_values`: of the scaled Jacobian of the elements that are neither, descending, the largest 1.
    - `rank`, `condition`: how many of them count, and the largest over the smallest.
    - `freedoms`: for each direction that the data do not determine, the labels of the elements that trade off along it.
    - `inflation`: how much more the solution scatters than with samples that err independently; 1 where they do. Above
      1, standard errors and intervals are those of the bootstrap over incident angles (`fitter.bootstrap`).
    """

    standard_errors: Float[np.ndarray, " k"]
    intervals: Float[np.ndarray, "k 2"]
    correlations: Float[np.ndarray, "k k"]
    at_bound: Bool[np.ndarray, " k"]
    idle: Bool[np.ndarray, " k"]
    singular_values: Float[np.ndarray, " m"]
    rank: int
    condition: float
    freedoms: tuple[tuple[str, ...], ...]
    inflation: float = 1.0


def at_bounds(unknowns: Unknowns, y: Float[np.ndarray, " k"]) -> Bool[np.ndarray, " k"]:
    """Which elements of a solution lie at a bound."""
    lower, upper = unknowns.bounds()
    near = _BOUND_TOLERANCE * (upper - lower)
    return (y - lower <= near) | (upper - y <= near)


def certainty(
    unknowns: Unknowns,
    y: Float[np.ndarray, " k"],
    hessian: Float[np.ndarray, "k k"],
    scores: Float[np.ndarray, "k k"],
    samples: int,
) -> Certainty:
    """Standard errors of the elements that are not at a bound, by the delta method in their own units.

    The covariance is `H^+ S H^+` with the sum S of the products of the samples' gradients (Huber 1967, White 1980):
    right for any loss, weights, and channels that err together. It takes the samples as independent of each other;
    where the model misses the shape of the data they are not, see `fitter.bootstrap`.

    **Arguments:**

    - `y`: the solver's vector at the solution.
    - `hessian`, `scores`: there; see `fitter.normal`.
    - `samples`: how many samples were used.
    """
    k = len(y)
    stuck = at_bounds(unknowns, y)
    idle = np.diagonal(hessian) <= 0
    free = np.flatnonzero(~stuck & ~idle)
    errors, correlations = np.full(k, np.nan), np.full((k, k), np.nan)
    if free.size == 0:
        blank = np.full((k, 2), np.nan)
        return Certainty(errors, blank, correlations, stuck, idle, np.zeros(0), 0, 1.0, ())
    hessian, scores = hessian[np.ix_(free, free)], scores[np.ix_(free, free)]
    root = np.sqrt(np.diagonal(hessian))
    values, vectors = np.linalg.eigh(hessian / root[:, None] / root[None, :])
    determined = values > _RANK_TOLERANCE * values[-1]
    inverse = (vectors[:, determined] / values[determined]) @ vectors[:, determined].T
    # An element with a share in an undetermined direction has no finite error. Neither has any if nothing is left over.
    loose = np.any(np.abs(vectors[:, ~determined]) > _LOOSE, axis=1)
    spare = 3 * samples - free.size
    if spare > 0 and samples > 1:
        covariance = inverse @ (scores / root[:, None] / root[None, :]) @ inverse * (3 * samples / spare)
        deviation = np.sqrt(np.maximum(np.diagonal(covariance), 0))
        errors[free] = np.where(loose, np.nan, deviation / root * unknowns.scale(y)[free])
    known = np.flatnonzero(~loose)
    spread = np.sqrt(np.diagonal(inverse)[known])
    pairs = inverse[np.ix_(known, known)] / spread[:, None] / spread[None, :]
    correlations[np.ix_(free[known], free[known])] = pairs
    middle = unknowns.values(y)
    labels = np.array(unknowns.element_labels)[free]
    return Certainty(
        standard_errors=errors,
        intervals=np.stack([middle - NORMAL_95 * errors, middle + NORMAL_95 * errors], axis=1),
        correlations=correlations,
        at_bound=stuck,
        idle=idle,
        singular_values=np.sqrt(np.maximum(values[::-1], 0) / values[-1]),
        rank=int(determined.sum()),
        condition=float(np.sqrt(values[-1] / max(values[0], 1e-300))),
        freedoms=tuple(tuple(labels[np.abs(vector) > _NAMED].tolist()) for vector in vectors[:, ~determined].T),
    )
