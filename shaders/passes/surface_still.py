"""Shades the points that are seen, lit by a few means of the environment and its hot lights, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..buffers import KeptBuffer
from ..frame import UNITS, Frame
from ..hot_lights import IN_FRAME
from ..plan import Pass
from ..scene import Scene
from ..surface import declare_shading, prepare_shading
from ..tiers import frames_at_most
from . import albedos
from .hot_lights import lights_of

# Of the lights in glsl/pass/still.frag.
_BINDING = 1


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    light = {"sky_cube", "albedos", *(("hot_lights", "cool_cube") if lights_of(scene) else ())}
    return declare_shading("surface_still", scene, light, scene.samples, enabled=scene.tier == "still")


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the directions of light."""
    sky_cube = frame.resource("sky_cube", moderngl.TextureCube)
    lights = lights_of(frame.scene)
    values = {
        "sky_cube": UNITS["sky_cube"],
        "cool_cube": UNITS["cool_cube"],
        "sky_cube_side": sky_cube.size[0],
        "light_solid_angle": lights.solid_angle if lights else 0.0,
        "frames": frames_at_most(frame.scene, 1),
    }

    def bind_light() -> None:
        sky_cube.use(UNITS["sky_cube"])
        frame.resource("albedos", moderngl.Buffer).bind_to_storage_buffer(albedos.BINDING)
        if lights:
            frame.resource("cool_cube", moderngl.TextureCube).use(UNITS["cool_cube"])
            frame.resource("hot_lights", KeptBuffer).buffer.bind_to_storage_buffer(_BINDING)

    defines = albedos.albedo_defines(frame.scene) | {"LIGHTS": str(IN_FRAME if lights else 0)}
    return prepare_shading(frame, "pass/still.frag", values, bind_light, defines)
