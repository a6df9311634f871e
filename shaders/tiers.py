"""How much each tier draws: points of the sequence in a frame, and how many frames."""

from __future__ import annotations

import dataclasses

from .scene import Scene


@dataclasses.dataclass(frozen=True)
class Effort:
    """What a tier draws.

    - `points`: of the sequence in one jittered frame. Each is a direction that the material proposes and, for the
      truth, one to a light.
    - `samples`: of one pixel in all frames together, unless the scene says otherwise.
    - `sums`: 2 if frames are added up by turns in two sums, from whose difference the error is known; 0 if there is
      one frame and nothing to add up.
    - `error`: at which it stops, unless the scene says otherwise; `None` if it does not ask.
    """

    points: int
    samples: int
    sums: int
    error: float | None


EFFORTS = {
    "interactive": Effort(points=0, samples=0, sums=0, error=None),
    "still": Effort(points=4, samples=64, sums=1, error=None),
    "truth": Effort(points=8, samples=512, sums=2, error=0.005),
}
# The most of a truth that is asked for an error or a time: hours, for a picture that cannot reach them.
_SAMPLES_MAX = 1 << 20


def effort(scene: Scene) -> Effort:
    """What the scene's tier draws; a truth of a fixed number of samples is one sum.

    Two sums have to be independent of each other, and so are less evenly spread: they need about 1.3 times the samples
    of one. That is the price of an error that is known, paid where it is asked for.
    """
    tier = EFFORTS[scene.tier]
    if tier.error is not None and scene.error is None and scene.samples is not None:
        return dataclasses.replace(tier, sums=1, error=None)
    return tier


def is_deferred(scene: Scene) -> bool:
    """Whether the points that are seen are found before they are shaded, which pays where shading is costly."""
    return scene.tier != "interactive"


def samples_in_frame(scene: Scene, techniques: int) -> int:
    """The light samples of one pixel in one jittered frame: `techniques` (1 or 2) for each point."""
    return techniques * effort(scene).points


def wanted_error(scene: Scene) -> float | None:
    """The error at which frames are enough; `None` if their number is fixed."""
    return effort(scene).error if scene.error is None else scene.error


def frames_at_most(scene: Scene, techniques: int) -> int:
    """How many frames are drawn if no error and no time stops them; as many in each sum."""
    samples = scene.samples
    if samples is None:
        is_open = scene.error is not None or scene.seconds is not None
        samples = _SAMPLES_MAX if is_open else effort(scene).samples
    sums = effort(scene).sums
    return sums * -(-samples // (sums * samples_in_frame(scene, techniques)))
