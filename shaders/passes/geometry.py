"""Uploads the meshes of the visible parts, each content once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..culling import visible_parts
from ..drawing import mesh_name
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes a `mesh[...]` per content: the buffers of its vertices, position and normal in turn, and triangles."""
    names = frozenset(mesh_name(part) for part in visible_parts(scene))
    return Pass("geometry", reads=frozenset(), writes=names)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of the meshes that are not there yet."""

    def draw(number: int) -> None:
        for part in frame.visible:
            if mesh_name(part) not in frame.store:
                vertices = np.concatenate([part.mesh.positions, part.mesh.normals], axis=1, dtype=np.float32).tobytes()
                triangles = part.mesh.triangles.tobytes()
                frame.keep(mesh_name(part), (frame.ctx.buffer(vertices), frame.ctx.buffer(triangles)))
                frame.bytes_uploaded += len(vertices) + len(triangles)

    return draw
