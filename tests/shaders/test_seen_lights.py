"""Lights are drawn with the density that is said. Oracle: the counts of half a million draws, by chi-square."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import brdf
from brdf.model import AbstractBRDF
from brdf.registry import combine
from shaders import Environment
from shaders.context import device
from shaders.lighting import UNIT, upload_light
from shaders.program import programs, set_uniforms
from shaders.twin import BLOCK, twin_of

pytestmark = pytest.mark.gpu
_HEIGHT, _WIDTH = 24, 48
_DRAWS = 1 << 19
# Tangent, bitangent and normal, its columns: any that no axis of the environment is near to.
_FRAME, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
# Draws in one half, densities of all texels in the other.
_TEXT = """
#include "seen_lights.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) writeonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 3) writeonly buffer Densities { float densities[]; };
uniform vec3 viewer;
uniform mat3 frame;
uniform int texels;

void main() {
    SeenLights lights = lights_seen(mixture_seen(viewer), viewer, frame);
    uint i = gl_GlobalInvocationID.x;
    vec2 uv;
    ivec2 texel = sample_lights(lights, sequence_point(i, uvec2(12345u, 678u)), uv);
    drawn[i] = uint(texel.y * light_size.x + texel.x);
    if (i < uint(texels)) {
        ivec2 at = ivec2(int(i) % light_size.x, int(i) / light_size.x);
        vec3 w = environment_direction((vec2(at) + 0.5) / vec2(light_size));
        densities[i] = pdf_lights(lights, texelFetch(radiance, at, 0).a, w);
    }
}
"""
_MODELS = {
    "cosine": brdf.MODELS["lambert"](),
    "narrow": brdf.MODELS["ggx"](alpha=0.01),
    "wide": brdf.MODELS["ggx"](alpha=0.3),
    "widest": brdf.MODELS["ggx"](alpha=1.0),
    "mixed": combine({"lambert": brdf.MODELS["lambert"](), "ggx": brdf.MODELS["ggx"](alpha=0.09)}),
}


def _lamps() -> Environment:
    rng = np.random.default_rng(7)
    pixels = 0.1 * rng.random((_HEIGHT, _WIDTH, 3)).astype(np.float32)
    pixels[3:6, 10:14], pixels[11, 30:36], pixels[20, 5] = 4, 9, 50
    return Environment(pixels, "lamps")


def _drawn_and_said(model: AbstractBRDF, viewer: tuple[float, ...]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """How often each texel is drawn, and the probability that the density says, each of shape (h w,)."""
    ctx, twin, texels = device().ctx, twin_of(model), _HEIGHT * _WIDTH
    light = upload_light(ctx, _lamps())
    program = programs().compute("lights_drawn", {}, {"lights_drawn": _TEXT, "material": twin.text})
    buffers = [ctx.buffer(reserve=4 * _DRAWS), ctx.buffer(reserve=4 * texels)]
    for binding, buffer in enumerate([light.cells, light.slots, *buffers]):
        buffer.bind_to_storage_buffer(binding)
    light.radiance.use(UNIT)
    block = ctx.buffer(twin.block)
    block.bind_to_uniform_block(BLOCK)
    values = {"viewer": viewer, "frame": tuple(_FRAME.T.reshape(-1)), "texels": texels, "radiance": UNIT}
    set_uniforms(program, values | {"light_size": light.size, "light_block": light.block})
    program.run(_DRAWS // 64)
    ctx.memory_barrier()
    counts = np.bincount(np.frombuffer(buffers[0].read(), np.uint32), minlength=texels)
    density = np.frombuffer(buffers[1].read(), np.float32).astype(np.float64).reshape(_HEIGHT, _WIDTH)
    sine = np.sin(np.pi * (np.arange(_HEIGHT) + 0.5) / _HEIGHT)[:, None]
    return counts, (density * sine * (2 * np.pi**2 / texels)).reshape(-1)


@pytest.mark.parametrize("viewer", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.3, -0.94, 0.16)])
@pytest.mark.parametrize("name", list(_MODELS))
def test_texels_are_drawn_with_the_density_that_is_said(name: str, viewer: tuple[float, ...]):
    length = float(np.linalg.norm(viewer))
    counts, said = _drawn_and_said(_MODELS[name], tuple(v / length for v in viewer))
    # The lowest six of 24 bits of a texel's density are its segment's number.
    assert said.sum() == pytest.approx(1, abs=2e-5)
    assert not counts[said == 0].any()
    often = said * _DRAWS > 20
    found, expected = (
        np.append(one[often], one[~often].sum()) for one in (counts.astype(np.float64), said * _DRAWS / said.sum())
    )
    # The points are spread more evenly than random ones: there is no lower bound.
    assert stats.chi2.sf(((found - expected) ** 2 / np.maximum(expected, 1)).sum(), often.sum()) > 1e-3


def test_a_lobe_draws_more_of_the_lights_about_the_mirror_direction_than_a_cosine_does():
    viewer = (-0.6, 0.0, 0.8)
    polar = np.pi * (np.arange(_HEIGHT) + 0.5) / _HEIGHT
    azimuth = 2 * np.pi * ((np.arange(_WIDTH) + 0.5) / _WIDTH - 0.5)
    sine, y = np.sin(polar)[:, None], np.cos(polar)[:, None] + 0 * azimuth
    w = np.stack([sine * np.sin(azimuth), y, -sine * np.cos(azimuth)], -1).reshape(-1, 3)
    mirrored = w @ (_FRAME @ [0.6, 0.0, 0.8])
    mean = {name: float(_drawn_and_said(_MODELS[name], viewer)[1] @ mirrored) for name in _MODELS}
    # Between them, by its share; the widest lobe is as wide as the cosine.
    assert mean["cosine"] < mean["mixed"] < mean["wide"] < mean["narrow"]
    assert mean["narrow"] > mean["cosine"] + 0.08
    assert mean["widest"] == pytest.approx(mean["cosine"], rel=1e-5)
