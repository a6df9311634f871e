"""How much neighbouring samples scatter: noise, estimated without a model."""

from __future__ import annotations

import numpy as np

from ..reflectance import Reflectance

_LOOKED_AT = 40_000
_BLOCK = 1024
# Consecutive samples whose directions differ by less are neighbours of one scan.
_NEIGHBOUR = 0.2
_NEIGHBOURS_MIN = 30
# Where a lobe has fallen below this, in 1/sr, there is nothing to see.
_FLOOR = 1e-4


def scatter(data: Reflectance, among: np.ndarray) -> float | None:
    """The relative standard deviation of the mean of the channels, from one sample to the next.

    Third differences along a scan are almost nothing for a smooth curve, and 4.5 standard deviations for noise. They
    are taken of the logarithm, which is smooth also where a lobe falls over many decades.

    **Arguments:**

    - `data`: any measurement.
    - `among`: (n,) bool, the samples that count.

    **Returns:** 0.05 for 5 %; None if the samples do not follow each other along scans.
    """
    # Blocks of neighbours, evenly spaced.
    length = min(len(data), _BLOCK)
    starts = np.unique(np.linspace(0, len(data) - length, _LOOKED_AT // _BLOCK).astype(int))
    rows = np.unique((starts[:, None] + np.arange(length)).ravel())
    if len(rows) < 4:
        return None
    wi, wo, log = data.wi[rows], data.wo[rows], data.value[rows].mean(axis=1)
    usable = among[rows] & (log > _FLOOR)
    log = np.log(np.maximum(log, _FLOOR))
    step = np.abs(np.diff(wi, axis=0)).max(axis=1) + np.abs(np.diff(wo, axis=0)).max(axis=1)
    near = (step > 0) & (step < _NEIGHBOUR) & (np.diff(rows) == 1)
    use = near[:-2] & near[1:-1] & near[2:]
    for shift in range(4):
        use &= usable[shift : len(usable) - 3 + shift]
    if np.count_nonzero(use) < _NEIGHBOURS_MIN:
        return None
    third = (log[:-3] - 3 * log[1:-2] + 3 * log[2:-1] - log[3:])[use] / np.sqrt(20)
    return float(np.median(np.abs(third)) / 0.6745)  # the median of |x| is 0.6745 standard deviations
