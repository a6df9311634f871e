"""From the linear picture to one for displays: Khronos PBR Neutral and sRGB."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Reads `linear`, writes `display`, shape (h, w, 4): sRGB in [0, 1], not premultiplied, and the coverage."""
    enabled = scene.tone_map == "neutral"
    return Pass("tone_map", frozenset({"linear"}), frozenset({"display"}), enabled=enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing after the last frame; its argument is not used."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/tone_map.frag", {}, {})

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.NOTHING)
        frame.bind_picture("linear")
        set_uniforms(program, {"linear": UNITS["linear"]})
        frame.draw_full_screen("display", program)

    return draw
