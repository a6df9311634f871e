"""From a material's values to its round lobes; `round_lobes` says what they are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .brushed_lobes import brushed_lobes
from .kernel import COSINE, SATURATED, Kernel, nearest_kernel
from .round_samples import Array, Evaluate, Samples, sample_material
from .round_shape import NOTHING, TILT_COEFFICIENTS, at_horizon_column, tan2_half
from .stacked_lobes import stacked_lobes

# Below this misfit of kernels that end at the horizon there are no others.
_GOOD = 0.02
# Lobes that never reflect this part of what the strongest does are left out, by whether they lie side by side, where
# each has a part of one highlight.
_SHARE_MIN = {False: 0.05, True: 0.01}
_ENDING_AT_HORIZON = (COSINE, SATURATED)


@dataclasses.dataclass(frozen=True, eq=False)
class RoundFit:
    """What was found; see `RoundLobes`, but `amplitude`, (n, b, 3), holds coefficients of `Samples.basis`."""

    kernels: tuple[Kernel, ...]
    tilt: Array
    lean: Array
    amplitude: Array
    azimuth: float
    misfit: float


def fit_lobes(evaluate: Evaluate, is_anisotropic: bool) -> RoundFit:
    """The round lobes of a material; the arguments are those of `sample_material`."""
    samples = sample_material(evaluate, is_anisotropic)
    at_horizon = np.stack([at_horizon_column(samples, kernel) for kernel in _ENDING_AT_HORIZON], axis=-1)
    cost = samples.cost(at_horizon)
    shape = NOTHING
    if cost > _GOOD**2:
        shape = (brushed_lobes if is_anisotropic else stacked_lobes)(samples, at_horizon, cost)
    round_kernels = [nearest_kernel(float(p), math.exp(w)) for p, w in zip(shape.power, shape.log_width, strict=True)]
    kernels = (*round_kernels, *_ENDING_AT_HORIZON)
    none = np.zeros(len(_ENDING_AT_HORIZON))
    tilt = np.concatenate([shape.tilt, np.zeros((len(none), TILT_COEFFICIENTS))])
    lean = np.concatenate([shape.lean, none])
    return _with_colors(samples, kernels, tilt, lean, _SHARE_MIN[is_anisotropic])


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
    misfit = math.sqrt(samples.cost(columns[..., kept]))
    return RoundFit(
        tuple(kernels[i] for i in kept), tilt[kept], lean[kept], amplitude[is_live], samples.azimuth, misfit
    )


def _leaning_back(lean: Array) -> NDArray[np.intp]:
    """Of each lobe, the one that leans the other way; of one that does not lean, itself."""
    return np.where(lean == 0, np.arange(len(lean)), np.abs(lean[:, None] + lean).argmin(axis=1))


def _column(samples: Samples, kernel: Kernel, tilt: Array, lean: float) -> Array:
    if kernel.power == 0:
        return at_horizon_column(samples, kernel)
    return samples.in_cells(kernel.values(tan2_half(samples, tilt, lean)))
