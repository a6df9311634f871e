"""From the sum of frames to the linear picture: the mean, exposed."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    return Pass("resolve", reads=frozenset({"accumulation"}), writes=frozenset({"linear"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    program = frame.programs.graphics("pass/full_screen.vert", "pass/resolve.frag", {}, {})

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.NOTHING)
        frame.bind_picture("accumulation")
        program["accumulation"] = UNITS["accumulation"]
        program["mean"] = 1.0 / frame.frames
        program["exposure"] = 2.0**frame.scene.exposure
        frame.draw_full_screen("linear", program)

    return draw
