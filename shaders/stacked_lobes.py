"""The search for round lobes in the plane of incidence, which are added one by one.

Given widths and tilts, the amplitudes are the solution of a non-negative least-squares problem (`round_samples`);
widths and tilts are searched by Levenberg-Marquardt around that solution (Golub, Pereyra 1973, "The Differentiation of
Pseudo-Inverses and Nonlinear Least Squares Problems Whose Variables Separate").
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from .kernel import POWERS, round_values
from .round_samples import Array, Samples
from .round_shape import MIRRORED, NOTHING, TILT_COEFFICIENTS, WIDTHS, Shape, tan2_half

_WIDTH_MIN, _WIDTH_MAX = 1.5e-3, 1.4
_TILT_MAX = 2.0
# Where a new lobe may begin: at the mirror direction, or leaning to the viewer, if it is wide.
_PLACES = (MIRRORED, -MIRRORED)
_RETRO_WIDTH_MIN = 0.25
# Steps of the search for one lobe, two, three.
_STEPS = (6, 8, 20)
_DIFFERENCE = 1e-3
# Of the mean square of what amplitudes can follow, so that two lobes in one place do not make it singular.
_RIDGE = 1e-10
# How much a lobe counts that is away from the mirror direction by its width: else a faint one may lie anywhere, and the
# sun shines twice. Less towards the rim, where highlights do lean away from there.
_ASTRAY = 0.02
# Another lobe must make the sum of squares smaller by this part. None is added below this misfit, by how many there are
# already: what it would mend is hardly seen, and each costs a look-up.
_GAIN = 0.3
_GOOD = (0.0, 0.06, 0.13)


def stacked_lobes(samples: Samples, at_horizon: Array, cost: float) -> Shape:
    """The best of all widths and powers, then all searched; again for each lobe that makes enough of a difference.

    **Arguments:** `at_horizon`: shape (v, c, m), of the kernels that end at the horizon; `cost`: with those alone.
    """
    shape = NOTHING
    candidates = _Candidates(samples)
    for count, steps in enumerate(_STEPS):
        if cost < _GOOD[count] ** 2:
            break
        known = np.concatenate([shape.columns(samples), at_horizon], axis=-1) if count else at_horizon
        tilt, power, width = candidates.best(known)
        grown = Shape(
            np.append(shape.power, power),
            np.append(shape.log_width, math.log(width)),
            np.concatenate([shape.tilt, tilt[None]]),
            np.zeros(count + 1),
        )
        grown, new_cost = _search(samples, at_horizon, grown, steps)
        if new_cost > (1 - _GAIN) * cost:
            break
        shape, cost = grown, new_cost
    return shape


class _Candidates:
    """Lobes of all powers and widths at the mirror direction, and wide ones towards the viewer."""

    def __init__(self, samples: Samples):
        self._samples = samples
        self._distances = [tan2_half(samples, tilt, 0.0) for tilt in _PLACES]
        self._columns: dict[tuple[int, int, int], Array] = {}

    def best(self, known: Array) -> tuple[Array, float, float]:
        """The tilt, power and width that lower the cost most beside known columns: of each second one, and then of
        those around the best of them."""
        powers, widths = range(len(POWERS)), range(len(WIDTHS))
        wide = [j for j in widths if WIDTHS[j] > _RETRO_WIDTH_MIN]
        costs = {(0, i, j): self._cost(0, i, j, known) for i in powers[::2] for j in widths[::2]}
        costs |= {(1, i, j): self._cost(1, i, j, known) for i in powers[::2] for j in wide}
        place, _, middle = min(costs, key=costs.__getitem__)
        near = widths[max(middle - 1, 0) : middle + 2]
        costs |= {(place, i, j): self._cost(place, i, j, known) for i in powers for j in near}
        place, i, j = min(costs, key=costs.__getitem__)
        return _PLACES[place], POWERS[i], float(WIDTHS[j])

    def _cost(self, place: int, i: int, j: int, known: Array) -> float:
        one = place, i, j
        if one not in self._columns:
            values = round_values(self._distances[place], POWERS[i], float(WIDTHS[j]))
            self._columns[one] = self._samples.in_cells(values)
        return self._samples.cost(np.concatenate([self._columns[one][..., None], known], axis=-1))


def _search(samples: Samples, at_horizon: Array, shape: Shape, steps: int) -> tuple[Shape, float]:
    """Levenberg-Marquardt over widths and tilts, the amplitudes always the best ones for them.

    The derivative is that of Kaufman 1975, "A variable projection method for solving separable nonlinear least squares
    problems": with amplitudes held, less what amplitudes above 0 could follow.
    """
    n = len(shape.lean)
    lower = np.concatenate([np.full(n, math.log(_WIDTH_MIN)), np.full(n * TILT_COEFFICIENTS, -_TILT_MAX)])
    upper = np.concatenate([np.full(n, math.log(_WIDTH_MAX)), np.full(n * TILT_COEFFICIENTS, _TILT_MAX)])

    def solved(p: Array) -> _Solution:
        trial = Shape(shape.power, p[:n], p[n:].reshape(n, TILT_COEFFICIENTS), shape.lean)
        return _solve(samples, at_horizon, trial)

    p = np.concatenate([shape.log_width, shape.tilt.ravel()])
    now, damping = solved(p), 1e-2
    for _ in range(steps):
        jacobian = _derivative(samples, now)
        hessian, gradient = jacobian.T @ jacobian, jacobian.T @ now.error
        before = now.cost
        for _ in range(4):
            scaled = hessian + damping * np.diag(np.diag(hessian) + 1e-9)
            trial = np.clip(p - np.linalg.solve(scaled, gradient), lower, upper)
            found = solved(trial)
            if found.cost < before:
                p, now, damping = trial, found, 0.3 * damping
                break
            damping *= 10
        if now.cost > 0.998 * before:
            break
    return now.shape, samples.cost(now.columns)


@dataclasses.dataclass(frozen=True, eq=False)
class _Solution:
    """A shape with its best amplitudes: `columns` (v, c, n + 2), `coefficients` (n + 2, b), `error` (v c + v n,)."""

    shape: Shape
    columns: Array
    coefficients: Array
    error: Array

    @property
    def cost(self) -> float:
        return float(self.error @ self.error)


def _solve(samples: Samples, at_horizon: Array, shape: Shape) -> _Solution:
    columns = np.concatenate([shape.columns(samples), at_horizon], axis=-1)
    coefficients = samples.mean_amplitudes(columns)
    error = np.concatenate([samples.error(columns, coefficients), _astray(samples, shape).ravel()])
    return _Solution(shape, columns, coefficients, error)


def _astray(samples: Samples, shape: Shape) -> Array:
    """How far lobes lie from the mirror direction, in units of their widths, shape (v, n)."""
    tilt = (samples.wo[:, 2:] ** np.arange(TILT_COEFFICIENTS)) @ shape.tilt.T
    return _astray_per_tilt(samples, shape) * (tilt - 1)


def _astray_per_tilt(samples: Samples, shape: Shape) -> Array:
    cos_o = samples.wo[:, 2:]
    weight = _ASTRAY * np.sqrt(samples.area)[:, None] * cos_o**2 * np.sqrt(1 - cos_o**2)
    return weight / np.exp(shape.log_width)


def _derivative(samples: Samples, now: _Solution) -> Array:
    """The derivative of the error by widths and then by the tilts' coefficients, shape (v c + v n, 4 n)."""
    n = len(now.shape.lean)
    amplitude, root = samples.basis @ now.coefficients.T, np.sqrt(samples.importance)
    by_width, by_tilt = [], []
    # A tilt's coefficients differ by powers of the viewer's cosine.
    powers = samples.wo[:, 2:, None] ** np.arange(TILT_COEFFICIENTS)
    for i in range(n):
        wider = dataclasses.replace(now.shape, log_width=now.shape.log_width + _DIFFERENCE).column(samples, i)
        tilted = dataclasses.replace(now.shape, tilt=now.shape.tilt + _DIFFERENCE * MIRRORED).column(samples, i)
        weight = amplitude[:, i, None] * root / _DIFFERENCE
        by_width.append((wider - now.columns[..., i]) * weight)
        by_tilt.append(((tilted - now.columns[..., i]) * weight)[..., None] * powers)
    tilts = np.concatenate(by_tilt, axis=-1).reshape(-1, n * TILT_COEFFICIENTS)
    jacobian = np.concatenate([np.stack(by_width, axis=-1).reshape(-1, n), tilts], axis=1)
    free = np.argwhere(now.coefficients > 0)
    followed = now.columns[..., free[:, 0]] * samples.basis[:, None, free[:, 1]] * root[..., None]
    followed = followed.reshape(len(jacobian), -1)
    # Normal equations, eight times as fast as an orthogonal basis; the search needs no more digits of its direction.
    gram = followed.T @ followed
    gram += _RIDGE * np.trace(gram) / max(len(free), 1) * np.eye(len(free))
    jacobian -= followed @ np.linalg.solve(gram, followed.T @ jacobian)
    return np.concatenate([jacobian, _astray_derivative(samples, now.shape)])


def _astray_derivative(samples: Samples, shape: Shape) -> Array:
    """The derivative of `_astray`, shape (v n, 4 n)."""
    v, n = len(samples.wo), len(shape.lean)
    own = np.eye(n)
    by_width = -_astray(samples, shape)[:, :, None] * own
    powers = samples.wo[:, 2:] ** np.arange(TILT_COEFFICIENTS)
    by_tilt = _astray_per_tilt(samples, shape)[:, :, None, None] * own[:, :, None] * powers[:, None, None, :]
    return np.concatenate([by_width, by_tilt.reshape(v, n, -1)], axis=2).reshape(v * n, -1)
