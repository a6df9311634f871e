"""Small round lights whose energy and direction are exact at any resolution, though they cover a texel or two."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .grid import Floats

# A spiral of points with equal areas (Vogel 1979, "A Better Way to Construct the Sunflower Head").
_POINTS = 1024
_GOLDEN = math.pi * (3 - math.sqrt(5))
Triple = tuple[float, float, float]


def add_disc(
    picture: Floats,
    towards: Triple,
    half_angle: float,
    irradiance: Floats,
    limb: Triple = (0.0, 0.0, 0.0),
) -> None:
    """Adds a disc of light to a picture.

    Every point of it is shared among the four nearest texels by the weights with which the renderer's linear
    interpolation reads them: so the interpolated picture has its energy and its centre, and no stairs.

    **Arguments:**

    - `picture`: shape (h, 2 h, 3); changed.
    - `towards`: the direction of its centre, not normalised, more than a texel away from the poles.
    - `half_angle`: in radians, below 0.1.
    - `irradiance`: shape (3,), on a surface that faces it.
    - `limb`: by which power of the cosine on the sphere that it is each channel darkens towards the edge.
    """
    height, width = picture.shape[:2]
    share = (np.arange(_POINTS) + 0.5) / _POINTS
    turn = np.arange(_POINTS) * _GOLDEN
    centre = np.array(towards) / np.linalg.norm(towards)
    right = np.cross(centre, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, centre)
    radius = math.tan(half_angle) * np.sqrt(share)[:, None]
    w = centre + radius * (np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * up)
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    darkening = np.sqrt(1 - share)[:, None] ** np.array(limb)
    energy = irradiance * darkening / darkening.sum(axis=0)
    x = (0.5 + np.arctan2(w[:, 0], -w[:, 2]) / (2 * np.pi)) * width - 0.5
    y = np.arccos(w[:, 1]) / np.pi * height - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    for i, across in ((column, 1 - (x - column)), (column + 1, x - column)):
        for j, down in ((row, 1 - (y - row)), (row + 1, y - row)):
            j = np.clip(j, 0, height - 1)
            shared = energy * (across * down / _solid_angle(j, height))[:, None]
            np.add.at(picture, (j, i % width), shared.astype(np.float32))


def _solid_angle(row: NDArray[np.intp], height: int) -> Floats:
    """The integral over all directions of a texel's weight in the interpolation, in sr."""
    step = np.pi / height
    return np.sin((row + 0.5) * step) * 2 * (1 - np.cos(step))
