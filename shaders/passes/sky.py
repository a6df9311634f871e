"""Draws the environment into the frame wherever no mesh is."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..scene import Scene
from ..view import jitter_ndc, view_rays, world_to_environment


def declare(scene: Scene) -> Pass:
    return Pass("sky", reads=frozenset(), writes=frozenset({"frame"}), enabled=scene.sky, every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/full_screen.vert", "pass/sky.frag", {}, {})
    rays = view_rays(frame.scene)
    rotation = world_to_environment(frame.scene)

    def draw(number: int) -> None:
        # At the far plane, and after the meshes: only pixels that they left are shaded.
        frame.ctx.enable_only(moderngl.DEPTH_TEST)
        frame.ctx.depth_func = "<="
        frame.bind_radiance()
        program["radiance"] = UNITS["radiance"]
        program["view_rays"] = rays
        program["world_to_environment"] = rotation
        program["jitter_ndc"] = jitter_ndc(frame.scene, number)
        frame.draw_full_screen("frame", program)

    return draw
