"""Tiers against the truth: how far each picture is from it, and how long it took.

The truth is the middle of a picture twice as wide: its pixels are drawn from other random points than those of the
pictures that are compared with it.
"""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..environment import load_environment
from ..renderer import Renderer
from ..round_lobes import round_lobes
from ..scene import Scene
from ..sun import sun_of
from .case import Case
from .difference import Difference, check_flip, difference
from .textbook import Textbook

# Of sRGB: where a truth is told from the truth no more.
RMSE_WANTED = 0.004
# Radians between frames that are timed: a frame like the one before would not be drawn.
_TURN = 1e-3


@dataclasses.dataclass(frozen=True)
class Point:
    """A picture: how it was made, its light samples, its difference from the truth and its milliseconds."""

    method: str
    samples: int
    difference: Difference
    milliseconds: float


@dataclasses.dataclass(frozen=True)
class CaseRow:
    """A material under a light.

    - `truth_error`: the RMS error that the truth estimates of itself, as `Difference.rmse`.
    - `points`: textbook, interactive, still, then the truth at growing numbers of samples.
    - `surface_ratio`, `frame_ratio`: time of interactive over textbook, of the surface pass and of all passes of a
      frame, at the timed size; None if it was not timed.
    - `look_ups`: of blurred environments in a pixel of the interactive tier; the textbook has four of textures.
    - `has_sun`: whether the interactive tier lights it by the environment's sun apart.
    - `gain`: by how much four times the samples divide the truth's RMSE; None for fewer than two numbers of samples.
    - `cost`: of as many samples as have the wanted RMSE (`RMSE_WANTED`), in frames of the interactive tier of that
      size, by the line through the logarithms of time and RMSE; None if it has not.
    """

    material: str
    roughness: float
    environment: str
    truth_error: float
    points: tuple[Point, ...]
    surface_ratio: float | None
    frame_ratio: float | None
    look_ups: int
    has_sun: bool
    gain: float | None
    cost: float | None

    def of(self, method: str) -> list[Point]:
        return [point for point in self.points if point.method == method]


@dataclasses.dataclass(frozen=True)
class PictureSettings:
    """What is measured.

    - `environments`: names or files.
    - `materials`: of `case.MATERIALS`.
    - `roughness`: of GGX.
    - `size`, `timed_size`: pixels a side of the compared pictures, and of those that are timed against the textbook.
    - `frames`: timed ones.
    - `samples`: of the truth, ascending; none leave out the truth and the still.
    - `error`, `seconds`: at which the truth itself is good enough.
    """

    environments: Sequence[str]
    materials: Sequence[str]
    roughness: Sequence[float]
    size: int
    timed_size: int
    frames: int
    samples: Sequence[int]
    error: float
    seconds: float


def measure_pictures(settings: PictureSettings, is_timed: bool, say: Callable[[str], None]) -> list[CaseRow]:
    """All materials, roughnesses and environments; `is_timed` races the interactive tier with the textbook too.

    Raises `UserError` without FLIP or OpenGL 4.3, or for an environment that cannot be used.
    """
    check_flip()
    rows = []
    for light in [load_environment(name) for name in settings.environments]:
        textbook, renderer = Textbook(light), Renderer()
        for material in settings.materials:
            for roughness in settings.roughness:
                say(f"{material}, roughness {roughness:g}, {light.name}")
                rows.append(_row(Case(material, roughness, light), textbook, renderer, settings, is_timed))
    return rows


