"""Draws the environment into the frame wherever no mesh is."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..lighting import lighting
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene
from ..view import jitter_ndc, view_rays, world_to_environment


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): radiance with coverage 1 where no mesh is; disabled for `scene.sky = False`."""
    return Pass("sky", reads=frozenset(), writes=frozenset({"frame"}), enabled=scene.sky, every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the offset within the pixels."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/sky.frag", {}, {})
    radiance = lighting(frame.ctx, frame.scene.environment).radiance
    rays = view_rays(frame.scene)
    rotation = world_to_environment(frame.scene)

    def draw(number: int) -> None:
        # At the far plane, and after the meshes: only pixels that they left are shaded.
        frame.ctx.enable_only(moderngl.DEPTH_TEST)
        frame.ctx.depth_func = "<="
        radiance.use(UNITS["radiance"])
        values = {"radiance": UNITS["radiance"], "view_rays": rays, "world_to_environment": rotation}
        set_uniforms(program, values | {"jitter_ndc": jitter_ndc(frame.scene, number)})
        frame.draw_full_screen("frame", program)

    return draw
