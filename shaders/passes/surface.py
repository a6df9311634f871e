"""Draws the meshes, lit by the environment, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..light_table import LightTable, light_table
from ..material_block import BINDING, glsl, pack
from ..plan import Pass
from ..scene import Part, Scene
from ..view import jitter_ndc, view_projection, world_to_environment


def declare(scene: Scene) -> Pass:
    return Pass("surface", reads=frozenset(), writes=frozenset({"frame"}), every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    table = light_table(frame.scene.environment.pixels)
    # In the order of their bindings in glsl/light_table.glsl.
    buffers = [frame.ctx.buffer(part.tobytes()) for part in (table.pdf, table.cells, table.cumulative, table.guide)]
    draws = [_prepare_part(frame, part, table) for part in frame.scene.parts]

    def draw(number: int) -> None:
        target = frame.picture("frame")
        target.use()
        target.clear()
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.bind_radiance()
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        for draw_part in draws:
            draw_part(number)

    return draw


def _prepare_part(frame: Frame, part: Part, table: LightTable) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/surface.vert", "pass/surface.frag", {}, {"material": glsl(part.material)})
    block = frame.ctx.buffer(pack(part.material))
    mesh = frame.ctx.vertex_array(
        program,
        [
            (frame.ctx.buffer(part.mesh.positions.tobytes()), "3f", "position"),
            (frame.ctx.buffer(part.mesh.normals.tobytes()), "3f", "normal"),
        ],
        index_buffer=frame.ctx.buffer(part.mesh.triangles.tobytes()),
    )
    projection = view_projection(frame.scene)
    rotation = world_to_environment(frame.scene)

    def draw(number: int) -> None:
        block.bind_to_uniform_block(BINDING)
        program["view_projection"] = projection
        program["world_to_environment"] = rotation
        program["camera_position"] = frame.scene.camera.position
        program["jitter_ndc"] = jitter_ndc(frame.scene, number)
        program["radiance"] = UNITS["radiance"]
        program["light_size"] = table.pdf.shape[::-1]
        program["light_guide_shift"] = 32 - (len(table.guide).bit_length() - 1)
        program["samples"] = frame.samples_per_frame
        program["frame_number"] = number
        program["frames"] = frame.frames
        mesh.render(moderngl.TRIANGLES)
        frame.draws += 1

    return draw
