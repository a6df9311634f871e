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
    """Reads the sums or the only frame; writes `linear`, (h, w, 4): linear Rec. 709, premultiplied by the coverage."""
    reads = {
        0: {"frame"},
        1: {"accumulation", "sum_even"},
        2: {"accumulation", "sum_even", "sum_odd"},
    }[effort(scene).sums]
    return Pass("resolve", frozenset(reads), frozenset({"linear"}), key=(scene.exposure, scene.sky != "none"))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing after the last frame: colour is the mean times `2 ** exposure`; its argument is not used."""
    names = sum_names(frame)
    samples = frame.samples_per_pixel
    defines = {"SUMS": str(len(names)), "SAMPLES": str(samples), "SKY": str(int(frame.scene.sky != "none"))}
    program = frame.programs.graphics("pass/full_screen.vert", "pass/resolve.frag", defines, {})
    added = frame.resource("accumulation", Accumulation).frames if names else max(samples, 1)

    def draw(number: int) -> None:
        frame.ctx.enable_only(moderngl.NOTHING)
        for name in names or ("frame",):
            frame.bind_picture(name)
        values = {name: UNITS[name] for name in names or ("frame",)}
        exposure = 2.0**frame.scene.exposure
        set_uniforms(program, values | {"mean": 1.0 / added, "exposure": exposure})
        frame.draw_full_screen("linear", program)
        if len(names) == 2:
            frame.resource("accumulation", Accumulation).error = estimated_error(frame, added)

    return draw
