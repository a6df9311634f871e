"""Adds the frame to a sum of frames."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..accumulation import Accumulation, sum_names
from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene
from ..tiers import effort

NAME = "accumulate"


def declare(scene: Scene) -> Pass:
    """Writes `accumulation`: adds `frame` to the picture `sum_even` or, by turns, `sum_odd`, and counts.

    The exposure is no part of the key although the error is judged by it: another one shows the same sums.
    """
    sums = ("sum_even", "sum_odd")[: effort(scene).sums]
    key = (scene.tier, scene.error, scene.seconds, scene.samples)
    writes = frozenset({"accumulation", *sums})
    enabled = effort(scene).sums > 0
    return Pass(NAME, frozenset({"frame"}), writes, key, enabled, every_frame=True)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame: it adds colour and coverage to the sum that the frame's number names."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/accumulate.frag", {}, {})
    frame.keep("accumulation", Accumulation())
    for name in sum_names(frame):
        frame.clear(name)

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.BLEND)
        frame.ctx.blend_func = moderngl.ONE, moderngl.ONE
        frame.bind_picture("frame")
        set_uniforms(program, {"frame": UNITS["frame"]})
        frame.draw_full_screen(sum_names(frame)[frame.sequence(number)[0]], program)

    return draw
