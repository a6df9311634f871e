"""Uploads the environment's picture without its sun, which narrow lobes need that are lit by the sun apart."""

from __future__ import annotations

from collections.abc import Callable

from ..blurs import is_sampled, is_sharp
from ..frame import Frame
from ..lighting import upload_radiance
from ..plan import Pass
from ..scene import Scene
from ..sun import find_sun
from .blurs import wanted_blurs


def declare(scene: Scene) -> Pass:
    """Writes `sunless`, a texture."""
    enabled = any(
        light is not scene.environment and (is_sampled(kernel) or is_sharp(kernel))
        for light, kernel in wanted_blurs(scene)
    )
    return Pass("sunless", frozenset(), frozenset({"sunless"}), scene.environment.digest, enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload."""

    def draw(number: int) -> None:
        sun = find_sun(frame.scene.environment)
        assert sun is not None
        frame.keep("sunless", upload_radiance(frame.ctx, sun.rest))
        frame.bytes_uploaded += sun.rest.pixels.nbytes

    return draw
