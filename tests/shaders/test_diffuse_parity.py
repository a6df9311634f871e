"""The diffuse models in GLSL float32 against float64, over their whole parameter boxes, on the same rounded numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from directions import Pairs, adversarial_pairs
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF

pytestmark = pytest.mark.gpu

# The corners of the box and next to them; every channel its own, so that a swap would show.
ROUGHNESSES = [0.0, 1e-3, 0.1, 0.5, 0.999, 1.0]
SIGMAS = [0.0, 1e-3, 0.05, 0.35, 1.0, np.pi / 2]
ALBEDOS = [[0.0, 0.5, 1.0], [0.02, 0.35, 0.97]]


def _rounded(value: Any) -> NDArray[np.float64]:
    """A value that float32 holds exactly, in float64."""
    return np.asarray(value, np.float32).astype(np.float64)


def _pairs(seed: int) -> Pairs:
    """Adversarial pairs and as many that graze the surface, half of them at right angles of azimuth, to the horizon."""
    wi, wo = adversarial_pairs(seed, 0.3, 2000)
    rng = np.random.default_rng(seed + 100)
    count = len(wi)
    phi = 2 * np.pi * rng.random(count)
    turn = np.where(np.arange(count) % 2 == 0, np.pi / 2 * rng.choice([-1, 1], count), 2 * np.pi * rng.random(count))
    turn += rng.choice([0, 1e-7, 1e-4, 1e-2], count)
    added = []
    for azimuth in (phi, phi + turn):
        cosine = 10 ** (-8.9 * rng.random(count))
        sine = np.sqrt((1 - cosine) * (1 + cosine))
        added.append(np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1).astype(np.float32))
    return np.concatenate([wi, added[0]]), np.concatenate([wo, added[1]])


def _worst(model: AbstractBRDF, wi: NDArray[np.float32], wo: NDArray[np.float32], floor: float) -> float:
    """The largest error relative to the value, or to `floor` albedo / pi where the value is smaller."""
    from shaders import evaluate

    value = evaluate(model, wi, wo)
    truth = np.asarray(brdf.evaluate(model, wi.astype(np.float64), wo.astype(np.float64)))
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    scale = np.maximum(truth, floor * np.asarray(model.albedo) / np.pi)
    # A black channel and directions below the horizon are zero in both.
    assert (value[scale == 0] == 0).all()
    above = (wi[:, 2] > 1e-9) & (wo[:, 2] > 1e-9)
    assert ((truth > 0) == (above[:, None] & (np.asarray(model.albedo) > 0))).mean() > 0.9
    counted = scale > 0
    return float(np.max(np.abs(value - truth)[counted] / scale[counted]))


@pytest.mark.parametrize("albedo", ALBEDOS)
@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("name", ["burley", "hanrahan_krueger"])
def test_disney_terms_agree_with_float64(name: str, roughness: float, albedo: list[float]):
    model = brdf.MODELS[name](albedo=_rounded(albedo), roughness=_rounded(roughness))
    # Sums of positive terms throughout, so that no direction is spared.
    assert _worst(model, *_pairs(31), floor=0.0) <= 2e-6


@pytest.mark.parametrize("albedo", ALBEDOS)
@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("form", ["exact", "polynomial"])
def test_eon_agrees_with_float64(form: str, roughness: float, albedo: list[float]):
    model = brdf.MODELS["eon"](albedo=_rounded(albedo), roughness=_rounded(roughness), albedo_form=form)
    assert _worst(model, *_pairs(32), floor=0.0) <= 1e-6


@pytest.mark.parametrize("albedo", ALBEDOS)
@pytest.mark.parametrize("sigma", SIGMAS)
@pytest.mark.parametrize("form", ["full", "qualitative"])
def test_oren_nayar_agrees_with_float64(form: str, sigma: float, albedo: list[float]):
    model = brdf.MODELS["oren_nayar"](albedo=_rounded(albedo), sigma=_rounded(sigma), form=form)
    # The full form is a difference that is cut at 0: near the cut the error is measured against a twentieth of Lambert.
    if form == "full":
        assert _worst(model, *_pairs(33), floor=0.05) <= 1e-5
    else:
        assert _worst(model, *_pairs(33), floor=0.0) <= 1e-6


def test_lambert_agrees_to_one_rounding():
    model = brdf.MODELS["lambert"](albedo=_rounded(ALBEDOS[1]))
    assert _worst(model, *_pairs(34), floor=0.0) <= 3e-7
