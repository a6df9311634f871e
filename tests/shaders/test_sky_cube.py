"""The levels of the environment's cube map are means over solid angles. Oracle: the picture's own mean in float64."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

import brdf
from shaders import Environment, Part, Renderer, Scene
from shaders.context import device

pytestmark = pytest.mark.gpu
_READ = """#version 430 core
layout(local_size_x = 6) in;
layout(std430, binding = 0) writeonly buffer Found { vec4 found[]; };
uniform samplerCube sky_cube;
uniform float level;
void main() {
    uint i = gl_LocalInvocationIndex;
    vec3 axis = vec3(i / 2u == 0u, i / 2u == 1u, i / 2u == 2u);
    found[i] = textureLod(sky_cube, (i & 1u) == 0u ? axis : -axis, level);
}
"""


def test_the_coarsest_level_has_the_mean_light_of_a_sun_beside_a_corner():
    height = 128
    polar = np.pi * (np.arange(height)[:, None] + 0.5) / height
    azimuth = 2 * np.pi * ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5)
    w = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -np.sin(polar) * np.cos(azimuth)], -1)
    pixels = np.exp(200 * (w @ np.ones(3) / 3**0.5 - 1))[..., None] * [1000.0, 500.0, 200.0] + 0.1
    environment = Environment(pixels.astype(np.float32), "a sun")
    renderer = Renderer()
    renderer.render(Scene((Part(brdf.build("lambert")),), environment, width=8, height=8, tier="still", sky="none"))
    cube, ctx = renderer._store["sky_cube"], device().ctx
    assert isinstance(cube, moderngl.TextureCube)
    program, found = ctx.compute_shader(_READ), ctx.buffer(reserve=6 * 16)
    found.bind_to_storage_buffer(0)
    cube.use(0)
    program["level"] = float(cube.size[0].bit_length() - 1)
    program.run(1)
    ctx.finish()
    weight = np.sin(polar)[..., None]
    expected = (pixels * weight).sum((0, 1)) / (weight.sum() * 2 * height)
    # The faces are as large as each other. Plain means of texels are twice as bright and more.
    mean = np.frombuffer(found.read(), np.float32).reshape(6, 4)[:, :3].mean(axis=0)
    np.testing.assert_allclose(mean, expected, rtol=0.03)
