"""Shades the points that are seen, lit by a few means of the environment, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..scene import Scene
from ..surface import declare_shading, prepare_shading
from ..tiers import frames_at_most


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    return declare_shading("surface_still", scene, "sky_cube", scene.samples, enabled=scene.tier == "still")


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the directions of light."""
    sky_cube = frame.resource("sky_cube", moderngl.TextureCube)
    values = {
        "sky_cube": UNITS["sky_cube"],
        "sky_cube_side": sky_cube.size[0],
        "frames": frames_at_most(frame.scene, 1),
    }
    return prepare_shading(frame, "pass/still.frag", values, lambda: sky_cube.use(UNITS["sky_cube"]))
