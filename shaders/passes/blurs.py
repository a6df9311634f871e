"""Blurs the environment by each kernel that a material's round lobes have."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ..blurs import blur_name, is_sampled, make_blur
from ..culling import visible_parts
from ..frame import Frame
from ..kernel import Kernel
from ..plan import Pass
from ..round_lobes import round_lobes
from ..scene import Part, Scene


def declare(scene: Scene) -> Pass:
    """Writes a cube map `blur[...]` per environment and kernel; enabled for `scene.tier = "interactive"`."""
    enabled = scene.tier == "interactive"
    kernels = _kernels(visible_parts(scene)) if enabled else ()
    writes = {blur_name(scene.environment, kernel) for kernel in kernels} - {"sky_cube"}
    reads = {"dim_cube"} if any(map(is_sampled, kernels)) else set()
    return Pass("blurs", frozenset(reads), frozenset(writes), scene.environment.digest, enabled and bool(writes))


def prepare(frame: Frame) -> Callable[[int], None]:
    """The blurs that are not there yet: names tell what they are made of."""

    def draw(number: int) -> None:
        dim = frame.store.get("dim_cube")
        assert dim is None or isinstance(dim, moderngl.TextureCube)
        # The one of the highest degree finds out about the environment what serves the others.
        for kernel in sorted(_kernels(frame.visible), key=lambda one: -one.degree):
            name = blur_name(frame.scene.environment, kernel)
            if name not in frame.store:
                frame.keep(name, make_blur(frame.ctx, frame.programs, frame.scene.environment, kernel, dim))

    return draw


def _kernels(parts: tuple[Part, ...]) -> tuple[Kernel, ...]:
    return tuple(sorted({kernel for part in parts for kernel in round_lobes(part.twin).kernels}))
