"""What passes share while a scene is rendered: the context, programs and pictures."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import moderngl
import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .context import Device
from .program import Programs
from .scene import Scene

# Texture units by the name of the sampler in GLSL; a picture's sampler has the picture's name.
UNITS = {"radiance": 0, "frame": 1, "accumulation": 2, "linear": 3, "points_position": 4, "points_normal": 5}
# Pixels a side that one draw shades: a weak GPU needs well below the two seconds after which Windows resets a driver.
_TILE = 1024


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

    - `frames`: how often the jittered passes run.
    - `samples_per_frame`: points of the sequence in each.
    - `draws`: how often a tile was drawn so far.
    """

    device: Device
    scene: Scene
    programs: Programs
    frames: int
    samples_per_frame: int
    draws: int = 0
    _pictures: dict[str, moderngl.Framebuffer] = dataclasses.field(default_factory=dict)

    @property
    def ctx(self) -> moderngl.Context:
        return self.device.ctx

    def picture(self, name: str) -> moderngl.Framebuffer:
        """The framebuffer of a picture, cleared when it is made.

        The points have two attachments, position and normal, and a depth buffer that the frame shares.
        """
        if name not in self._pictures:
            size = (self.scene.width, self.scene.height)
            textures = [self.ctx.texture(size, 4, dtype="f4") for _ in range(2 if name == "points" else 1)]
            for texture in textures:
                texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            depth = None
            if name == "points":
                depth = self.ctx.depth_renderbuffer(size)
            elif name == "frame":
                depth = self.picture("points").depth_attachment
            self._pictures[name] = self.ctx.framebuffer(textures, depth)
            self._pictures[name].depth_mask = name == "points"
            self.clear(name)
        return self._pictures[name]

    def clear(self, name: str) -> None:
        """Sets a picture to 0, and its depth, if it owns one, to the far plane."""
        # Used before: a framebuffer that is not is cleared within the limits of another one's last tile.
        self.picture(name).use()
        self.picture(name).clear()

    def bind_picture(self, name: str) -> None:
        """Makes a picture readable by the sampler of its name."""
        texture = self.picture(name).color_attachments[0]
        assert isinstance(texture, moderngl.Texture)
        texture.use(UNITS[name])

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
