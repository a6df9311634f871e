"""Drawing the visible parts with their buffers bound; what all surface passes share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import moderngl

from .buffers import KeptBuffer
from .frame import Frame
from .program import set_uniforms
from .scene import Part
from .twin import BLOCK, FIRST_BUFFER
from .view import jitter_ndc, view_projection


def mesh_name(part: Part) -> str:
    """The resource of a part's mesh."""
    return f"mesh[{part.mesh.digest[:8]}]"


def block_name(index: int) -> str:
    """The resource of the uniform block of the visible part of this index."""
    return f"block[{index}]"


def table_name(index: int, table: int) -> str:
    """The resource of a storage buffer of the visible part of this index."""
    return f"table[{index}.{table}]"


def material_names(index: int, part: Part) -> set[str]:
    """The resources of all that the material of the visible part of this index reads."""
    return {block_name(index), *(table_name(index, table) for table in range(len(part.twin.buffers)))}


def prepare_parts(
    frame: Frame,
    program_of: Callable[[Part], moderngl.Program],
    values: Mapping[str, Any],
    bind: Callable[[int], None],
    target: str = "frame",
) -> Callable[[int], None]:
    """The drawing of all visible parts into a picture, called with the number of the jittered frame.

    **Arguments:**

    - `frame`: whose resources the passes `geometry` and `materials` have made.
    - `program_of`: the program of a part; its vertex shader is `pass/surface.vert`.
    - `values`: uniforms, beside those of the vertex shader.
    - `bind`: called with the index of a part before it is drawn, binds what its program reads.
    - `target`: the picture, which has a depth buffer.
    """
    projection = view_projection(frame.scene)
    draws = [_prepare(frame, part, program_of(part)) for part in frame.visible]

    def draw(number: int) -> None:
        seed, point = frame.sequence(number)
        own = {"view_projection": projection, "jitter_ndc": jitter_ndc(frame.scene, point, seed)}
        for index, (program, mesh) in enumerate(draws):
            set_uniforms(program, own | dict(values))
            bind(index)
            frame.draw_in_tiles(target, lambda mesh=mesh: mesh.render(moderngl.TRIANGLES))

    return draw


def bind_materials(frame: Frame) -> Callable[[int], None]:
    """What binds the uniform block and the tables of a part, as the pass `materials` has made them."""

    def bind(index: int) -> None:
        frame.resource(block_name(index), KeptBuffer).buffer.bind_to_uniform_block(BLOCK)
        for table in range(len(frame.visible[index].twin.buffers)):
            frame.resource(table_name(index, table), KeptBuffer).buffer.bind_to_storage_buffer(FIRST_BUFFER + table)

    return bind


def _prepare(frame: Frame, part: Part, program: moderngl.Program) -> tuple[moderngl.Program, moderngl.VertexArray]:
    positions, normals, triangles = frame.resource(mesh_name(part), tuple)
    # The depth alone needs no normals, and then the program does not have them.
    inputs = [
        (buffer, "3f", name) for buffer, name in ((positions, "position"), (normals, "normal")) if name in program
    ]
    return program, frame.ctx.vertex_array(program, inputs, index_buffer=triangles)
