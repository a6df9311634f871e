"""What passes share while a scene is rendered: the context, programs, pictures, the environment on the GPU."""

from __future__ import annotations

import dataclasses

import moderngl
import numpy as np
from numpy.typing import NDArray

from brdf.errors import UserError

from .context import Device
from .program import Programs
from .scene import Scene

# Texture units by the name of the sampler in GLSL; a picture's sampler has the picture's name.
UNITS = {"radiance": 0, "frame": 1, "accumulation": 2, "linear": 3}


@dataclasses.dataclass
class Frame:
    """The state of one rendering.

    - `frames`: how often the jittered passes run.
    - `samples_per_frame`: light samples in each from the cosine, from the environment, and from each slope.
    - `draws`: counted by the passes.
    """

    device: Device
    scene: Scene
    programs: Programs
    frames: int
    samples_per_frame: tuple[int, int, int]
    draws: int = 0
    _pictures: dict[str, moderngl.Framebuffer] = dataclasses.field(default_factory=dict)
    _radiance: moderngl.Texture | None = None

    @property
    def ctx(self) -> moderngl.Context:
        return self.device.ctx

    def picture(self, name: str) -> moderngl.Framebuffer:
        """The framebuffer of a picture, cleared when it is made; it has a depth buffer if it is the frame."""
        if name not in self._pictures:
            size = (self.scene.width, self.scene.height)
            texture = self.ctx.texture(size, 4, dtype="f4")
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            depth = self.ctx.depth_renderbuffer(size) if name == "frame" else None
            self._pictures[name] = self.ctx.framebuffer([texture], depth)
            self._pictures[name].clear()
        return self._pictures[name]

    def bind_picture(self, name: str) -> None:
        """Makes a picture readable by the sampler of its name."""
        texture = self.picture(name).color_attachments[0]
        assert isinstance(texture, moderngl.Texture)
        texture.use(UNITS[name])

    def read(self, name: str) -> NDArray[np.float32]:
        """The picture's pixels: shape (h, w, 4), row 0 at the top."""
        data = np.frombuffer(self.picture(name).read(components=4, dtype="f4"), np.float32)
        return np.ascontiguousarray(data.reshape(self.scene.height, self.scene.width, 4)[::-1])

    def bind_radiance(self) -> None:
        """Uploads the environment's pixels on the first call, and binds them to their sampler."""
        if self._radiance is None:
            pixels = self.scene.environment.pixels
            limit = int(self.ctx.info["GL_MAX_TEXTURE_SIZE"])
            if pixels.shape[1] > limit:
                name = self.scene.environment.name
                raise UserError(f"`{name}` is wider than this device's {limit} texels. Resize it.")
            self._radiance = self.ctx.texture((pixels.shape[1], pixels.shape[0]), 3, pixels.tobytes(), dtype="f4")
            self._radiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._radiance.repeat_x, self._radiance.repeat_y = True, False
        self._radiance.use(UNITS["radiance"])

    def draw_full_screen(self, target: str, program: moderngl.Program) -> None:
        """Runs a program's fragment shader for every pixel of a picture."""
        self.picture(target).use()
        self.ctx.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
        self.draws += 1
