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
    """Writes a `dim_cube[...]` with all its levels per light that is blurred narrowly, made of its picture."""
    lights = _lights(scene)
    pictures = frozenset(_picture(scene, light) for light in lights)
    return Pass("dim_cube", pictures, frozenset(map(dim_name, lights)), enabled=bool(lights))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The search for the brightest texels, on the processor, and the projection, on the device."""

    def draw(number: int) -> None:
        for light in _lights(frame.scene):
            radiance = frame.resource(_picture(frame.scene, light), moderngl.Texture)
            frame.keep(dim_name(light), make_dim_cube(frame.ctx, frame.programs, radiance, light))

    return draw


def _lights(scene: Scene) -> set[Environment]:
    return {light for light, kernel in wanted_blurs(scene) if is_sampled(kernel)}


def _picture(scene: Scene, light: Environment) -> str:
    return "radiance" if light is scene.environment else "sunless"
