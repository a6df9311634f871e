"""Draws the meshes, lit by the environment without bias, into the frame."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import Frame
from ..plan import Pass
from ..scene import Scene
from ..surface import declare_sampled, prepare_sampled


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    return declare_sampled("surface_truth", scene, enabled=scene.tier == "truth")


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number: it decides the offset and the directions of light."""
    return prepare_sampled(frame)
