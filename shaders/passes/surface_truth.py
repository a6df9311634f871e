"""Shades the points that are seen, lit by the environment without bias, into the frame."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import UNITS, Frame
from ..lighting import Light
from ..plan import Pass
from ..scene import Scene
from ..surface import declare_shading, prepare_shading


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    return declare_shading("surface_truth", scene, ["light_table"], None, enabled=scene.tier == "truth")


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the directions of light."""
    light = frame.resource("light_table", Light)
    values = {
        "radiance": UNITS["radiance"],
        "light_size": light.size,
        "light_block": light.block,
        "techniques": light.techniques,
    }

    def bind_light() -> None:
        light.radiance.use(UNITS["radiance"])
        light.cells.bind_to_storage_buffer(0)
        light.slots.bind_to_storage_buffer(1)

    return prepare_shading(frame, "pass/truth.frag", values, bind_light, {})
