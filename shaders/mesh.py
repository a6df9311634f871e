"""Meshes: what the preview draws."""

from __future__ import annotations

import dataclasses
import functools
import hashlib

import numpy as np
from numpy.typing import NDArray

# Enough that the outline of a sphere 500 pixels wide is off by less than a tenth of a pixel.
_RINGS = 64


# Two are equal if they are the same object: arrays have no equality of their own. Their content is in the digest.
@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with normals. Not to be changed once it has been rendered: make another one.

    - `positions`, `normals`: shape (n, 3), float32, world space, y up; normals unit, outwards.
    - `triangles`: shape (m, 3), uint32, counter-clockwise seen from outside.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.uint32]

    @functools.cached_property
    def digest(self) -> str:
        """A name for the content: equal for equal arrays."""
        state = hashlib.blake2b(digest_size=16)
        for array in (self.positions, self.normals, self.triangles):
            state.update(repr(array.shape).encode())
            state.update(np.ascontiguousarray(array).tobytes())
        return state.hexdigest()

    @functools.cached_property
    def bounding_sphere(self) -> tuple[NDArray[np.float64], float]:
        """Centre, shape (3,), and radius of a sphere around all positions; not the smallest one."""
        positions = self.positions.astype(np.float64)
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        return centre, float(np.sqrt(np.square(positions - centre).sum(axis=1).max()))


@functools.cache
def sphere() -> Mesh:
    """A sphere of radius 1 about the origin."""
    polar, azimuth = np.meshgrid(
        np.linspace(0, np.pi, _RINGS + 1), np.linspace(0, 2 * np.pi, 2 * _RINGS + 1), indexing="ij"
    )
    normals = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)], axis=-1)
    corner = np.arange(_RINGS)[:, None] * (2 * _RINGS + 1) + np.arange(2 * _RINGS)[None, :]
    below = corner + 2 * _RINGS + 1
    triangles = np.stack([corner, below, corner + 1, corner + 1, below, below + 1], axis=-1).reshape(-1, 3)
    points = normals.reshape(-1, 3).astype(np.float32)
    return Mesh(points, points, triangles.astype(np.uint32))
