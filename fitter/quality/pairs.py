"""Samples that belong together: the same pair of directions measured again, or with light and viewer exchanged."""

from __future__ import annotations

import numpy as np

from ..reflectance import Reflectance
from .finding import Finding, found
from .scatter import scatter

_RECIPROCITY_MIN = 0.05
_RECIPROCITY_PAIRS = 10
_RECIPROCITY_EVALUATED = 400
# Scattered samples beyond this number are not compared with each other, which would take longer than it may.
_MATCHED_MAX = 1 << 18


def not_reciprocal(data: Reflectance) -> Finding | None:
    """Whether values change when light and viewer are exchanged, as far as the data hold both."""
    one, other = _exchanged(data)
    one, other = one.sum(axis=1), other.sum(axis=1)
    use = np.isfinite(other) & (one + other > 0)
    if np.count_nonzero(use) < _RECIPROCITY_PAIRS:
        return None
    difference = 2 * (one[use] - other[use]) / (one[use] + other[use])
    # Not the root mean square: near a sharp highlight the file's own interpolation is off by more than its numbers.
    typical = float(np.median(np.abs(difference)))
    noise = scatter(data, np.minimum(data.wi[:, 2], data.wo[:, 2]) > 0.5) if data.interpolant is None else None
    # What noise alone makes of it, and half as much again for the chance in a few pairs.
    if typical < max(_RECIPROCITY_MIN, 1.5 * 0.6745 * np.sqrt(2) * (noise or 0.0)):
        return None
    cause = "noise" if data.interpolant is None else "noise, by interpolation between the incident angles of the file"
    return found(
        "not reciprocal",
        int(np.count_nonzero(use)),
        data,
        f"With light and viewer exchanged, values differ by {100 * typical:.0f} % (median of {{number}} pairs below 60 "
        f"degrees), by {cause}, or since the instrument or the material is not reciprocal. The models are, and so come "
        "no nearer than about half of that.",
    )


def _exchanged(data: Reflectance) -> tuple[np.ndarray, np.ndarray]:
    """Values (m, 3) of pairs of directions, and of the same with light and viewer exchanged."""
    nothing = np.zeros((0, 3)), np.zeros((0, 3))
    low = np.flatnonzero(np.minimum(data.wi[:, 2], data.wo[:, 2]) > 0.5)
    if data.interpolant is not None:
        # A table over half and difference angles holds both orders in one cell.
        if data.grid is not None and "theta_h" in data.grid.axes:
            return nothing
        rows = low[:: max(1, len(low) // _RECIPROCITY_EVALUATED)]
        if not len(rows):
            return nothing
        return data.value[rows], np.maximum(data.evaluate(data.wo[rows], data.wi[rows]), 0.0)
    if len(low) > _MATCHED_MAX:
        return nothing
    wi, wo = data.wi[low], data.wo[low]
    azimuth = np.abs(wi[:, 1]).max(initial=0)
    if azimuth < 1e-9:  # one incident azimuth: the sample is taken to be isotropic
        dot = np.einsum("ij,ij->i", wi, wo)
        forth = _keys(wi[:, 2], wo[:, 2], dot)
        back = _keys(wo[:, 2], wi[:, 2], dot)
    else:
        forth, back = _keys(*wi.T, *wo.T), _keys(*wo.T, *wi.T)
    order = np.argsort(forth, kind="stable")
    place = np.minimum(np.searchsorted(forth[order], back), len(order) - 1)
    partner = order[place] if len(order) else order
    # Each pair once, and no sample with itself.
    use = np.flatnonzero((forth[partner] == back) & (forth < back)) if len(order) else order
    return data.value[low[use]], data.value[low[partner[use]]]


def repeated(data: Reflectance) -> Finding | None:
    """How many scattered samples repeat a pair of directions, and how well they agree."""
    # A table meets its poles more than once.
    if data.grid is not None or data.interpolant is not None or len(data) > _MATCHED_MAX:
        return None
    keys = _keys(*data.wi.T, *data.wo.T)
    if (np.diff(np.sort(keys)) != 0).all():
        return None
    order = np.argsort(keys, kind="stable")
    group = np.cumsum(np.r_[0, np.diff(keys[order]) != 0])
    size = np.bincount(group)
    extra = len(data) - len(size)
    value = data.value[order].mean(axis=1)
    mean = np.bincount(group, value) / size
    many = (size > 1)[group] & (mean[group] > 0)
    # Each repeated geometry has one degree of freedom less than it has samples.
    squares = ((value - mean[group]) / np.where(mean > 0, mean, 1)[group]) ** 2
    scatter = float(np.sqrt(squares[many].sum() / extra))
    return found(
        "repeated",
        extra,
        data,
        f"{{count}} repeat a pair of directions that was measured before; repetitions differ by {100 * scatter:.2g} % "
        "(standard deviation). They count several times in the fit.",
    )


def _keys(*columns: np.ndarray) -> np.ndarray:
    """One number per row, the same for rows that agree to four decimals."""
    keys = np.zeros(len(columns[0]), np.uint64)
    for column in columns:
        # A step of a multiplicative hash (the odd number is 2^64 over the golden ratio); it wraps around.
        keys = (keys ^ np.rint(column * 1e4).astype(np.int64).view(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    return keys
