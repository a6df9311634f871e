"""The directions of a latitude-longitude picture's texels, and steps that are smooth; `shaders.environment` has the
orientation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# float32 throughout, or NumPy would double the time; the types only say that it is floating.
Floats = NDArray[np.floating]
# Of the built-in pictures: a texel is 0.35 degrees wide.
HEIGHT = 512


def azimuths(height: int) -> Floats:
    """The azimuth of each column of texel centres, from -z towards +x in (-pi, pi): shape (2 height,)."""
    return (((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2 * np.pi).astype(np.float32)


def elevations(height: int) -> Floats:
    """The angle of each row of texel centres above the horizon, falling: shape (height,)."""
    return ((0.5 - (np.arange(height) + 0.5) / height) * np.pi).astype(np.float32)


def directions(height: int) -> Floats:
    """The unit direction of each texel centre: shape (height, 2 height, 3)."""
    azimuth, elevation = azimuths(height), elevations(height)[:, None]
    cosine = np.cos(elevation)
    return np.stack([cosine * np.sin(azimuth), np.sin(elevation) + 0 * azimuth, -cosine * np.cos(azimuth)], axis=-1)


def smooth(x: Floats) -> Floats:
    """0 below 0, 1 above 1, smooth between."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def sky_irradiance(upper: Floats) -> Floats:
    """What the upper half of a picture, shape (h, w, 3), sends onto the ground: shape (3,), by the midpoint rule."""
    height, width = upper.shape[:2]
    elevation = elevations(2 * height)[:height].astype(np.float64)
    weight = np.sin(elevation) * np.cos(elevation) * (np.pi / (2 * height)) * (2 * np.pi / width)
    return weight @ upper.sum(axis=1, dtype=np.float64)
