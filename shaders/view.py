"""The camera as matrices, and the frames' offsets within a pixel."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .scene import Camera, Scene
from .sequence import sequence_point, shuffled_index

# Depth range: objects of about unit size, some units away.
_NEAR, _FAR = 0.01, 1000.0
# Of the offsets within a pixel and of their order, for each sum: any numbers that have nothing in common.
_SEEDS = ((123456789, 362436069), (521288629, 88675123))
_ORDERS = (2654435769, 2246822507)


def _axes(camera: Camera) -> NDArray[np.float64]:
    """Rows: the camera's right, up and backwards in world space."""
    backwards = np.subtract(camera.position, camera.target).astype(np.float64)
    right = np.cross(camera.up, backwards)
    lengths = np.linalg.norm(backwards), np.linalg.norm(right)
    if not all(np.isfinite(length) and length > 0 for length in lengths):
        raise UserError(
            f"`position {camera.position}, target {camera.target}, up {camera.up}` is no view: the target must differ "
            "from the position, and `up` must not point along the view. Move one of them."
        )
    backwards, right = backwards / lengths[0], right / lengths[1]
    return np.stack([right, np.cross(backwards, right), backwards])


def _column_major(matrix: NDArray[np.float64]) -> tuple[float, ...]:
    """A matrix for column vectors as the value of a GLSL uniform."""
    return tuple(matrix.T.reshape(-1).tolist())


def view_projection(scene: Scene) -> tuple[float, ...]:
    """World to clip space as a `mat4`; depth as OpenGL has it, from -1 to 1."""
    axes = _axes(scene.camera)
    view = np.eye(4)
    view[:3, :3] = axes
    view[:3, 3] = -axes @ np.asarray(scene.camera.position, np.float64)
    scale = 1 / math.tan(scene.camera.vertical_fov / 2)
    projection = np.zeros((4, 4))
    projection[0, 0] = scale * scene.height / scene.width
    projection[1, 1] = scale
    projection[2, 2] = (_FAR + _NEAR) / (_NEAR - _FAR)
    projection[2, 3] = 2 * _FAR * _NEAR / (_NEAR - _FAR)
    projection[3, 2] = -1
    return _column_major(projection @ view)


def view_rays(scene: Scene) -> tuple[float, ...]:
    """A `mat3` that takes (x, y, 1), the first two from -1 to 1 over the picture, to a world direction."""
    right, up, backwards = _axes(scene.camera)
    half = math.tan(scene.camera.vertical_fov / 2)
    return _column_major(np.stack([right * half * scene.width / scene.height, up * half, -backwards], axis=-1))


def environment_to_world(scene: Scene) -> NDArray[np.float64]:
    """The matrix of the environment's counter-clockwise rotation about +y, shape (3, 3)."""
    cosine, sine = math.cos(scene.rotation), math.sin(scene.rotation)
    return np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])


def world_to_environment(scene: Scene) -> tuple[float, ...]:
    """A `mat3` that undoes the environment's rotation."""
    return _column_major(environment_to_world(scene).T)


def jitter_ndc(scene: Scene, index: int, seed: int) -> tuple[float, float]:
    """The offset of a frame within the pixel, in units where the picture is 2 wide and high.

    The sequences of two sums are independent of each other: else their difference would not tell the error at edges. An
    only frame is not moved: it has several samples per pixel. The shaders take their points in the frames' order, so
    the offsets have an order of their own.
    """
    if scene.tier == "interactive":
        return 0.0, 0.0
    x, y = sequence_point(shuffled_index(index, _ORDERS[seed]), _SEEDS[seed])
    return (2 * x - 1) / scene.width, (2 * y - 1) / scene.height
