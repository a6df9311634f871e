"""Uploads the materials' values: of each uniform block and table the bytes that differ from what is there."""

from __future__ import annotations

from collections.abc import Callable

from ..culling import visible_parts
from ..drawing import block_name, table_name
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes a `block[i]` for every visible part and a `table[i.j]` for every storage buffer of its material."""
    twins = [part.twin for part in visible_parts(scene)]
    names = {block_name(i) for i in range(len(twins))}
    names |= {table_name(i, j) for i, twin in enumerate(twins) for j in range(len(twin.buffers))}
    key = tuple((twin.block, twin.buffers) for twin in twins)
    return Pass("materials", reads=frozenset(), writes=frozenset(names), key=key)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of what has changed."""

    def draw(number: int) -> None:
        for i, part in enumerate(frame.visible):
            frame.upload(block_name(i), part.twin.block)
            for j, table in enumerate(part.twin.buffers):
                frame.upload(table_name(i, j), table)

    return draw
