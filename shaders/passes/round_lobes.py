"""Uploads the round lobes of the visible parts' materials."""

from __future__ import annotations

from collections.abc import Callable

from ..buffers import KeptPixels
from ..culling import visible_parts
from ..frame import Frame
from ..plan import Pass
from ..round_lobes import round_lobes
from ..scene import Scene


def lobes_name(index: int) -> str:
    """The resource of the table of the visible part of this index."""
    return f"lobes[{index}]"


def declare(scene: Scene) -> Pass:
    """Writes a `lobes[i]` for every visible part; enabled for `scene.tier = "interactive"`."""
    enabled = scene.tier == "interactive"
    parts = visible_parts(scene) if enabled else ()
    names = frozenset(lobes_name(i) for i in range(len(parts)))
    key = tuple(round_lobes(part.twin) for part in parts)
    return Pass("round_lobes", frozenset(), names, key, enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of what has changed."""

    def draw(number: int) -> None:
        for i, part in enumerate(frame.visible):
            kept = frame.store.get(lobes_name(i))
            if not isinstance(kept, KeptPixels):
                frame.keep(lobes_name(i), kept := KeptPixels(frame.ctx))
            frame.bytes_uploaded += kept.update(round_lobes(part.twin).table())

    return draw
