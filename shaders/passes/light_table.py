"""Makes the table by which directions are chosen in proportion to the light from them."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import Frame
from ..lighting import upload_light
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `light_table`, a `Light`: the list and its own picture, whose alpha is the density."""
    return Pass("light_table", reads=frozenset(), writes=frozenset({"light_table"}), key=scene.environment.digest)


def prepare(frame: Frame) -> Callable[[int], None]:
    """The making, on the processor, and the upload.

    Raises `UserError` when the environment is larger than the device's textures.
    """

    def draw(number: int) -> None:
        made = upload_light(frame.ctx, frame.scene.environment)
        frame.keep("light_table", made)
        frame.bytes_uploaded += made.bytes_uploaded

    return draw
