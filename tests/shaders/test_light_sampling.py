"""Light that one texel sends is all there, wherever it lies. Oracle: the model's integral over the texel in float64."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brdf
from brdf.integrate import evaluate_in_chunks
from brdf.model import AbstractBRDF
from brdf.registry import combine
from shaders import Camera, Environment, Part, Scene, render

pytestmark = pytest.mark.gpu
_HEIGHT = 16
# Each pixel of a picture of one place, with its own scrambling, estimates one radiance.
_EFFORT = {"width": 16, "height": 16, "samples": 512}
_EYE = (0.0, 0.0, 4.77)
_PLACES = ((0.0, 0.0), (0.35, 0.2), (-0.3, 0.6), (0.5, -0.55), (-0.75, -0.3))


def _reflected(model: AbstractBRDF, row: int, column: int, normal: np.ndarray) -> float:
    """Of one texel of radiance 1, interpolated linearly, held beyond the poles: midpoints over its tent."""
    nodes = (np.arange(200) + 0.5) / 100 - 1
    x, y = column + 0.5 + nodes[None, :], row + 0.5 + nodes[:, None]
    tent = (1 - np.abs(nodes[None, :])) * (1 - np.abs(nodes[:, None]))
    y = np.where(y < 0, -y, np.where(y > _HEIGHT, 2 * _HEIGHT - y, y))
    polar, azimuth = np.pi * y / _HEIGHT, 2 * np.pi * (x / (2 * _HEIGHT) - 0.5)
    w = np.stack([np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * x, -np.sin(polar) * np.cos(azimuth)], -1)
    area = (np.pi / _HEIGHT / 100) ** 2
    tangent = np.array([normal[2], 0.0, -normal[0]])
    tangent /= np.linalg.norm(tangent)
    frame = np.stack([tangent, np.cross(normal, tangent), normal])
    to_viewer = np.array(_EYE) - normal
    wo = frame @ (to_viewer / np.linalg.norm(to_viewer))
    wi = (w @ frame.T).reshape(-1, 3)
    value = evaluate_in_chunks(model, wi, np.broadcast_to(wo, wi.shape))[:, 0].reshape(tent.shape)
    return float((value * tent * np.sin(polar) * np.maximum(w @ normal, 0)).sum() * area)


_LAMBERT = brdf.MODELS["lambert"](albedo=0.5)
_MODELS = {
    "lambert": _LAMBERT,
    "ggx": brdf.MODELS["ggx"](alpha=0.3, f0=0.5),
    "brushed": brdf.MODELS["ggx"](alpha_x=0.5, alpha_y=0.2, f0=0.5, anisotropy="anisotropic"),
    "sum": combine({"lambert": _LAMBERT, "ggx": brdf.MODELS["ggx"](alpha=0.3, f0=0.5)}),
}


@pytest.mark.parametrize(("row", "column"), [(6, 28), (9, 0), (0, 5), (15, 30)])
@pytest.mark.parametrize("name", list(_MODELS))
def test_a_ball_lit_by_one_texel_reflects_its_light(name: str, row: int, column: int):
    pixels = np.zeros((_HEIGHT, 2 * _HEIGHT, 3), np.float32)
    pixels[row, column] = 100
    environment = Environment(pixels, "one texel")
    found, expected = [], []
    for x, y in _PLACES:
        normal = np.array([x, y, math.sqrt(1 - x * x - y * y)])
        camera = Camera(_EYE, tuple(normal), vertical_fov=1e-4)
        scene = Scene((Part(_MODELS[name]),), environment, camera=camera, sky="none", tone_map="none", **_EFFORT)
        found.append(render(scene).pixels[..., 0].mean(dtype=np.float64))
        expected.append(100 * _reflected(_MODELS[name], row, column, normal))
    # Noise, and the facets of the ball, which turn normals by up to 1e-3.
    np.testing.assert_allclose(found, expected, rtol=4e-3, atol=4e-3 * max(expected))
