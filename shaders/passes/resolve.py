"""From the sum of frames to the linear picture: the mean, exposed."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Reads `accumulation`, writes `linear`, shape (h, w, 4): linear Rec. 709, premultiplied by the coverage."""
    return Pass("resolve", reads=frozenset({"accumulation"}), writes=frozenset({"linear"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing after the last frame: colour is the mean times `2 ** exposure`; its argument is not used."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/resolve.frag", {}, {})

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.NOTHING)
        frame.bind_picture("accumulation")
        exposure = 2.0**frame.scene.exposure
        set_uniforms(program, {"accumulation": UNITS["accumulation"], "mean": 1.0 / frame.frames, "exposure": exposure})
        frame.draw_full_screen("linear", program)

    return draw
