"""Adds the frame to the sum of frames."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Adds `frame` to `accumulation`, shape (h, w, 4), after every jittered frame."""
    return Pass("accumulate", reads=frozenset({"frame"}), writes=frozenset({"accumulation"}), every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame: it adds colour and coverage to their sums; its argument is not used."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/accumulate.frag", {}, {})

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.BLEND)
        frame.ctx.blend_func = moderngl.ONE, moderngl.ONE
        frame.bind_picture("frame")
        set_uniforms(program, {"frame": UNITS["frame"]})
        frame.draw_full_screen("accumulation", program)

    return draw
