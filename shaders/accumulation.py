"""The sums of jittered frames: how good their mean is, and when they are enough.

Frames are added by turns to two sums, drawn from different random points. Half the difference of their means is as
large as the error of the mean of both: its square's mean estimates the squared error without bias, whatever the points
are, as long as the two are independent. Where nobody asks for the error there is one sum.
"""

from __future__ import annotations

import dataclasses
import math
import time

import numpy as np

from .frame import UNITS, Frame
from .lighting import Light
from .program import set_uniforms
from .tiers import effort, frames_at_most, samples_in_frame, wanted_error

# The pixels of one work group, a side, as in `glsl/pass/error.comp`.
_GROUP = 16
# The error is looked at after this many frames and each time that they have grown by the factor.
_FIRST_LOOK, _GROWTH = 8, 1.25


@dataclasses.dataclass
class Accumulation:
    """How far the sums `sum_even` and `sum_odd` have come.

    - `frames`: in both together.
    - `samples`: light samples of a pixel.
    - `error`: the estimated RMS error of the mean as it is displayed (the scene's exposure and tone map, sRGB-encoded,
      white being 1) over pixels and channels where a mesh is; `None` for a single sum.
    - `stopped`: why no more frames were added.
    """

    frames: int = 0
    samples: int = 0
    error: float | None = None
    stopped: str = ""


def sum_names(frame: Frame) -> tuple[str, ...]:
    """The pictures to which frames are added."""
    return ("sum_even", "sum_odd")[: effort(frame.scene).sums]


class Progress:
    """Decides after each frame whether there will be another one."""

    def __init__(self, frame: Frame, started: float):
        self._frame = frame
        self._deadline = math.inf if frame.scene.seconds is None else started + frame.scene.seconds
        light = frame.store.get("light_table")
        techniques = light.techniques if isinstance(light, Light) else 1
        self._samples = samples_in_frame(frame.scene, techniques)
        self._most = frames_at_most(frame.scene, techniques)
        self._error = wanted_error(frame.scene)
        self._next_look = _FIRST_LOOK

    def add(self, accumulation: Accumulation) -> bool:
        """Counts a frame that was added to its sum; returns whether these are enough and says why."""
        scene = self._frame.scene
        accumulation.frames += 1
        accumulation.samples += self._samples
        if accumulation.frames % effort(scene).sums:
            return False  # the sums must have as many frames
        if self._error is not None and accumulation.frames >= self._next_look:
            self._next_look = accumulation.frames * _GROWTH
            accumulation.error = estimated_error(self._frame, accumulation.frames)
            if accumulation.error <= self._error:
                accumulation.stopped = f"the error is at most {self._error:g}"
                return True
        if accumulation.frames >= self._most:
            accumulation.stopped = f"{accumulation.samples} samples were drawn"
            return True
        if time.perf_counter() >= self._deadline:
            accumulation.stopped = f"{scene.seconds:g} seconds had passed"
            return True
        return False


def estimated_error(frame: Frame, frames: int) -> float:
    """See `Accumulation.error`; `frames` are in both sums, as many in each."""
    defines = {"SKY": str(int(frame.scene.sky != "none")), "NEUTRAL": str(int(frame.scene.tone_map == "neutral"))}
    program = frame.programs.compute("pass/error.comp", defines, {})
    groups = tuple(-(-side // _GROUP) for side in (frame.scene.width, frame.scene.height))
    partial = frame.ctx.buffer(reserve=groups[0] * groups[1] * 8)
    for name in sum_names(frame):
        frame.bind_picture(name)
    values = {name: UNITS[name] for name in sum_names(frame)}
    set_uniforms(program, values | {"mean": 2.0 / frames, "exposure": 2.0**frame.scene.exposure})
    partial.bind_to_storage_buffer(0)
    program.run(*groups)
    frame.ctx.memory_barrier()
    squares, coverage = np.frombuffer(partial.read(), np.float32).reshape(-1, 2).astype(np.float64).sum(axis=0)
    return math.sqrt(squares / coverage) if coverage > 0 else 0.0
