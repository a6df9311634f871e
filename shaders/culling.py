"""Which parts can be seen at all: their bounding spheres against the camera's frustum.

- Gribb, Hartmann 2001, "Fast Extraction of Viewing Frustum Planes from the World-View-Projection Matrix".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .scene import Part, Scene
from .view import view_projection


def visible_parts(scene: Scene) -> tuple[Part, ...]:
    """The parts of which a jittered frame may show something, in the scene's order."""
    planes = _planes(scene)
    return tuple(part for part in scene.parts if _reaches_into(planes, part))


def _planes(scene: Scene) -> NDArray[np.float64]:
    """Rows (a, b, c, d), a point being inside where a x + b y + c z + d >= 0; (a, b, c) is of unit length."""
    x, y, z, w = np.array(view_projection(scene)).reshape(4, 4).T
    # A frame's offset is half a pixel at most, and a pixel is 2 / width in clip space.
    right, top = (1 + 1 / scene.width) * w, (1 + 1 / scene.height) * w
    planes = np.stack([right + x, right - x, top + y, top - y, w + z, w - z])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def _reaches_into(planes: NDArray[np.float64], part: Part) -> bool:
    centre, radius = part.mesh.bounding_sphere
    return bool((planes @ np.append(centre, 1.0) >= -radius).all())
