"""Uploads the round lobes of the visible parts' materials."""

from __future__ import annotations

from collections.abc import Callable

from ..culling import visible_parts
from ..frame import Frame
from ..plan import Pass
from ..round_lobes import round_lobes
from ..scene import Scene


def lobes_name(index: int) -> str:
    """The resource of the uniform block of the visible part of this index."""
    return f"lobes[{index}]"


def declare(scene: Scene) -> Pass:
    """Writes a `lobes[i]` for every visible part; enabled for `scene.tier = "interactive"`."""
    enabled = scene.tier == "interactive"
    parts = visible_parts(scene) if enabled else ()
    names = frozenset(lobes_name(i) for i in range(len(parts)))
    key = tuple(round_lobes(part.twin).pack() for part in parts)
    return Pass("round_lobes", frozenset(), names, key, enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of what has changed."""

    def draw(number: int) -> None:
        for i, part in enumerate(frame.visible):
            frame.upload(lobes_name(i), round_lobes(part.twin).pack())

    return draw
