"""Draws the depth of the parts before their colour, so that no pixel is shaded that another part then hides."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..culling import visible_parts
from ..drawing import mesh_name, prepare_parts
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene
from ..tiers import is_deferred

NAME = "depth"


def declare(scene: Scene) -> Pass:
    """Writes `depth`, which is the frame's, where the meshes are drawn directly.

    Enabled for several visible parts: one alone hides little of itself.
    """
    parts = visible_parts(scene)
    return Pass(
        NAME,
        reads=frozenset(mesh_name(part) for part in parts),
        writes=frozenset({"depth"}),
        key=(scene.camera, scene.width, scene.height),
        enabled=not is_deferred(scene) and len(parts) > 1,
        every_frame=True,
    )


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame."""
    program = frame.programs.graphics("pass/surface.vert", "pass/depth.frag", {}, {})
    draw_parts = prepare_parts(frame, lambda part: program, {}, lambda index: None)

    def draw(number: int) -> None:
        frame.clear("frame")
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<"
        draw_parts(number)

    return draw
