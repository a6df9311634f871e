"""Draws the environment into the frame wherever no mesh is."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..frame import UNITS, Frame
from ..plan import Pass
from ..program import set_uniforms
from ..scene import Scene
from ..tiers import is_deferred
from ..view import jitter_ndc, view_rays, world_to_environment


def declare(scene: Scene) -> Pass:
    """Writes `frame`, shape (h, w, 4): radiance with coverage 0 where no mesh is; disabled for `scene.sky = "none"`.

    Reads the depth of `points`, which is the frame's, if there are points.
    """
    return Pass(
        "sky",
        reads=frozenset({_texture(scene), *(("points",) if is_deferred(scene) else ())}),
        writes=frozenset({"frame"}),
        key=(scene.camera, scene.width, scene.height, scene.rotation),
        enabled=scene.sky != "none",
        every_frame=True,
    )


def _texture(scene: Scene) -> str:
    return "blurred_sky" if scene.sky == "blurred" else "radiance"


def prepare(frame: Frame) -> Callable[[int], None]:
    """The drawing of one frame, called with its number, which decides the offset within the pixels."""
    program = frame.programs.graphics("pass/full_screen.vert", "pass/sky.frag", {}, {})
    radiance = frame.resource(_texture(frame.scene), moderngl.Texture)
    rays = view_rays(frame.scene)
    rotation = world_to_environment(frame.scene)

    def draw(number: int) -> None:
        # At the far plane, and after the meshes: only pixels that they left are shaded.
        frame.ctx.enable_only(moderngl.DEPTH_TEST)
        frame.ctx.depth_func = "<="
        radiance.use(UNITS["radiance"])
        seed, index = frame.sequence(number)
        values = {"radiance": UNITS["radiance"], "view_rays": rays, "world_to_environment": rotation}
        set_uniforms(program, values | {"jitter_ndc": jitter_ndc(frame.scene, index, seed)})
        frame.draw_full_screen("frame", program)

    return draw
