"""Blurs the environment for the background."""

from __future__ import annotations

from collections.abc import Callable

from ..blurred_sky import blurred
from ..frame import Frame
from ..lighting import upload_radiance
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `blurred_sky`, a texture like `radiance`; enabled for `scene.sky = "blurred"`."""
    enabled = scene.sky == "blurred"
    writes = frozenset({"blurred_sky"})
    return Pass("blurred_sky", reads=frozenset(), writes=writes, key=scene.environment.digest, enabled=enabled)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The blur, on the processor, and the upload."""

    def draw(number: int) -> None:
        smooth = blurred(frame.scene.environment)
        frame.keep("blurred_sky", upload_radiance(frame.ctx, smooth))
        frame.bytes_uploaded += smooth.pixels.nbytes

    return draw
