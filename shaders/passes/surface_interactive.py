"""Draws the meshes, lit by blurred environments, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import blur_name
from ..buffers import KeptPixels
from ..culling import visible_parts
from ..drawing import mesh_name, prepare_parts
from ..frame import FIRST_BLUR, UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..round_lobes import RoundLobes, round_lobes
from ..scene import Part, Scene
from ..view import world_to_environment
from . import depth
from .round_lobes import lobes_name


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): the radiance of the meshes with coverage 1, and 0 where none is."""
    enabled = scene.tier == "interactive"
    reads: set[str] = set()
    lobes: list[RoundLobes] = []
    if enabled:
        parts = visible_parts(scene)
        lobes = [round_lobes(part.twin) for part in parts]
        for i, part in enumerate(parts):
            reads |= {mesh_name(part), lobes_name(i)}
            reads |= {blur_name(scene.environment, kernel) for kernel in round_lobes(part.twin).kernels}
        if depth.declare(scene).enabled:
            reads |= {"depth"}
    key = (scene.camera, scene.width, scene.height, scene.rotation, tuple(one.kernels for one in lobes))
    return Pass("surface_interactive", frozenset(reads), frozenset({"frame"}), key, enabled, every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of the frame; the number of the frame is 0."""

    def program_of(part: Part) -> moderngl.Program:
        defines = round_lobes(part.twin).defines()
        return frame.programs.graphics("pass/surface.vert", "pass/interactive.frag", defines, {})

    def bind(index: int) -> None:
        part = frame.visible[index]
        lobes = round_lobes(part.twin)
        for unit, kernel in enumerate(lobes.kernels, FIRST_BLUR):
            frame.resource(blur_name(frame.scene.environment, kernel), moderngl.TextureCube).use(unit)
        units = list(range(FIRST_BLUR, FIRST_BLUR + len(lobes.kernels)))
        frame.resource(lobes_name(index), KeptPixels).texture.use(UNITS["lobe_table"])
        textures = {"blurred": units if len(units) > 1 else units[0], "lobe_table": UNITS["lobe_table"]}
        set_uniforms(program_of(part), textures | lobes.uniforms())

    values = {
        "world_to_environment": world_to_environment(frame.scene),
        "camera_position": frame.scene.camera.position,
    }
    draw_parts = prepare_parts(frame, program_of, values, bind)

    def draw(number: int) -> None:
        if depth.NAME not in frame.running:
            frame.clear("frame")
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<="
        draw_parts(number)

    return draw
