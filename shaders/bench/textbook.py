"""A peer: the split sum of the textbooks, drawn into the same targets as the interactive tier by the same passes.

- Karis 2013, "Real Shading in Unreal Engine 4": the two sums; samples of the first are weighted by their cosine.

Irradiance is a cube of 32 texels a side, the blurred environments one of 128 with five levels for roughness 0 to 1,
each of 1024 filtered samples; the table of the second sum has Schlick's approximation of Smith's masking, with
k = alpha / 2.
Both lobes of a dielectric are added whole, as the sum of models that is previewed adds them.
"""

from __future__ import annotations

import functools

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..blurs import make_sky_cube
from ..context import check, device
from ..culling import visible_parts
from ..drawing import prepare_parts
from ..environment import Environment
from ..frame import FIRST_BLUR, Frame
from ..passes import environment, geometry, resolve, sky, tone_map
from ..program import programs
from ..scene import Scene
from ..timing import PassTimes
from ..view import world_to_environment
from .case import Case
from .filtered import cosine_points, filter_cube, ggx_points, hammersley

_IRRADIANCE_TEXELS, _TEXELS, _LEVELS = 32, 128, 5
_SAMPLES = 1024
# Levels: smooths the ripples of a small sun, see `filtered`.
_RAISED = 1.0
_TABLE = 64
_UNITS = {"irradiance": FIRST_BLUR, "prefiltered": FIRST_BLUR + 1, "dfg": FIRST_BLUR + 2}


class Textbook:
    """The renderer of one environment."""

    def __init__(self, light: Environment):
        self._store: dict[str, object] = {}
        self._light = light
        self._textures: dict[str, moderngl.Texture | moderngl.TextureCube] = {}

    def render(self, case: Case, scene: Scene) -> tuple[NDArray[np.float32], dict[str, float]]:
        """The picture for displays, shape (h, w, 4), and milliseconds by pass.

        `case` says what the material is, `scene` all else; it is of the interactive tier and under `light`.
        """
        frame = Frame(device(), scene, programs(), visible_parts(scene), self._store, frozenset({"resolve"}))
        if not self._textures:
            environment.prepare(frame)(0)
            geometry.prepare(frame)(0)
            self._make_textures(frame)
        times = PassTimes(frame.device)
        with times.measure("surface", waits=True):
            self._draw(frame, case)
        for module in (sky, resolve, tone_map):
            if module is not sky or scene.sky != "none":
                with times.measure(module.__name__.rpartition(".")[2], waits=True):
                    module.prepare(frame)(0)
        check(frame.ctx, "drawing the split sum")
        return frame.read("display"), times.total()

    def _draw(self, frame: Frame, case: Case) -> None:
        program = frame.programs.graphics("pass/surface.vert", "bench/split_sum.frag", {}, {})
        values = {
            "world_to_environment": world_to_environment(frame.scene),
            "camera_position": frame.scene.camera.position,
            "albedo": case.albedo,
            "f0": case.f0,
            "roughness": case.roughness,
            "level_max": float(_LEVELS - 1),
        }
        draw = prepare_parts(frame, lambda part: program, values | _UNITS, self._bind)
        frame.picture("frame").clear()
        frame.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        frame.ctx.depth_func = "<="
        draw(0)

    def _bind(self, index: int) -> None:
        for name, texture in self._textures.items():
            texture.use(_UNITS[name])

    def _make_textures(self, frame: Frame) -> None:
        ctx, kept = frame.ctx, frame.programs
        sky_cube = make_sky_cube(ctx, kept, frame.resource("radiance", moderngl.Texture))
        texels = sky_cube.size[0]
        irradiance = ctx.texture_cube((_IRRADIANCE_TEXELS, _IRRADIANCE_TEXELS), 4, dtype="f4")
        irradiance.filter = (moderngl.LINEAR, moderngl.LINEAR)
        filter_cube(ctx, kept, sky_cube, cosine_points(_SAMPLES, texels, _RAISED), False, irradiance)
        prefiltered = ctx.texture_cube((_TEXELS, _TEXELS), 4, dtype="f4")
        prefiltered.build_mipmaps(0, _LEVELS - 1)
        prefiltered.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        for level in range(_LEVELS):
            # The first is a mirror's image: its samples are all at one place.
            points = ggx_points((level / (_LEVELS - 1)) ** 2, _SAMPLES if level else 1, texels, _RAISED)
            filter_cube(ctx, kept, sky_cube, points, True, prefiltered, level)
        dfg = ctx.texture((_TABLE, _TABLE), 2, dfg_table().tobytes(), dtype="f4")
        dfg.filter = (moderngl.LINEAR, moderngl.LINEAR)
        dfg.repeat_x = dfg.repeat_y = False
        ctx.finish()
        self._textures = {"irradiance": irradiance, "prefiltered": prefiltered, "dfg": dfg}


@functools.cache
def dfg_table() -> NDArray[np.float32]:
    """The second sum, shape (roughness, cos_o, 2): scale and bias of f0, by importance sampling of GGX."""
    u, v = hammersley(_SAMPLES)
    cos_o = ((np.arange(_TABLE) + 0.5) / _TABLE)[:, None]
    sin_o = np.sqrt(1 - cos_o**2)
    table = np.empty((_TABLE, _TABLE, 2), np.float32)
    for row in range(_TABLE):
        alpha = ((row + 0.5) / _TABLE) ** 2
        cos_h = np.sqrt((1 - u) / (1 + (alpha**2 - 1) * u))
        h_x = np.sqrt(1 - cos_h**2) * np.cos(2 * np.pi * v)
        cos_d = np.clip(sin_o * h_x + cos_o * cos_h, 1e-9, 1.0)
        cos_i = 2 * cos_d * cos_h - cos_o
        k = alpha / 2
        masking = 1.0
        for cosine in (np.maximum(cos_i, 0.0), cos_o):
            masking = masking * cosine / (cosine * (1 - k) + k)
        visible = np.where(cos_i > 0, masking * cos_d / (cos_h * cos_o), 0.0)
        fresnel = (1 - cos_d) ** 5
        table[row] = np.stack([((1 - fresnel) * visible).mean(axis=1), (fresnel * visible).mean(axis=1)], axis=-1)
    return table
