"""Runs a scene's plan: from `Scene` to `Image`, with the counts of what was done."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from .context import check, device
from .frame import Frame, check_size
from .image import Image
from .passes import PASSES
from .plan import FramePlan, plan
from .program import programs
from .scene import Scene

# Points of the sequence in one jittered frame: each is a direction that the material proposes and one to a light.
_SAMPLES_PER_FRAME = 8


def plan_of(scene: Scene) -> FramePlan:
    """The passes that a scene needs."""
    outputs = ["linear"] if scene.tone_map == "none" else ["linear", "display"]
    return plan([one.declare(scene) for one in PASSES], outputs)


def samples_in_frame(scene: Scene) -> int:
    """The light samples of one pixel in one jittered frame."""
    return 2 * _SAMPLES_PER_FRAME


def render(scene: Scene) -> Image:
    """The picture of a scene; the same scene gives the same picture on the same device.

    Use it for previews and for linear pictures alike: the light is sampled without bias from the model's GLSL twin
    alone, for whatever model it is.

    **Arguments:**

    - `scene`: see `Scene`.

    **Returns:** an `Image`.

    Raises `UserError` when there is no OpenGL 4.3, or when the picture or the environment is larger than its textures.
    """
    started = time.perf_counter()
    frame_plan = plan_of(scene)
    check_size(device(), scene)
    frames = -(-scene.samples // samples_in_frame(scene))
    frame = Frame(device(), scene, programs(), frames, _SAMPLES_PER_FRAME)
    compiled = frame.programs.compiled
    draw = {one.name: module.prepare(frame) for one, module in _modules(scene, frame_plan)}
    for number in range(frames):
        for one in frame_plan.passes:
            if one.every_frame:
                draw[one.name](number)
                check(frame.ctx, f"running the pass {one.name}")
        # A frame at a time: a queue of many would make a desktop's driver take the process for hung.
        frame.ctx.finish()
    for one in frame_plan.passes:
        if not one.every_frame:
            draw[one.name](0)
            check(frame.ctx, f"running the pass {one.name}")
    pixels = _channels(frame.read("linear"), scene)
    display = _channels(frame.read("display"), scene) if frame_plan.runs("tone_map") else None
    counts = {
        "passes": [one.name for one in frame_plan.passes],
        "dropped": frame_plan.dropped,
        "frames": frames,
        "samples": frames * samples_in_frame(scene),
        "draws": frame.draws,
        "programs_compiled": frame.programs.compiled - compiled,
        "seconds": time.perf_counter() - started,
    }
    return Image(pixels, display, frame.device.renderer, counts)


def _modules(scene: Scene, frame_plan: FramePlan):
    declared = [(module.declare(scene), module) for module in PASSES]
    return [(one, module) for one, module in declared if frame_plan.runs(one.name)]


def _channels(pixels: NDArray[np.float32], scene: Scene) -> NDArray[np.float32]:
    """Three channels under a sky, where every pixel is covered, else four."""
    return np.ascontiguousarray(pixels[..., :3]) if scene.sky else pixels
