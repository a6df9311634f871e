"""Runs a scene's plan: from `Scene` to `Image`, with what is kept between frames and the counts of what was done."""

from __future__ import annotations

import functools
import itertools
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .accumulation import Accumulation, Progress
from .context import check, device
from .culling import visible_parts
from .frame import Frame, check_size
from .image import Image
from .passes import PASSES, accumulate
from .plan import FramePlan, Pass, Version, plan
from .program import programs
from .scene import Scene
from .timing import PassTimes


class Renderer:
    """A context with its programs, and the resources of the last frame: what has not changed is not made again.

    It keeps what the last scene needed, and no more. Renderers of one process share its context and its programs, and
    are used from the thread that rendered first.
    """

    def __init__(self):
        self._store: dict[str, Any] = {}
        self._versions: dict[str, Version] = {}

    def render(self, scene: Scene) -> Image:
        """The picture of a scene; the same scene gives the same picture on the same device.

        Use it for previews and for linear pictures alike: the light is sampled from the model's GLSL twin alone, for
        whatever model it is.

        **Arguments:**

        - `scene`: see `Scene`.

        **Returns:** an `Image`.

        Raises `UserError` when there is no OpenGL 4.3, or when the picture or the environment is larger than its
        textures.
        """
        started = time.perf_counter()
        check_size(device(), scene)
        frame_plan = plan_of(scene, self._versions)
        self._forget(frame_plan)
        running = frozenset(one.name for one in frame_plan.passes)
        frame = Frame(device(), scene, programs(), visible_parts(scene), self._store, running)
        compiled = frame.programs.compiled
        times = PassTimes(frame.device)
        for is_looped, group in itertools.groupby(frame_plan.passes, lambda one: one.every_frame):
            passes = tuple(group)
            written = {name: frame_plan.versions[name] for one in passes for name in one.writes}
            # Until it is whole, what an interrupted pass leaves has no version.
            for name in written:
                self._versions.pop(name, None)
            if is_looped:
                _run_frames(frame, passes, times, started)
            else:
                _run_once(frame, passes, times)
            self._versions |= written
        pixels = _channels(frame.read("linear"), scene)
        display = _channels(frame.read("display"), scene) if scene.tone_map != "none" else None
        sums = self._store.get("accumulation") or Accumulation(frames=1, stopped="there is one frame")
        counts = {
            "tier": scene.tier,
            "passes": [one.name for one in frame_plan.passes],
            "reused": list(frame_plan.reused),
            "dropped": frame_plan.dropped,
            "draws": frame.draws,
            "culled_parts": len(scene.parts) - len(frame.visible),
            "bytes_uploaded": frame.bytes_uploaded,
            "programs_compiled": frame.programs.compiled - compiled,
            "milliseconds": times.total(),
            "frames": sums.frames,
            "samples": sums.samples,
            "error": sums.error,
            "stopped": sums.stopped,
            "seconds": time.perf_counter() - started,
        }
        return Image(pixels, display, frame.device.renderer, counts, frame_plan)

    def _forget(self, frame_plan: FramePlan) -> None:
        """Frees what the new scene does not have, so that what is kept does not grow with the scenes."""
        for name in self._store.keys() - frame_plan.versions.keys():
            del self._store[name]
        self._versions = {name: self._versions[name] for name in self._versions if name in self._store}


def render(scene: Scene) -> Image:
    """`Renderer.render` by the one renderer of this process."""
    return _renderer().render(scene)


@functools.cache
def _renderer() -> Renderer:
    return Renderer()


def plan_of(scene: Scene, kept: dict[str, Version]) -> FramePlan:
    """The passes that a scene needs when these versions of its resources are kept."""
    outputs = ["linear"] if scene.tone_map == "none" else ["linear", "display"]
    return plan([module.declare(scene) for module in PASSES], outputs, kept)


_MODULES = {module.__name__.rpartition(".")[2]: module for module in PASSES}


def _run_once(frame: Frame, passes: tuple[Pass, ...], times: PassTimes) -> None:
    for one in passes:
        with times.measure(one.name, waits=True):
            _MODULES[one.name].prepare(frame)(0)
        check(frame.ctx, f"running the pass {one.name}")


def _run_frames(frame: Frame, passes: tuple[Pass, ...], times: PassTimes, started: float) -> None:
    """Runs the passes for one jittered frame after the other until their sums are good enough."""
    draws = []
    for one in passes:
        with times.measure(one.name, waits=True):
            draws.append((one.name, _MODULES[one.name].prepare(frame)))
    progress = Progress(frame, started) if accumulate.NAME in frame.running else None
    for number in itertools.count():
        for name, draw in draws:
            with times.measure(name, waits=False):
                draw(number)
            check(frame.ctx, f"running the pass {name}")
        # A frame at a time: a queue of many would make a desktop's driver take the process for hung.
        frame.ctx.finish()
        if progress is None or progress.add(frame.resource("accumulation", Accumulation)):
            break


def _channels(pixels: NDArray[np.float32], scene: Scene) -> NDArray[np.float32]:
    """Three channels under a sky, where every pixel is covered, else four."""
    return pixels if scene.sky == "none" else np.ascontiguousarray(pixels[..., :3])
