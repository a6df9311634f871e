"""From the sums of frames to the linear picture: the mean, exposed."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..accumulation import Accumulation, estimated_error, sum_names
from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene
from ..tiers import effort


def declare(scene: Scene) -> Pass:
    """Reads the sums, writes `linear`, shape (h, w, 4): linear Rec. 709, premultiplied by the coverage."""
    reads = frozenset(
        {"accumulation", "sum_even", "sum_odd"} if effort(scene).sums == 2 else {"accumulation", "sum_even"}
    )
    return Pass("resolve", reads, frozenset({"linear"}), key=(scene.exposure, scene.sky != "none"))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing after the last frame: colour is the mean times `2 ** exposure`; its argument is not used."""
    names = sum_names(frame)
    defines = {"SUMS": str(len(names)), "SKY": str(int(frame.scene.sky != "none"))}
    program = frame.programs.graphics("pass/full_screen.vert", "pass/resolve.frag", defines, {})
    accumulation = frame.resource("accumulation", Accumulation)

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.NOTHING)
        for name in names:
            frame.bind_picture(name)
        values = {name: UNITS[name] for name in names}
        exposure = 2.0**frame.scene.exposure
        set_uniforms(program, values | {"mean": 1.0 / accumulation.frames, "exposure": exposure})
        frame.draw_full_screen("linear", program)
        if len(names) == 2:
            accumulation.error = estimated_error(frame, accumulation.frames)

    return draw