def _row(case: Case, textbook: Textbook, renderer: Renderer, settings: PictureSettings, is_timed: bool) -> CaseRow:
    truth, error = _truth(case, settings)
    scene = dataclasses.replace(case.scene("interactive", settings.size), sky="none")
    times = _race(case, scene, textbook, renderer, settings.frames)
    drawn = {"textbook": textbook.render(case, scene)[0], "interactive": _display(renderer, scene)[0]}
    points = [
        Point(name, 0, difference(truth, drawn[name]), statistics.median(one["frame"] for one in times[name]))
        for name in drawn
    ]
    if settings.samples:
        tiers = [("still", None), *(("truth", samples) for samples in settings.samples)]
        for tier, samples in tiers:
            sampled = dataclasses.replace(scene, tier=tier, samples=samples)
            _display(renderer, dataclasses.replace(sampled, samples=1))  # compiles
            picture, counts = _display(renderer, sampled)
            points.append(
                Point(tier, counts["samples"], difference(truth, picture), sum(counts["milliseconds"].values()))
            )
    ratios: dict[str, float | None] = {"surface": None, "frame": None}
    if is_timed:
        raced = _race(case, case.scene("interactive", settings.timed_size), textbook, renderer, settings.frames)
        pairs = list(zip(raced["interactive"], raced["textbook"], strict=True))
        ratios = {name: statistics.median(ours[name] / theirs[name] for ours, theirs in pairs) for name in ratios}
    lobes = round_lobes(scene.parts[0].twin)
    sampled = [point for point in points if point.method == "truth"]
    gain, frames = convergence(sampled, error, points[1].milliseconds)
    return CaseRow(
        case.material,
        case.roughness,
        case.environment.name,
        error,
        tuple(points),
        ratios["surface"],
        ratios["frame"],
        len(lobes.kernels),
        sun_of(case.environment, lobes) is not None,
        gain,
        frames,
    )


def _truth(case: Case, settings: PictureSettings) -> tuple[NDArray[np.float32], float]:
    wide = dataclasses.replace(
        case.scene("truth", settings.size),
        width=2 * settings.size,
        sky="none",
        error=settings.error,
        seconds=settings.seconds,
    )
    picture, counts = _display(Renderer(), wide)
    left = settings.size // 2
    return np.ascontiguousarray(picture[:, left : left + settings.size]), float(counts["error"])


def _display(renderer: Renderer, scene: Scene) -> tuple[NDArray[np.float32], dict[str, Any]]:
    image = renderer.render(scene)
    assert image.display is not None
    return image.display, image.counts


def _race(
    case: Case, scene: Scene, textbook: Textbook, renderer: Renderer, frames: int
) -> Mapping[str, list[dict[str, float]]]:
    """Milliseconds of the surface pass and of the frame by contestant, drawn by turns; the first is not counted."""
    found: dict[str, list[dict[str, float]]] = {"textbook": [], "interactive": []}
    for number in range(frames + 1):
        turned = dataclasses.replace(scene, rotation=_TURN * (number + 1))
        for name, times in (
            ("textbook", textbook.render(case, turned)[1]),
            ("interactive", renderer.render(turned).counts["milliseconds"]),
        ):
            surface = sum(value for key, value in times.items() if key.startswith("surface"))
            if number:
                found[name].append({"surface": surface, "frame": sum(times.values())})
    return found


def convergence(points: Sequence[Point], truth_error: float, frame_ms: float) -> tuple[float | None, float | None]:
    """`CaseRow.gain` and `cost`, by lines through logarithms, the truth's own error taken off the squares."""
    own = [(p.samples, p.milliseconds / frame_ms, p.difference.rmse**2 - truth_error**2) for p in points]
    # Below the truth's own error nothing is known.
    known = [one for one in own if one[2] > truth_error**2]
    if len({samples for samples, _, _ in known}) < 2:
        return None, None
    samples, cost, squares = np.log(np.array(known)).T
    gain = math.exp(-0.5 * float(np.polyfit(samples, squares, 1)[0]) * math.log(4))
    # The times of few samples are those of one frame, which has more than samples to it: only the last two count.
    slope = (cost[-1] - cost[-2]) / (squares[-1] - squares[-2])
    wanted = cost[-1] + slope * (2 * math.log(RMSE_WANTED) - squares[-1])
    return gain, math.exp(float(wanted))
