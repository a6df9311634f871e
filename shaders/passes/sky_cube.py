"""Makes the environment's cube map."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import make_sky_cube
from ..frame import Frame
from ..plan import Pass
from ..scene import Scene

# local_size_x and local_size_y in the compute shader.
_GROUP = 8


def declare(scene: Scene) -> Pass:
    """Writes `sky_cube`, a cube map made of `radiance`, with all its levels: means over solid angles."""
    return Pass("sky_cube", reads=frozenset({"radiance"}), writes=frozenset({"sky_cube"}))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The projection, on the device."""

    def draw(number: int) -> None:
        cube = make_sky_cube(frame.ctx, frame.programs, frame.resource("radiance", moderngl.Texture))
        fill_levels(frame, cube)
        frame.keep("sky_cube", cube)

    return draw


def fill_levels(frame: Frame, cube: moderngl.TextureCube) -> None:
    """Makes a cube map's levels from its first one."""
    program = frame.programs.compute("pass/cube_level.comp", {}, {})
    # Edges of cubes are powers of two.
    levels = cube.size[0].bit_length()
    # Mesa, where the first level was bound alone before, knows of others only when their number changes.
    cube.build_mipmaps(max_level=levels - 1)
    for level in range(1, levels):
        cube.bind_to_image(0, read=False, write=True, level=level)
        cube.bind_to_image(1, read=True, write=False, level=level - 1)
        groups = -(-(cube.size[0] >> level) // _GROUP)
        program.run(groups, groups, 6)
        frame.ctx.memory_barrier()
