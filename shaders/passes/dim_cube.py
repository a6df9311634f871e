"""Makes cube maps of the environment without its brightest texels, for narrow kernels."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import dim_name, is_sampled, make_dim_cube
from ..environment import Environment
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene
from .blurs import wanted_blurs


def declare(scene: Scene) -> Pass:
    """Writes a `dim_cube[...]` with all its levels per light that is blurred narrowly, made of `radiance`."""
    names = frozenset(map(dim_name, _lights(scene)))
    return Pass("dim_cube", reads=frozenset({"radiance"}), writes=names, enabled=bool(names))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The search for the brightest texels, on the processor, and the projection, on the device."""

    def draw(number: int) -> None:
        radiance = frame.resource("radiance", moderngl.Texture)
        for light in _lights(frame.scene):
            frame.keep(dim_name(light), make_dim_cube(frame.ctx, frame.programs, radiance, light))

    return draw


def _lights(scene: Scene) -> set[Environment]:
    return {light for light, kernel in wanted_blurs(scene) if is_sampled(kernel)}
