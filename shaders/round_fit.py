"""The search for a material's round lobes; `round_lobes` says what they are.

Given widths and tilts, the amplitudes are the solution of a non-negative least-squares problem (`round_samples`);
widths and tilts are searched by Levenberg-Marquardt around that solution (Golub, Pereyra 1973, "The Differentiation of
Pseudo-Inverses and Nonlinear Least Squares Problems Whose Variables Separate"). Lobes are added one by one, as long as
the next one makes enough of a difference.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .kernel import COSINE, POWERS, SATURATED, Kernel, nearest_kernel, round_values
from .round_samples import Array, Evaluate, Samples, sample_material

_WIDTH_MIN, _WIDTH_MAX = 1.5e-3, 1.4
# Widths that are tried for a new lobe.
_WIDTHS = np.geomspace(3e-3, 1.2, 14)
# The coefficients of a tilt, and its range.
_TILT_COEFFICIENTS = 3
_TILT_MAX = 2.0
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
_GOOD = (0.02, 0.06, 0.13)
# Lobes that never reflect this part of what the strongest does are left out, by whether they lie side by side, where
# each has a part of one highlight.
_SHARE_MIN = {False: 0.05, True: 0.01}
# A brushed material's lobes: how far apart they lie along the wide direction at most, in units of their width, so that
# a lamp's image is a streak and not a row of lamps; and how many there are.
_APART = 1.3
_BRUSHED_MIN, _BRUSHED_MAX = 5, 13
# Of the farthest ones in units of a spread that is searched.
_REACH = 1.6
_ENDING_AT_HORIZON = (COSINE, SATURATED)


@dataclasses.dataclass(frozen=True, eq=False)
class RoundFit:
    """What was found; see `RoundLobes`, but `amplitude`, (n, b, 3), holds coefficients of `Samples.basis`."""

    kernels: tuple[Kernel, ...]
    tilt: Array
    lean: Array
    amplitude: Array
    azimuth: float


@dataclasses.dataclass(frozen=True, eq=False)
class _Shape:
    """Round kernels and where they lie: `power` (n,), `log_width` (n,), `tilt` (n, 3), `lean` (n,)."""

    power: Array
    log_width: Array
    tilt: Array
    lean: Array

    def columns(self, samples: Samples) -> Array:
        """What they weigh each cell by, shape (v, c, n)."""
        return np.stack([self.column(samples, i) for i in range(len(self.lean))], axis=-1)

    def column(self, samples: Samples, i: int) -> Array:
        x = _tan2_half(samples, self.tilt[i], self.lean[i])
        return samples.in_cells(round_values(x, float(self.power[i]), math.exp(self.log_width[i])))


_NOTHING = _Shape(np.zeros(0), np.zeros(0), np.zeros((0, _TILT_COEFFICIENTS)), np.zeros(0))
# Of the mirror direction.
_MIRRORED = np.array([1.0, 0.0, 0.0])


def fit_lobes(evaluate: Evaluate, is_anisotropic: bool) -> RoundFit:
    """The round lobes of a material; the arguments are those of `sample_material`."""
    samples = sample_material(evaluate, is_anisotropic)
    at_horizon = np.stack([_at_horizon(samples, kernel) for kernel in _ENDING_AT_HORIZON], axis=-1)
    cost = samples.cost(at_horizon)
    shape = _NOTHING
    if cost > _GOOD[0] ** 2:
        shape = (_brushed if is_anisotropic else _stacked)(samples, at_horizon, cost)
    round_kernels = [nearest_kernel(float(p), math.exp(w)) for p, w in zip(shape.power, shape.log_width, strict=True)]
    kernels = (*round_kernels, *_ENDING_AT_HORIZON)
    none = np.zeros(len(_ENDING_AT_HORIZON))
    tilt = np.concatenate([shape.tilt, np.zeros((len(none), _TILT_COEFFICIENTS))])
    lean = np.concatenate([shape.lean, none])
    return _with_colors(samples, kernels, tilt, lean, _SHARE_MIN[is_anisotropic])


def _stacked(samples: Samples, at_horizon: Array, cost: float) -> _Shape:
    """Lobes in the plane of incidence, one after the other: the best of all widths and powers, then all searched."""
    shape = _NOTHING
    candidates = _Candidates(samples)
    for count, steps in enumerate(_STEPS):
        if cost < _GOOD[count] ** 2:
            break
        known = np.concatenate([shape.columns(samples), at_horizon], axis=-1) if count else at_horizon
        power, width = candidates.best(known)
        grown = _Shape(
            np.append(shape.power, power),
            np.append(shape.log_width, math.log(width)),
            np.concatenate([shape.tilt, _MIRRORED[None]]),
            np.zeros(count + 1),
        )
        grown, new_cost = _search(samples, at_horizon, grown, steps)
        if new_cost > (1 - _GAIN) * cost:
            break
        shape, cost = grown, new_cost
    return shape


class _Candidates:
    """Lobes of all powers and widths at the mirror direction."""

    def __init__(self, samples: Samples):
        self._samples = samples
        self._mirrored = _tan2_half(samples, _MIRRORED, 0.0)
        self._columns: dict[tuple[int, int], Array] = {}

    def best(self, known: Array) -> tuple[float, float]:
        """The power and width that lower the cost most beside known columns: of each second one, and then of those
        around the best of them."""
        powers, widths = range(len(POWERS)), range(len(_WIDTHS))
        costs = {(i, j): self._cost(i, j, known) for i in powers[::2] for j in widths[::2]}
        _, middle = min(costs, key=costs.__getitem__)
        near = widths[max(middle - 1, 0) : middle + 2]
        costs |= {(i, j): self._cost(i, j, known) for i in powers for j in near if (i, j) not in costs}
        i, j = min(costs, key=costs.__getitem__)
        return POWERS[i], float(_WIDTHS[j])

    def _cost(self, i: int, j: int, known: Array) -> float:
        if (i, j) not in self._columns:
            values = round_values(self._mirrored, POWERS[i], float(_WIDTHS[j]))
            self._columns[i, j] = self._samples.in_cells(values)
        return self._samples.cost(np.concatenate([self._columns[i, j][..., None], known], axis=-1))


def _brushed(samples: Samples, at_horizon: Array, cost: float) -> _Shape:
    """Lobes of one width side by side: the best of each second width, and then of those around it and of all powers."""
    costs: dict[tuple[float, int, int], float] = {}
    spreads = range(2, len(_WIDTHS), 2)

    def look(powers: Sequence[float], widths: Sequence[int]) -> tuple[float, int, int]:
        for one in itertools.product(powers, widths, spreads):
            shape = _row(*one)
            if shape is not None and one not in costs:
                costs[one] = samples.cost(np.concatenate([shape.columns(samples), at_horizon], axis=-1))
        return min(costs, key=costs.__getitem__)

    _, middle, _ = look([math.inf], spreads)
    best = look([2.0, math.inf], range(middle - 1, min(middle + 2, len(_WIDTHS))))
    shape = _row(*best)
    return _NOTHING if shape is None or costs[best] >= cost else shape


def _row(power: float, width: int, spread: int) -> _Shape | None:
    """Lobes of one of `_WIDTHS`, evenly spaced over one of them; None if they are too far apart or all in one place."""
    reach = _REACH * _WIDTHS[spread]
    n = max(2 * math.ceil(reach / (_APART * _WIDTHS[width])) + 1, _BRUSHED_MIN)
    if _WIDTHS[spread] < 0.5 * _WIDTHS[width] or n > _BRUSHED_MAX:
        return None
    tilt, lean = np.tile(_MIRRORED, (n, 1)), np.linspace(-reach, reach, n)
    return _Shape(np.full(n, power), np.full(n, math.log(_WIDTHS[width])), tilt, lean)


def _search(samples: Samples, at_horizon: Array, shape: _Shape, steps: int) -> tuple[_Shape, float]:
    """Levenberg-Marquardt over widths and tilts, the amplitudes always the best ones for them.

    The derivative is that of Kaufman 1975, "A variable projection method for solving separable nonlinear least squares
    problems": with amplitudes held, less what amplitudes above 0 could follow.
    """
    n = len(shape.lean)
    lower = np.concatenate([np.full(n, math.log(_WIDTH_MIN)), np.full(n * _TILT_COEFFICIENTS, -_TILT_MAX)])
    upper = np.concatenate([np.full(n, math.log(_WIDTH_MAX)), np.full(n * _TILT_COEFFICIENTS, _TILT_MAX)])

    def solved(p: Array) -> _Solution:
        trial = _Shape(shape.power, p[:n], p[n:].reshape(n, _TILT_COEFFICIENTS), shape.lean)
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

    shape: _Shape
    columns: Array
    coefficients: Array
    error: Array

    @property
    def cost(self) -> float:
        return float(self.error @ self.error)


def _solve(samples: Samples, at_horizon: Array, shape: _Shape) -> _Solution:
    columns = np.concatenate([shape.columns(samples), at_horizon], axis=-1)
    coefficients = samples.mean_amplitudes(columns)
    error = np.concatenate([samples.error(columns, coefficients), _astray(samples, shape).ravel()])
    return _Solution(shape, columns, coefficients, error)


def _astray(samples: Samples, shape: _Shape) -> Array:
    """How far lobes lie from the mirror direction, in units of their widths, shape (v, n)."""
    tilt = (samples.wo[:, 2:] ** np.arange(_TILT_COEFFICIENTS)) @ shape.tilt.T
    return _astray_per_tilt(samples, shape) * (tilt - 1)


def _astray_per_tilt(samples: Samples, shape: _Shape) -> Array:
    cos_o = samples.wo[:, 2:]
    weight = _ASTRAY * np.sqrt(samples.area)[:, None] * cos_o**2 * np.sqrt(1 - cos_o**2)
    return weight / np.exp(shape.log_width)


def _derivative(samples: Samples, now: _Solution) -> Array:
    """The derivative of the error by widths and then by the tilts' coefficients, shape (v c + v n, 4 n)."""
    n = len(now.shape.lean)
    amplitude, root = samples.basis @ now.coefficients.T, np.sqrt(samples.importance)
    by_width, by_tilt = [], []
    # A tilt's coefficients differ by powers of the viewer's cosine.
    powers = samples.wo[:, 2:, None] ** np.arange(_TILT_COEFFICIENTS)
    for i in range(n):
        wider = dataclasses.replace(now.shape, log_width=now.shape.log_width + _DIFFERENCE).column(samples, i)
        tilted = dataclasses.replace(now.shape, tilt=now.shape.tilt + _DIFFERENCE * _MIRRORED).column(samples, i)
        weight = amplitude[:, i, None] * root / _DIFFERENCE
        by_width.append((wider - now.columns[..., i]) * weight)
        by_tilt.append(((tilted - now.columns[..., i]) * weight)[..., None] * powers)
    tilts = np.concatenate(by_tilt, axis=-1).reshape(-1, n * _TILT_COEFFICIENTS)
    jacobian = np.concatenate([np.stack(by_width, axis=-1).reshape(-1, n), tilts], axis=1)
    free = np.argwhere(now.coefficients > 0)
    followed = now.columns[..., free[:, 0]] * samples.basis[:, None, free[:, 1]] * root[..., None]
    followed = followed.reshape(len(jacobian), -1)
    # Normal equations, eight times as fast as an orthogonal basis; the search needs no more digits of its direction.
    gram = followed.T @ followed
    gram += _RIDGE * np.trace(gram) / max(len(free), 1) * np.eye(len(free))
    jacobian -= followed @ np.linalg.solve(gram, followed.T @ jacobian)
    return np.concatenate([jacobian, _astray_derivative(samples, now.shape)])


