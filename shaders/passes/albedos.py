"""Sums up the directional albedo of the visible parts' materials."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..culling import visible_parts
from ..drawing import bind_materials, block_name, table_name
from ..frame import Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene

# Of glsl/albedo.glsl.
BINDING = 2
# Viewers by the square root of cos_o, which is dense where the albedo changes most.
_COSINES = 64
# Rounds of 64 directions, and viewers around, by whether a material is brushed.
_ROUNDS = {False: 64, True: 32}
_AZIMUTHS = {False: 1, True: 32}


def albedo_defines(scene: Scene) -> dict[str, str]:
    """What `glsl/albedo.glsl` is compiled with: viewers around only if a part is brushed."""
    return {"COSINES": str(_COSINES), "AZIMUTHS": str(_AZIMUTHS[_is_brushed(scene)])}


def _is_brushed(scene: Scene) -> bool:
    return any(part.twin.is_anisotropic for part in visible_parts(scene))


def declare(scene: Scene) -> Pass:
    """Writes `albedos`, a storage buffer; enabled for `scene.tier = "still"`."""
    enabled = scene.tier == "still"
    parts = visible_parts(scene) if enabled else ()
    reads = {block_name(i) for i in range(len(parts))}
    reads |= {table_name(i, j) for i, part in enumerate(parts) for j in range(len(part.twin.buffers))}
    key = tuple((part.twin.text, part.twin.is_anisotropic) for part in parts)
    return Pass("albedos", frozenset(reads), frozenset({"albedos"}), key, enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The sums, on the device."""

    def draw(number: int) -> None:
        is_brushed = _is_brushed(frame.scene)
        viewers = _COSINES * _AZIMUTHS[is_brushed]
        albedos = frame.ctx.buffer(reserve=16 * viewers * max(len(frame.visible), 1))
        bind_material = bind_materials(frame)
        for index, part in enumerate(frame.visible):
            defines = {"ROUNDS": str(_ROUNDS[is_brushed])}
            program = frame.programs.compute("pass/albedo.comp", defines, {"material": part.twin.text})
            bind_material(index)
            albedos.bind_to_storage_buffer(BINDING)
            set_uniforms(program, {"offset": index * viewers})
            program.run(_COSINES, _AZIMUTHS[is_brushed])
        frame.ctx.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        frame.keep("albedos", albedos)

    return draw
