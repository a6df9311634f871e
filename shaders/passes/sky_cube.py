"""Makes the environment's cube map."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import make_sky_cube
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `sky_cube`, a cube map with all its levels, made of `radiance`."""
    return Pass("sky_cube", reads=frozenset({"radiance"}), writes=frozenset({"sky_cube"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The projection, on the device."""

    def draw(number: int) -> None:
        frame.keep("sky_cube", make_sky_cube(frame.ctx, frame.programs, frame.resource("radiance", moderngl.Texture)))

    return draw
