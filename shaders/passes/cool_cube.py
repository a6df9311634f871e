"""Makes the environment's cube map without its hot lights."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..blurs import make_sky_cube
from ..environment import Environment
from ..frame import Frame
from ..lighting import upload_radiance
from ..plan import Pass
from ..scene import Scene
from .hot_lights import lights_of
from .sky_cube import fill_levels


def declare(scene: Scene) -> Pass:
    """Writes `cool_cube`, a cube map as `sky_cube` is, if there are hot lights."""
    enabled = lights_of(scene) is not None
    key = scene.environment.digest if enabled else None
    return Pass("cool_cube", frozenset(), frozenset({"cool_cube"}), key, enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload of a picture clamped before its texels are interpolated, as the lights are, and its projection."""

    def draw(number: int) -> None:
        lights, environment = lights_of(frame.scene), frame.scene.environment
        assert lights is not None
        cool = Environment(np.minimum(environment.pixels, np.float32(lights.limit)), environment.name)
        cube = make_sky_cube(frame.ctx, frame.programs, upload_radiance(frame.ctx, cool))
        fill_levels(frame, cube)
        frame.keep("cool_cube", cube)
        frame.bytes_uploaded += cool.pixels.nbytes

    return draw
