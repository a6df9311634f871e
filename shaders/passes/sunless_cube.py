"""Makes the cube map of the environment without its sun."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import make_sky_cube
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene
from . import sunless


def declare(scene: Scene) -> Pass:
    """Writes `sunless_cube`, a cube map made of `sunless`."""
    enabled = sunless.declare(scene).enabled
    return Pass("sunless_cube", frozenset({"sunless"}), frozenset({"sunless_cube"}), enabled=enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The projection, on the device."""

    def draw(number: int) -> None:
        radiance = frame.resource("sunless", moderngl.Texture)
        frame.keep("sunless_cube", make_sky_cube(frame.ctx, frame.programs, radiance))

    return draw
