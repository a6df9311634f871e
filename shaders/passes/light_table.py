"""Makes the table by which directions are chosen in proportion to the light from them."""

from __future__ import annotations

from collections.abc import Callable

from ..frame import Frame
from ..lighting import upload_light_table
from ..plan import Pass
from ..scene import Scene


def declare(scene: Scene) -> Pass:
    """Writes `light_table`, a `LightBuffers`, made of what `radiance` is made of."""
    return Pass("light_table", reads=frozenset({"radiance"}), writes=frozenset({"light_table"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The making, on the processor, and the upload."""

    def draw(number: int) -> None:
        made = upload_light_table(frame.ctx, frame.scene.environment)
        frame.keep("light_table", made)
        frame.bytes_uploaded += made.bytes_uploaded

    return draw
