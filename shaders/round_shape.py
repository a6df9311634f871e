"""Round kernels where a material's lobes may lie, as weights of the cells of its samples."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from .kernel import Kernel, round_values
from .round_samples import Array, Samples

# Widths that are tried for a new lobe.
WIDTHS = np.geomspace(3e-3, 1.2, 14)
# Coefficients of a tilt.
TILT_COEFFICIENTS = 3


@dataclasses.dataclass(frozen=True, eq=False)
class Shape:
    """Round kernels and where they lie: `power` (n,), `log_width` (n,), `tilt` (n, 3), `lean` (n,)."""

    power: Array
    log_width: Array
    tilt: Array
    lean: Array

    def columns(self, samples: Samples) -> Array:
        """What they weigh each cell by, shape (v, c, n)."""
        return np.stack([self.column(samples, i) for i in range(len(self.lean))], axis=-1)

    def column(self, samples: Samples, i: int) -> Array:
        """`columns` of one of them, shape (v, c)."""
        x = tan2_half(samples, self.tilt[i], self.lean[i])
        return samples.in_cells(round_values(x, float(self.power[i]), math.exp(self.log_width[i])))


NOTHING = Shape(np.zeros(0), np.zeros(0), np.zeros((0, TILT_COEFFICIENTS)), np.zeros(0))
# Of the mirror direction.
MIRRORED = np.array([1.0, 0.0, 0.0])


def at_horizon_column(samples: Samples, kernel: Kernel) -> Array:
    """What a kernel that ends at the horizon weighs each cell by, shape (v, c)."""
    cosine = np.maximum(samples.wi[..., 2], 0.0)
    return samples.in_cells(kernel.values((1 - cosine) / (1 + cosine)))


def tan2_half(samples: Samples, tilt: Array, lean: float) -> Array:
    """tan^2 of half the angle between the light and a lobe's middle, shape (v, k)."""
    h = np.array([lean * math.cos(samples.azimuth), lean * math.sin(samples.azimuth), 1.0])
    h /= np.linalg.norm(h)
    t = (samples.wo[:, 2:] ** np.arange(TILT_COEFFICIENTS)) @ tilt
    mirrored = 2 * (samples.wo @ h)[:, None] * h - samples.wo
    d = h + t[:, None] * (mirrored - h)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    cosine = (samples.wi @ d[..., None])[..., 0]
    return np.maximum(1 - cosine, 0) / np.maximum(1 + cosine, 1e-15)
