"""Shades the points of the meshes that are seen, lit by the environment, into the frame."""

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
from ..view import world_to_environment


def declare(scene: Scene) -> Pass:
    """Reads `points`, writes `frame`, shape (h, w, 4): the meshes' radiance with coverage 1, and 0 where none is."""
    return Pass("surface", reads=frozenset({"points"}), writes=frozenset({"frame"}), every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the directions of light.

    Raises `UserError` when the environment is larger than the device's textures.
    """
    light = lighting(frame.ctx, frame.scene.environment)
    draws = [_prepare_part(frame, part, number, light) for number, part in enumerate(frame.scene.parts, 1)]

    def draw(number: int) -> None:
        frame.clear("frame")
        frame.ctx.enable_only(moderngl.DEPTH_TEST)
        # The triangle at the far plane lies behind every point, and nowhere else: other pixels are skipped at once.
        frame.ctx.depth_func = ">"
        light.radiance.use(UNITS["radiance"])
        for texture, name in zip(frame.picture("points").color_attachments, ("position", "normal"), strict=True):
            assert isinstance(texture, moderngl.Texture)
            texture.use(UNITS[f"points_{name}"])
        light.cells.bind_to_storage_buffer(0)
        for draw_part in draws:
            draw_part(number)

    return draw


def _prepare_part(frame: Frame, part: Part, number_of_part: int, light: Lighting) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/full_screen.vert", "pass/surface.frag", {}, {"material": part.twin.text})
    block = frame.ctx.buffer(part.twin.block)
    own = [frame.ctx.buffer(data) for data in part.twin.buffers]
    rotation = world_to_environment(frame.scene)

    def draw(number: int) -> None:
        block.bind_to_uniform_block(BINDING)
        for binding, buffer in enumerate(own, FIRST_BUFFER):
            buffer.bind_to_storage_buffer(binding)
        values = {
            "points_position": UNITS["points_position"],
            "points_normal": UNITS["points_normal"],
            "part": number_of_part,
            "world_to_environment": rotation,
            "camera_position": frame.scene.camera.position,
            "radiance": UNITS["radiance"],
            "light_size": light.size,
            "light_shift": light.shift,
            "light_block": light.block,
            "samples": frame.samples_per_frame,
            "techniques": 1 if light.is_even else 2,
            "first": number,
            "seed": 0,
        }
        set_uniforms(program, values)
        frame.draw_full_screen("frame", program)

    return draw
