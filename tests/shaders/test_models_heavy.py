"""How near the interactive tier comes to the truth, for every model. Oracle: the truth, held to float64 elsewhere.

`python -m pytest -m heavy -s tests/shaders/test_models_heavy.py` prints sRGB RMSE over a ball of 128 x 128. Last, under
clear_sky and studio: at most .008 and .016 at the defaults; gltf's sheen .010 and .045, eon of roughness 1 .008 and
.025, clearcoats .009 and .020, brushed metal .010 and .054.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import brdf
from brdf.model import AbstractBRDF
from shaders import Part, Scene, load_environment, render

pytestmark = [pytest.mark.gpu, pytest.mark.heavy]

_PAINT = (0.5, 0.1, 0.05)
MATERIALS: dict[str, AbstractBRDF] = {name: brdf.MODELS[name]() for name in brdf.MODELS} | {
    "sheen": brdf.MODELS["gltf"](base_color=(0.1, 0.1, 0.4), sheen_color=(0.8, 0.6, 0.6), sheen_roughness=0.3),
    "rough diffuse": brdf.MODELS["eon"](albedo=(0.8, 0.3, 0.2), roughness=1.0),
    "clearcoat": brdf.MODELS["gltf"](base_color=_PAINT, clearcoat=1.0, clearcoat_roughness=0.05, roughness=0.6),
    "coated metal": brdf.MODELS["openpbr"](
        base_metalness=1.0, base_color=(0.8, 0.4, 0.1), coat_weight=1.0, specular_roughness=0.5, coat_roughness=0.1
    ),
    "brushed": brdf.MODELS["disney"](base_color=(0.9, 0.7, 0.4), metallic=1.0, roughness=0.4, anisotropic=0.9),
}
# By environment, of models at their defaults and of the others.
_LIMITS = {"clear_sky": (0.01, 0.012), "studio": (0.02, 0.07)}


@pytest.mark.parametrize("environment", list(_LIMITS))
@pytest.mark.parametrize("name", list(MATERIALS))
def test_it_looks_like_the_truth(name: str, environment: str):
    light = load_environment(environment)
    scene = Scene((Part(MATERIALS[name]),), light, width=128, height=128, tier="interactive", sky="none")
    found = render(scene).display
    truth = render(dataclasses.replace(scene, tier="truth", samples=400)).display
    assert found is not None
    assert truth is not None
    inside = truth[..., 3] > 0.5
    error = float(np.sqrt(np.square((found - truth)[inside]).mean()))
    print(f"\n{name}, {environment}: {error:.4f}")
    assert error < _LIMITS[environment][name not in brdf.MODELS]
