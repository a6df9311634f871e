"""Makes the environment's cube map without its brightest texels, for narrow kernels."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import make_dim_cube
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `dim_cube`, a cube map with all its levels, made of `radiance`."""
    return Pass("dim_cube", reads=frozenset({"radiance"}), writes=frozenset({"dim_cube"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The search for the brightest texels, on the processor, and the projection, on the device."""

    def draw(number: int) -> None:
        radiance = frame.resource("radiance", moderngl.Texture)
        frame.keep("dim_cube", make_dim_cube(frame.ctx, frame.programs, radiance, frame.scene.environment))

    return draw
