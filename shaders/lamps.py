"""The brightest texels of an environment, as lights without size: what sampling would find too seldom or too often."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from numpy.typing import NDArray

from .environment import Environment

_COUNT_MAX = 64
# Nothing below this multiple of the mean radiance is a lamp.
_EXCESS_MIN = 4.0
# With less than this part of all light, lamps are left where they are by kernels that are not narrow.
_SHARE_MIN = 1e-4
# Lamps this part of a kernel's width apart are one to it: an error of the square of it, of its own light.
_APART = 0.05


@dataclasses.dataclass(frozen=True, eq=False)
class Lamps:
    """What lies above a limit in an environment.

    - `limit`: in radiance, per channel.
    - `directions`: shape (n, 3), float32, unit, in the environment's axes.
    - `fluxes`: shape (n, 3), float32, radiance above the limit times solid angle.
    - `share`: their part of all light, each in its brightest channel.
    """

    limit: float
    directions: NDArray[np.float32]
    fluxes: NDArray[np.float32]
    share: float


@functools.lru_cache(8)
def find_strong_lamps(environment: Environment) -> Lamps:
    """The lamps if they hold a part of the light that counts for wide kernels; else none, and an infinite limit."""
    lamps = find_lamps(environment)
    if lamps.share >= _SHARE_MIN:
        return lamps
    return Lamps(math.inf, np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), 0.0)


def merge_lamps(lamps: Lamps, width: float) -> Lamps:
    """Fewer lamps, which are the same to a kernel of this width: neighbours become one in the middle of their light."""
    directions, fluxes, strength = lamps.directions.astype(np.float64), lamps.fluxes, lamps.fluxes.sum(axis=1)
    found: list[tuple[NDArray[np.float64], NDArray[np.float32]]] = []
    while len(directions):
        brightest = directions[strength.argmax()]
        is_near = np.linalg.norm(directions - brightest, axis=1) <= _APART * width
        middle = strength[is_near] @ directions[is_near]
        found.append((middle / np.linalg.norm(middle), fluxes[is_near].sum(axis=0)))
        directions, fluxes, strength = (one[~is_near] for one in (directions, fluxes, strength))
    if not found:
        return lamps
    middles, sums = (np.array(column, np.float32) for column in zip(*found, strict=True))
    return Lamps(lamps.limit, middles, sums, lamps.share)


@functools.lru_cache(8)
def find_lamps(environment: Environment) -> Lamps:
    """The lamps of an environment, 64 texels at most: the limit is what the next brightest one has."""
    return _above(environment, _COUNT_MAX)


@functools.lru_cache(8)
def find_bright(environment: Environment) -> Lamps:
    """All texels above four times the mean radiance, as many as they are: a sun is looked for among them."""
    return _above(environment, environment.pixels[..., 0].size)


def _above(environment: Environment, count_max: int) -> Lamps:
    pixels = environment.pixels
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    # Quicker than the maximum along an axis of three.
    peak = np.maximum(np.maximum(pixels[..., 0], pixels[..., 1]), pixels[..., 2])
    mean = float(peak.sum(axis=1, dtype=np.float64) @ solid_angle / (4 * np.pi))
    limit = _EXCESS_MIN * mean
    above = np.flatnonzero(peak > limit)
    if len(above) > count_max:
        limit = float(np.partition(peak.ravel()[above], -count_max - 1)[-count_max - 1])
        above = np.flatnonzero(peak > limit)
    row, column = np.divmod(above, width)
    polar, azimuth = np.pi * (row + 0.5) / height, 2 * np.pi * ((column + 0.5) / width - 0.5)
    sine = np.sin(polar)
    directions = np.stack([sine * np.sin(azimuth), np.cos(polar), -sine * np.cos(azimuth)], axis=1)
    fluxes = np.maximum(pixels[row, column] - limit, 0) * solid_angle[row, None]
    share = float(fluxes.max(axis=1).sum() / max(4 * np.pi * mean, 1e-30))
    return Lamps(limit, directions.astype(np.float32), fluxes.astype(np.float32), share)
