"""The surface pass that samples the light: of the tiers that add up frames."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from .culling import visible_parts
from .drawing import bind_materials, block_name, mesh_name, prepare_parts, table_name
from .frame import UNITS, Frame
from .lighting import LightBuffers
from .passes import depth
from .plan import Pass
from .program import set_uniforms
from .scene import Scene
from .tiers import effort
from .view import world_to_environment


def declare_sampled(name: str, scene: Scene, enabled: bool) -> Pass:
    """A pass that writes `frame` from the visible parts, the light and its table."""
    parts = visible_parts(scene)
    reads = {"radiance", "light_table"}
    for i, part in enumerate(parts):
        reads |= {mesh_name(part), block_name(i), *(table_name(i, j) for j in range(len(part.twin.buffers)))}
    if depth.declare(scene).enabled:
        reads |= {"depth"}
    texts = tuple(part.twin.text for part in parts)
    key = (scene.camera, scene.width, scene.height, scene.rotation, texts, effort(scene).per_frame)
    return Pass(name, frozenset(reads), frozenset({"frame"}), key, enabled, every_frame=True)


def prepare_sampled(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number: it decides the offset and the directions of light."""
    programs = {
        part.twin.text: frame.programs.graphics(
            "pass/surface.vert", "pass/surface.frag", {}, {"material": part.twin.text}
        )
        for part in frame.visible
    }
    light = frame.resource("light_table", LightBuffers)
    radiance = frame.resource("radiance", moderngl.Texture)
    values = {
        "world_to_environment": world_to_environment(frame.scene),
        "camera_position": frame.scene.camera.position,
        "radiance": UNITS["radiance"],
        "light_size": light.size,
        "light_guide_shift": light.guide_shift,
        "samples": effort(frame.scene).per_frame,
    }
    draw_parts = prepare_parts(frame, lambda part: programs[part.twin.text], values, bind_materials(frame))

    def draw(number: int) -> None:
        if depth.NAME not in frame.running:
            frame.picture("frame").clear()
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<="
        radiance.use(UNITS["radiance"])
        for binding, buffer in enumerate(light.buffers):
            buffer.bind_to_storage_buffer(binding)
        seed, first = frame.sequence(number)
        for program in programs.values():
            set_uniforms(program, {"seed": seed, "first": first})
        draw_parts(number)

    return draw
