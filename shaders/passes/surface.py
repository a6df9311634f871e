"""Draws the meshes, lit by the environment, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..lighting import Lighting, lighting
from ..material_block import BINDING
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Part, Scene
from ..twin import FIRST_BUFFER
from ..view import jitter_ndc, view_projection, world_to_environment


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    return Pass("surface", reads=frozenset(), writes=frozenset({"frame"}), every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number: it decides the offset and the directions of light.

    Raises `UserError` when the environment is larger than the device's textures.
    """
    light = lighting(frame.ctx, frame.scene.environment)
    draws = [_prepare_part(frame, part, light) for part in frame.scene.parts]

    def draw(number: int) -> None:
        target = frame.picture("frame")
        target.use()
        target.clear()
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        light.radiance.use(UNITS["radiance"])
        for binding, buffer in enumerate(light.buffers):
            buffer.bind_to_storage_buffer(binding)
        for draw_part in draws:
            draw_part(number)

    return draw


def _prepare_part(frame: Frame, part: Part, light: Lighting) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/surface.vert", "pass/surface.frag", {}, {"material": part.twin.text})
    block = frame.ctx.buffer(part.twin.block)
    own = [frame.ctx.buffer(data) for data in part.twin.buffers]
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
        for binding, buffer in enumerate(own, FIRST_BUFFER):
            buffer.bind_to_storage_buffer(binding)
        values = {
            "view_projection": projection,
            "world_to_environment": rotation,
            "camera_position": frame.scene.camera.position,
            "jitter_ndc": jitter_ndc(frame.scene, number),
            "radiance": UNITS["radiance"],
            "light_size": light.size,
            "light_guide_shift": light.guide_shift,
            "samples": frame.samples_per_frame,
            "frame_number": number,
            "frames": frame.frames,
        }
        set_uniforms(program, values)
        frame.draw_in_tiles("frame", lambda: mesh.render(moderngl.TRIANGLES))

    return draw
