"""What passes share while a scene is rendered: the context, programs, resources and the counts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .buffers import KeptBuffer
from .context import Device
from .lighting import UNIT
from .program import Programs
from .scene import Part, Scene
from .tiers import effort, is_deferred

# Texture units by the name of the sampler in GLSL; a picture's sampler has the picture's name.
UNITS = {
    "radiance": UNIT,
    "frame": 1,
    "sum_even": 2,
    "sum_odd": 3,
    "linear": 4,
    "points_position": 5,
    "points_normal": 6,
    "sky_cube": 7,
    "cool_cube": 8,
    "lobe_table": 9,
}
# The first of those of a material's blurred environments, seven at most.
FIRST_BLUR = 10
# The attachments of a picture that has several.
_ATTACHMENTS = {"points": ("points_position", "points_normal")}
# Pixels a side that one draw shades: a weak GPU needs well below the two seconds after which Windows resets a driver.
_TILE = 1024
# More are an error on some software renderers.
_MULTISAMPLES = 4

T = TypeVar("T")


def check_size(device: Device, scene: Scene) -> None:
    """Raises `UserError` if a picture of the scene's size does not fit on the device."""
    limit = min(int(device.ctx.info[name]) for name in ("GL_MAX_TEXTURE_SIZE", "GL_MAX_RENDERBUFFER_SIZE"))
    for name, value in (("width", scene.width), ("height", scene.height)):
        if value > limit:
            raise UserError(
                f"`{name} = {value}` is more than the {limit} pixels a side that `{device.renderer}` can draw. "
                f"Set it to {limit} at most."
            )


@dataclasses.dataclass
class Frame:
    """The state of one rendering.

    - `visible`: the parts that are drawn.
    - `store`: the resources by name, also those of the frame before that this one needs.
    - `running`: the names of the passes that run.
    - `draws`: how often a tile was drawn so far.
    - `bytes_uploaded`: to the device so far.
    """

    device: Device
    scene: Scene
    programs: Programs
    visible: tuple[Part, ...]
    store: dict[str, Any]
    running: frozenset[str]
    draws: int = 0
    bytes_uploaded: int = 0

    @property
    def ctx(self) -> moderngl.Context:
        return self.device.ctx

    @property
    def samples_per_pixel(self) -> int:
        """Of the frame's edges; 0 where jittered frames smooth them."""
        return 0 if is_deferred(self.scene) else min(_MULTISAMPLES, self.ctx.max_samples)

    def resource(self, name: str, kind: type[T]) -> T:
        """A resource that an earlier pass has kept."""
        found = self.store[name]
        assert isinstance(found, kind)
        return found

    def keep(self, name: str, resource: object) -> None:
        """Makes a resource that this pass writes known to later passes, and to later frames."""
        self.store[name] = resource

    def upload(self, name: str, data: bytes) -> moderngl.Buffer:
        """A kept buffer with this content, of which only what differs from before is uploaded."""
        kept = self.store.get(name)
        if not isinstance(kept, KeptBuffer):
            kept = self.store[name] = KeptBuffer(self.ctx)
        self.bytes_uploaded += kept.update(data)
        return kept.buffer

    def sequence(self, number: int) -> tuple[int, int]:
        """Which of the sums a jittered frame is added to, and how many were added to it before."""
        index, seed = divmod(number, max(effort(self.scene).sums, 1))
        return seed, index

    def picture(self, name: str) -> moderngl.Framebuffer:
        """The framebuffer of a picture of the scene's size, cleared when it is made.

        The points have two attachments, position and normal, and a depth buffer, which the frame shares and does not
        write. Without points the frame has its own, and several samples per pixel.
        """
        kept = self.store.get(name)
        if not isinstance(kept, moderngl.Framebuffer) or not self._fits(name, kept):
            size = (self.scene.width, self.scene.height)
            samples = self.samples_per_pixel if name == "frame" else 0
            textures = [self.ctx.texture(size, 4, dtype="f4", samples=samples) for _ in _attachments(name)]
            for texture in textures:
                if not samples:
                    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            depth = None
            if self._shares_depth(name):
                depth = self.picture("points").depth_attachment
            elif name in ("points", "frame"):
                depth = self.ctx.depth_renderbuffer(size, samples=samples)
            # Bound before the one of another size is freed, else the first draw has its viewport (moderngl 5.13).
            made = self.ctx.framebuffer(textures, depth)
            made.depth_mask = not self._shares_depth(name)
            made.use()
            made.clear()
            self.store[name] = kept = made
        return kept

    def _shares_depth(self, name: str) -> bool:
        return name == "frame" and is_deferred(self.scene)

    def _fits(self, name: str, kept: moderngl.Framebuffer) -> bool:
        samples = self.samples_per_pixel if name == "frame" else 0
        shared = self.picture("points").depth_attachment if self._shares_depth(name) else None
        return (
            kept.size == (self.scene.width, self.scene.height)
            and kept.samples == samples
            and kept.depth_mask == (shared is None)
            and (shared is None or kept.depth_attachment is shared)
        )

    def clear(self, name: str) -> None:
        """Sets a picture to 0, and its depth, if it owns one, to the far plane."""
        # Used before: a framebuffer that is not is cleared within the limits of another one's last tile.
        self.picture(name).use()
        self.picture(name).clear()

    def bind_picture(self, name: str) -> None:
        """Makes a picture readable by the samplers of its attachments' names: its own if there is one."""
        for texture, sampler in zip(self.picture(name).color_attachments, _attachments(name), strict=True):
            assert isinstance(texture, moderngl.Texture)
            texture.use(UNITS[sampler])

    def read(self, name: str) -> NDArray[np.float32]:
        """The picture's pixels: shape (h, w, 4), row 0 at the top."""
        data = np.frombuffer(self.picture(name).read(components=4, dtype="f4"), np.float32)
        return np.ascontiguousarray(data.reshape(self.scene.height, self.scene.width, 4)[::-1])

    def draw_in_tiles(self, target: str, draw: Callable[[], None]) -> None:
        """Draws into a picture one tile after the other, and waits for each: no draw lasts long, whatever the size."""
        framebuffer = self.picture(target)
        framebuffer.use()
        for bottom in range(0, self.scene.height, _TILE):
            for left in range(0, self.scene.width, _TILE):
                if bottom or left:
                    self.ctx.finish()
                framebuffer.scissor = (left, bottom, _TILE, _TILE)
                draw()
                self.draws += 1
        framebuffer.scissor = (0, 0, self.scene.width, self.scene.height)

    def draw_full_screen(self, target: str, program: moderngl.Program) -> None:
        """Runs a program's fragment shader for every pixel of a picture."""
        triangle = self.ctx.vertex_array(program, [])
        self.draw_in_tiles(target, lambda: triangle.render(moderngl.TRIANGLES, vertices=3))


def _attachments(name: str) -> tuple[str, ...]:
    return _ATTACHMENTS.get(name, (name,))
