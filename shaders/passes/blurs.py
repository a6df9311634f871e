"""Blurs the environment, or it without its sun, by each kernel that a material's round lobes have."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import blur_name, dim_name, is_sampled, is_sharp, make_blur
from ..culling import visible_parts
from ..environment import Environment
from ..frame import Frame
from ..kernel import Kernel
from ..plan import Pass
from ..round_lobes import round_lobes
from ..scene import Scene
from ..sun import light_of


def declare(scene: Scene) -> Pass:
    """Writes a cube map `blur[...]` per light and kernel; enabled for `scene.tier = "interactive"`."""
    wanted = wanted_blurs(scene)
    writes = {cube_name(scene, *one) for one in wanted if not is_sharp(one[1])}
    reads = {dim_name(light) for light, kernel in wanted if is_sampled(kernel)}
    return Pass("blurs", frozenset(reads), frozenset(writes), scene.environment.digest, bool(writes))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The blurs that are not there yet: names tell what they are made of."""

    def draw(number: int) -> None:
        # The one of the highest degree finds out about the environment what serves the others.
        for light, kernel in sorted(wanted_blurs(frame.scene), key=lambda one: -one[1].degree):
            name = cube_name(frame.scene, light, kernel)
            if not is_sharp(kernel) and name not in frame.store:
                dim = frame.store.get(dim_name(light))
                assert dim is None or isinstance(dim, moderngl.TextureCube)
                frame.keep(name, make_blur(frame.ctx, frame.programs, light, kernel, dim))

    return draw


def cube_name(scene: Scene, light: Environment, kernel: Kernel) -> str:
    """The resource that a lobe of this kernel looks up, lit by the scene's environment or by it without its sun."""
    if is_sharp(kernel):
        return "sky_cube" if light is scene.environment else "sunless_cube"
    return blur_name(light, kernel)


def wanted_blurs(scene: Scene) -> tuple[tuple[Environment, Kernel], ...]:
    """The blurs that the visible parts look up: of what, and by which kernel. None in other tiers."""
    found = set[tuple[Environment, Kernel]]()
    for part in visible_parts(scene) if scene.tier == "interactive" else ():
        lobes = round_lobes(part.twin)
        found |= {(light_of(scene.environment, lobes, kernel), kernel) for kernel in lobes.kernels}
    return tuple(sorted(found, key=lambda one: (one[0].digest, one[1])))
