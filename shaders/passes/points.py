"""Finds the points of the meshes that are seen, and their normals."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Part, Scene
from ..view import jitter_ndc, view_projection


def declare(scene: Scene) -> Pass:
    """Writes `points`: position and number of the part, from 1, or 0 where none is; the normal; and the depth."""
    return Pass("points", reads=frozenset(), writes=frozenset({"points"}), every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the offset."""
    draws = [_prepare_part(frame, part, number) for number, part in enumerate(frame.scene.parts, 1)]

    def draw(number: int) -> None:
        frame.clear("points")
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<"
        for draw_part in draws:
            draw_part(number)

    return draw


def _prepare_part(frame: Frame, part: Part, number_of_part: int) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/surface.vert", "pass/points.frag", {}, {})
    mesh = frame.ctx.vertex_array(
        program,
        [
            (frame.ctx.buffer(part.mesh.positions.tobytes()), "3f", "position"),
            (frame.ctx.buffer(part.mesh.normals.tobytes()), "3f", "normal"),
        ],
        index_buffer=frame.ctx.buffer(part.mesh.triangles.tobytes()),
    )
    projection = view_projection(frame.scene)

    def draw(number: int) -> None:
        values = {"view_projection": projection, "jitter_ndc": jitter_ndc(frame.scene, number), "part": number_of_part}
        set_uniforms(program, values)
        frame.draw_in_tiles("points", lambda: mesh.render(moderngl.TRIANGLES))

    return draw
