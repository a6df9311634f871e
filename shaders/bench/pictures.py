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
from ..scene import Scene
from .case import MATERIALS, Case
from .difference import Difference, check_flip, difference
from .textbook import Textbook

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
    - `gain`: by how much four times the samples divide the truth's RMSE; None for fewer than two numbers of samples.
    """

    material: str
    roughness: float
    environment: str
    truth_error: float
    points: tuple[Point, ...]
    surface_ratio: float | None
    frame_ratio: float | None
    gain: float | None

    def of(self, method: str) -> list[Point]:
        return [point for point in self.points if point.method == method]


@dataclasses.dataclass(frozen=True)
class PictureSettings:
    """What is measured.

    - `environments`: names or files.
    - `roughness`: of GGX.
    - `size`, `timed_size`: pixels a side of the compared pictures, and of those that are timed against the textbook.
    - `frames`: timed ones.
    - `samples`: of the truth, ascending; none leave out the truth and the still.
    - `error`, `seconds`: at which the truth itself is good enough.
    """

    environments: Sequence[str]
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
        for material in MATERIALS:
            for roughness in settings.roughness:
                say(f"{material}, roughness {roughness:g}, {light.name}")
                rows.append(_row(Case(material, roughness, light), textbook, renderer, settings, is_timed))
    return rows


def _row(case: Case, textbook: Textbook, renderer: Renderer, settings: PictureSettings, is_timed: bool) -> CaseRow:
    truth, error = _truth(case, settings)
    scene = dataclasses.replace(case.scene("interactive", settings.size), sky="none")
    times = _race(case, scene, textbook, renderer, max(settings.frames, 3))
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
    name = case.environment.name
    row = CaseRow(case.material, case.roughness, name, error, tuple(points), ratios["surface"], ratios["frame"], None)
    return dataclasses.replace(row, gain=_gain(row.of("truth"), error))


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


def _gain(points: Sequence[Point], truth_error: float) -> float | None:
    """From the slope of log RMSE over log samples, without the truth's own error in the squares."""
    own = [(p.samples, p.difference.rmse**2 - truth_error**2) for p in points]
    known = [(samples, square) for samples, square in own if square > truth_error**2]
    if len({samples for samples, _ in known}) < 2:
        return None
    samples, squares = np.array(known).T
    slope = np.polyfit(np.log(samples), 0.5 * np.log(squares), 1)[0]
    return math.exp(-float(slope) * math.log(4))
