"""The directions of a cube map's texels."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray


@functools.lru_cache(8)
def texel_directions(texels: int) -> NDArray[np.float32]:
    """The middles of all texels (OpenGL 4.3, table 8.18), as `cube_direction` of `glsl/cube.glsl` has them.

    **Arguments:** `texels`: along an edge.

    **Returns:** shape (6, texels, texels, 3), unit.
    """
    at = (2 * np.arange(texels) + 1.0) / texels - 1
    x, y, one = np.broadcast_arrays(at, at[:, None], 1.0)
    faces = [(one, -y, -x), (-one, -y, x), (x, one, y), (x, -one, -y), (x, -y, one), (-x, -y, -one)]
    found = np.stack([np.stack(face, axis=-1) for face in faces])
    return (found / np.linalg.norm(found, axis=-1, keepdims=True)).astype(np.float32)
