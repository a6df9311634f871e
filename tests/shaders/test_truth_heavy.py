"""Tier 3 converges to the integral of the model's own `brdf()`. Oracle: float64 quadrature of the Python twin.

The camera is close to a point, so that all pixels of a picture, each with its own scrambling, estimate one radiance.
`-s` prints the error of every model.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import brdf
from brdf.integrate import evaluate_in_chunks
from brdf.model import AbstractBRDF
from brdf.parameter import parameters
from brdf.quadrature import half_vector_rule
from shaders import Camera, Environment, Mesh, Part, Scene, load_environment, render

pytestmark = [pytest.mark.gpu, pytest.mark.heavy]
# Places on the ball, from the default camera: 0 to 86 degrees from the viewer.
_PLACES = ((0.0, 0.0), (0.35, 0.2), (-0.3, 0.6), (0.5, -0.55), (-0.75, -0.3), (0.2, -0.94))
_EYE = np.array([0.0, 0.0, 4.77])
_SIZE, _SAMPLES = 64, 2048


def _gradient() -> Environment:
    """Radiance 1 + 0.8 y, with other slopes for green and blue; its interpolation errs by 2e-5."""
    y = np.cos(np.pi * (np.arange(256) + 0.5) / 256)[:, None, None]
    return Environment(np.tile((1 + np.array([0.8, 0.5, -0.6]) * y).astype(np.float32), (1, 512, 1)), "gradient")


def _sky(name: str, w: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.ones((len(w), 3)) if name == "furnace" else 1 + np.array([0.8, 0.5, -0.6]) * w[:, 1:2]


def _other(name: str) -> AbstractBRDF:
    """Parameters drawn within their bounds, slopes from 0.02 on, with the model's default choices."""
    rng = np.random.default_rng(41)
    values: dict[str, Any] = {}
    for one in parameters(brdf.MODELS[name]):
        low, high = max(one.lower, 0.02) if one.slope else one.lower, min(one.upper, 100.0)
        drawn = rng.uniform(low, high, one.size).astype(np.float32).astype(np.float64)
        values[one.name] = drawn if one.size == 3 else float(drawn[0])
    return brdf.MODELS[name](**values)


def _truth(model: AbstractBRDF, sky: str, normal: NDArray[np.float64], nodes: int) -> NDArray[np.float64]:
    to_viewer = (_EYE - normal) / np.linalg.norm(_EYE - normal)
    tangent = np.array([normal[2], 0.0, -normal[0]])
    tangent /= np.linalg.norm(tangent)
    frame = np.stack([tangent, np.cross(normal, tangent), normal])
    wo = frame @ to_viewer
    wi, solid_angle = half_vector_rule(math.acos(wo[2]), nodes, 2 * nodes)
    around = np.arctan2(wo[1], wo[0])
    c, s = math.cos(around), math.sin(around)
    wi = wi @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    value = evaluate_in_chunks(model, wi, np.broadcast_to(wo, wi.shape))
    return (value * _sky(sky, wi @ frame) * (wi[:, 2] * solid_angle)[:, None]).sum(axis=0)


def _patch(normal: NDArray[np.float64]) -> Mesh:
    """A flat triangle that touches the ball, whose own facets turn the normal by 1e-3 where they are seen aslant."""
    across = np.cross(normal, [0.6, 0.0, 0.8])
    corners = [
        normal + 0.1 * (c * across + s * np.cross(normal, across)) for c, s in ((1, 0), (-0.5, 0.8), (-0.5, -0.8))
    ]
    return Mesh(
        np.array(corners, np.float32), np.tile(normal.astype(np.float32), (3, 1)), np.array([[0, 1, 2]], np.uint32)
    )


def _rendered(model: AbstractBRDF, environment: Environment, normal: NDArray[np.float64]) -> NDArray[np.float64]:
    camera = Camera(tuple(_EYE), tuple(normal), vertical_fov=1e-4)
    scene = Scene(
        (Part(model, _patch(normal)),),
        environment,
        0.0,
        camera,
        0.0,
        _SIZE,
        _SIZE,
        samples=_SAMPLES,
        sky="none",
        tone_map="none",
    )
    return render(scene).pixels[..., :3].mean(axis=(0, 1), dtype=np.float64)


@pytest.mark.parametrize("which", ["default", "other"])
@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_the_truth_is_the_integral_of_the_models_own_values(name: str, which: str):
    model = brdf.MODELS[name]() if which == "default" else _other(name)
    environments = {"furnace": load_environment("furnace"), "gradient": _gradient()}
    worst = {}
    for sky, environment in environments.items():
        errors = []
        for x, y in _PLACES:
            normal = np.array([x, y, math.sqrt(1 - x * x - y * y)])
            truth, finer = (_truth(model, sky, normal, nodes) for nodes in (96, 160))
            # The oracle's own error.
            np.testing.assert_allclose(truth, finer, rtol=3e-4)
            errors.append(_rendered(model, environment, normal) / finer - 1)
        worst[sky] = float(np.abs(errors).max())
    print(f"{name:18s} {which:8s} " + " ".join(f"{sky} {error:.1e}" for sky, error in worst.items()))
    assert max(worst.values()) <= 1e-3
