"""Uploads the meshes of the visible parts, each content once."""

from __future__ import annotations

from collections.abc import Callable

from ..culling import visible_parts
from ..drawing import mesh_name
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes a `mesh[...]` per content: the buffers of its positions, normals and triangles."""
    names = frozenset(mesh_name(part) for part in visible_parts(scene))
    return Pass("geometry", reads=frozenset(), writes=names)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of the meshes that are not there yet."""

    def draw(number: int) -> None:
        for part in frame.visible:
            if mesh_name(part) not in frame.store:
                arrays = (part.mesh.positions, part.mesh.normals, part.mesh.triangles)
                frame.keep(mesh_name(part), tuple(frame.ctx.buffer(array.tobytes()) for array in arrays))
                frame.bytes_uploaded += sum(array.nbytes for array in arrays)

    return draw