def _astray_derivative(samples: Samples, shape: _Shape) -> Array:
    """The derivative of `_astray`, shape (v n, 4 n)."""
    v, n = len(samples.wo), len(shape.lean)
    own = np.eye(n)
    by_width = -_astray(samples, shape)[:, :, None] * own
    powers = samples.wo[:, 2:] ** np.arange(_TILT_COEFFICIENTS)
    by_tilt = _astray_per_tilt(samples, shape)[:, :, None, None] * own[:, :, None] * powers[:, None, None, :]
    return np.concatenate([by_width, by_tilt.reshape(v, n, -1)], axis=2).reshape(v * n, -1)


def _with_colors(samples: Samples, kernels: Sequence[Kernel], tilt: Array, lean: Array, share_min: float) -> RoundFit:
    """The amplitudes of each channel; lobes that reflect next to nothing are left out, the others solved for anew."""
    columns = np.stack([_column(samples, *one) for one in zip(kernels, tilt, lean, strict=True)], axis=-1)
    live = np.arange(len(kernels))
    while True:
        channels = [
            samples.amplitudes(columns[..., live], samples.value[..., c], samples.albedo[:, c]) for c in range(3)
        ]
        amplitude = np.stack(channels, axis=-1)
        share = np.einsum("vb,nbc->nv", samples.basis, amplitude).max(axis=1)
        mirrored = _leaning_back(lean[live])
        share = np.maximum(share, share[mirrored])
        is_live = share > share_min * share.max(initial=0.0)
        if is_live.all() or not is_live.any():
            break
        live = live[is_live]
    # Seen from across, those that lean to both sides are alike, as the shader takes them to be.
    across = amplitude.shape[1] // 2
    amplitude[:, across:] = 0.5 * (amplitude[:, across:] + amplitude[mirrored, across:])
    # A black material has one lobe all the same, of no amplitude.
    is_live = is_live if is_live.any() else np.arange(len(live)) == len(live) - len(_ENDING_AT_HORIZON)
    kept = live[is_live]
    return RoundFit(tuple(kernels[i] for i in kept), tilt[kept], lean[kept], amplitude[is_live], samples.azimuth)


