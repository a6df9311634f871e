"""Draws the meshes, lit by blurred environments and by a sun apart, into the frame."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..buffers import KeptPixels
from ..culling import visible_parts
from ..drawing import bind_materials, material_names, mesh_name, prepare_parts
from ..frame import FIRST_BLUR, UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..round_lobes import RoundLobes, round_lobes
from ..scene import Part, Scene
from ..sun import is_narrow, light_of, sun_of
from ..view import environment_to_world, world_to_environment
from . import depth
from .blurs import cube_name
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
            sun = sun_of(scene.environment, lobes[i])
            reads |= {
                cube_name(scene, light_of(scene.environment, lobes[i], kernel), kernel) for kernel in lobes[i].kernels
            }
            if sun is not None:
                reads |= material_names(i, part)
        if depth.declare(scene).enabled:
            reads |= {"depth"}
    key = (scene.camera, scene.width, scene.height, scene.rotation, tuple(one.kernels for one in lobes))
    return Pass("surface_interactive", frozenset(reads), frozenset({"frame"}), key, enabled, every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of the frame; the number of the frame is 0."""

    def program_of(part: Part) -> moderngl.Program:
        lobes = round_lobes(part.twin)
        sun = sun_of(frame.scene.environment, lobes)
        narrow = ", ".join(str(is_narrow(lobes, kernel, sun)).lower() for kernel in lobes.kernels)
        defines = lobes.defines() | {"SUN": str(int(sun is not None)), "IS_NARROW": f"bool[]({narrow})"}
        generated = {"material": "" if sun is None else part.twin.text}
        return frame.programs.graphics("pass/surface.vert", "pass/interactive.frag", defines, generated)

    bind_material = bind_materials(frame)

    def bind(index: int) -> None:
        part = frame.visible[index]
        lobes = round_lobes(part.twin)
        sun = sun_of(frame.scene.environment, lobes)
        if sun is not None:
            bind_material(index)
            towards = environment_to_world(frame.scene) @ sun.direction
            light_values = {
                "sun_direction": tuple(towards),
                "sun_in_environment": tuple(sun.direction),
                "sun_irradiance": tuple(sun.irradiance),
                "sun_edge": sun.edge,
            }
            set_uniforms(program_of(part), light_values)
        for unit, kernel in enumerate(lobes.cubes, FIRST_BLUR):
            light = light_of(frame.scene.environment, lobes, kernel)
            frame.resource(cube_name(frame.scene, light, kernel), moderngl.TextureCube).use(unit)
        units = list(range(FIRST_BLUR, FIRST_BLUR + len(lobes.cubes)))
        frame.resource(lobes_name(index), KeptPixels).texture.use(UNITS["lobe_table"])
        textures = {"blurred": units, "lobe_table": UNITS["lobe_table"]}
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
