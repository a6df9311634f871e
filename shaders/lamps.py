"""The brightest texels of an environment, as lights without size: what sampling would find too seldom or too often."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from .environment import Environment

_COUNT_MAX = 64
# Nothing below this multiple of the mean radiance is a lamp.
_EXCESS_MIN = 4.0


@dataclasses.dataclass(frozen=True, eq=False)
class Lamps:
    """What lies above a limit in an environment.

    - `limit`: in radiance, per channel.
    - `directions`: shape (n, 3), float32, unit, in the environment's axes.
    - `fluxes`: shape (n, 3), float32, radiance above the limit times solid angle.
    """

    limit: float
    directions: NDArray[np.float32]
    fluxes: NDArray[np.float32]


@functools.lru_cache(8)
def find_lamps(environment: Environment) -> Lamps:
    """The lamps of an environment, 64 texels at most: the limit is what the next brightest one has."""
    pixels = environment.pixels
    height, width = pixels.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    peak = pixels.max(axis=2)
    mean = float((peak * solid_angle[:, None]).sum() / (4 * np.pi))
    limit = _EXCESS_MIN * mean
    above = np.flatnonzero(peak > limit)
    if len(above) > _COUNT_MAX:
        limit = float(np.partition(peak.ravel()[above], -_COUNT_MAX - 1)[-_COUNT_MAX - 1])
        above = np.flatnonzero(peak > limit)
    row, column = np.divmod(above, width)
    polar, azimuth = np.pi * (row + 0.5) / height, 2 * np.pi * ((column + 0.5) / width - 0.5)
    sine = np.sin(polar)
    directions = np.stack([sine * np.sin(azimuth), np.cos(polar), -sine * np.cos(azimuth)], axis=1)
    fluxes = np.maximum(pixels[row, column] - limit, 0) * solid_angle[row, None]
    return Lamps(limit, directions.astype(np.float32), fluxes.astype(np.float32))