def _leaning_back(lean: Array) -> NDArray[np.intp]:
    """Of each lobe, the one that leans the other way; of one that does not lean, itself."""
    return np.where(lean == 0, np.arange(len(lean)), np.abs(lean[:, None] + lean).argmin(axis=1))


def _column(samples: Samples, kernel: Kernel, tilt: Array, lean: float) -> Array:
    if kernel.power == 0:
        return _at_horizon(samples, kernel)
    return samples.in_cells(kernel.values(_tan2_half(samples, tilt, lean)))


def _at_horizon(samples: Samples, kernel: Kernel) -> Array:
    cosine = np.maximum(samples.wi[..., 2], 0.0)
    return samples.in_cells(kernel.values((1 - cosine) / (1 + cosine)))


def _tan2_half(samples: Samples, tilt: Array, lean: float) -> Array:
    """tan^2 of half the angle between the light and a lobe's middle, shape (v, k)."""
    h = np.array([lean * math.cos(samples.azimuth), lean * math.sin(samples.azimuth), 1.0])
    h /= np.linalg.norm(h)
    t = (samples.wo[:, 2:] ** np.arange(_TILT_COEFFICIENTS)) @ tilt
    mirrored = 2 * (samples.wo @ h)[:, None] * h - samples.wo
    d = h + t[:, None] * (mirrored - h)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    cosine = (samples.wi @ d[..., None])[..., 0]
    return np.maximum(1 - cosine, 0) / np.maximum(1 + cosine, 1e-15)
