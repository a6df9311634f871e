"""Shading the points that are seen: what the tiers that add up frames share."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any

import moderngl

from .culling import visible_parts
from .drawing import bind_materials, block_name, table_name
from .frame import UNITS, Frame
from .plan import Pass
from .program import set_uniforms
from .scene import Scene
from .tiers import effort
from .view import world_to_environment


def declare_shading(name: str, scene: Scene, light: Iterable[str], key: Hashable, enabled: bool) -> Pass:
    """A pass that writes `frame` from the points, the visible parts' materials and the resources with the light."""
    parts = visible_parts(scene)
    reads = {"points", *light, *(block_name(i) for i in range(len(parts)))}
    reads |= {table_name(i, j) for i, part in enumerate(parts) for j in range(len(part.twin.buffers))}
    texts = tuple(part.twin.text for part in parts)
    whole_key = (scene.camera, scene.width, scene.height, scene.rotation, texts, effort(scene).points, key)
    return Pass(name, frozenset(reads), frozenset({"frame"}), whole_key, enabled, every_frame=True)


def prepare_shading(
    frame: Frame,
    shader: str,
    values: Mapping[str, Any],
    bind_light: Callable[[], None],
    defines: Mapping[str, str],
) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the directions of light.

    **Arguments:**

    - `frame`: whose points and materials are made.
    - `shader`: the fragment shader, which includes `glsl/shading_point.glsl`.
    - `values`: its uniforms, beside those of every such shader.
    - `bind_light`: called before each frame, binds the light that it reads.
    - `defines`: what the shader is compiled with.
    """
    programs = [
        frame.programs.graphics("pass/full_screen.vert", shader, defines, {"material": part.twin.text})
        for part in frame.visible
    ]
    bind_material = bind_materials(frame)
    shared = {
        "points_position": UNITS["points_position"],
        "points_normal": UNITS["points_normal"],
        "world_to_environment": world_to_environment(frame.scene),
        "camera_position": frame.scene.camera.position,
        "samples": effort(frame.scene).points,
        **values,
    }

    def draw(number: int) -> None:
        frame.clear("frame")
        frame.ctx.enable_only(moderngl.DEPTH_TEST)
        # The triangle at the far plane lies behind every point, and nowhere else: other pixels are skipped at once.
        frame.ctx.depth_func = ">"
        frame.bind_picture("points")
        bind_light()
        seed, first = frame.sequence(number)
        for index, program in enumerate(programs):
            set_uniforms(program, shared | {"part": index + 1, "seed": seed, "first": first})
            bind_material(index)
            frame.draw_full_screen("frame", program)

    return draw
