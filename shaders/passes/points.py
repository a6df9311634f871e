"""Finds the points of the meshes that are seen, and their normals."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..culling import visible_parts
from ..drawing import mesh_name, prepare_parts
from ..frame import Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene
from ..tiers import is_deferred


def declare(scene: Scene) -> Pass:
    """Writes `points`: position and number of the part, from 1, or 0 where none is; the normal; and the depth."""
    return Pass(
        "points",
        reads=frozenset(mesh_name(part) for part in visible_parts(scene)),
        writes=frozenset({"points"}),
        key=(scene.camera, scene.width, scene.height),
        enabled=is_deferred(scene),
        every_frame=True,
    )


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the offset."""
    program = frame.programs.graphics("pass/surface.vert", "pass/points.frag", {}, {})

    def bind(index: int) -> None:
        set_uniforms(program, {"part": index + 1})

    draw_parts = prepare_parts(frame, lambda part: program, {}, bind, target="points")

    def draw(number: int) -> None:
        frame.clear("points")
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<"
        draw_parts(number)

    return draw
