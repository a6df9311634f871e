"""Uploads the environment's picture."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import Frame
from ..lighting import upload_radiance
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `radiance`, a texture."""
    return Pass("environment", reads=frozenset(), writes=frozenset({"radiance"}), key=scene.environment.digest)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The upload.

    Raises `UserError` when the environment is larger than the device's textures.
    """

    def draw(number: int) -> None:
        frame.keep("radiance", upload_radiance(frame.ctx, frame.scene.environment))
        frame.bytes_uploaded += frame.scene.environment.pixels.nbytes

    return draw
