"""Uploads what is far brighter than the rest of the environment."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import Frame
from ..hot_lights import HotLights, find_hot_lights
from ..plan import Pass
from ..scene import Scene
from ..tiers import frames_at_most


def lights_of(scene: Scene) -> HotLights | None:
    """The hot lights of a still; `None` for other tiers and for light that has none."""
    if scene.tier != "still":
        return None
    return find_hot_lights(scene.environment, frames_at_most(scene, 1))


def declare(scene: Scene) -> Pass:
    """Writes `hot_lights`, a storage buffer, if there are any."""
    lights = lights_of(scene)
    key = (scene.environment.digest, len(lights.directions)) if lights else None
    return Pass("hot_lights", frozenset(), frozenset({"hot_lights"}), key, lights is not None)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of what has changed."""

    def draw(number: int) -> None:
        lights = lights_of(frame.scene)
        assert lights is not None
        frame.upload("hot_lights", lights.pack())

    return draw
