"""No float target holds NaN, an infinity or a negative value: models at the corners of their parameters, harsh light.

Oracle: a sum of products of what is finite and not negative. The numbers are read before the tone map; a driver may
turn NaN into 0 inside `max` and `clamp`, never in a target.

Values go through the uniform block of one program for each model and its choices, also weights of 0, for which the
program proper leaves out what they scale: the heavy sweep has those programs too.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters
from brdf.plain import plain_lobes
from shaders import Environment, Part, Scene, load_environment, render
from shaders.material_block import pack, twin
from shaders.twin import Twin

pytestmark = pytest.mark.gpu

RANDOM_CORNERS = 6


def _black() -> Environment:
    return Environment(np.zeros((32, 64, 3), np.float32), "black")


def _one_texel() -> Environment:
    """All light from one texel beside the seam."""
    pixels = np.zeros((64, 128, 3), np.float32)
    pixels[20, 0] = 1e6
    return Environment(pixels, "one texel")


def _model(name: str, part: float | np.random.Generator, **options: str) -> AbstractBRDF:
    """A model with every live value this part of the way from its lower to its upper bound, or at bounds at random."""
    model = dataclasses.replace(brdf.MODELS[name](), **options)
    values: dict[str, Any] = {}
    for one in parameters(model):
        at = part.integers(0, 2, one.size) if isinstance(part, np.random.Generator) else np.full(one.size, part)
        value = np.where(at == 0, one.lower, np.where(at == 1, one.upper, one.lower + at * (one.upper - one.lower)))
        values[one.name] = value if one.kind == "color" else float(value[0])
    return dataclasses.replace(model, **values)


def _through_block(model: AbstractBRDF, whole: AbstractBRDF) -> Twin:
    """A model's values in the program of one that has every part."""
    return dataclasses.replace(twin(whole), block=pack(plain_lobes(model)))


def _faults(material: AbstractBRDF | Twin, environments: list[Environment], what: str) -> Iterator[str]:
    for environment in environments:
        for rotation in (0.0, 2.0):
            scene = Scene((Part(material),), environment, rotation, width=24, height=24, samples=28, tone_map="none")
            pixels = render(scene).pixels
            if not (np.isfinite(pixels).all() and pixels.min() >= 0):
                yield f"{what} under {environment.name}: {_counts(pixels)}"


def _counts(pixels: NDArray[np.float32]) -> str:
    nan, infinite, negative = np.isnan(pixels).sum(), np.isinf(pixels).sum(), (pixels < 0).sum()
    return f"{nan} NaN, {infinite} infinite, {negative} negative of {pixels.size}"


@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_no_pixel_is_bad_at_the_bounds_of_a_model(name: str):
    whole = _model(name, 1.0)
    environments = [load_environment("night"), _one_texel()]
    for part in (0.0, 1.0):
        corner = _through_block(_model(name, part), whole)
        assert list(_faults(corner, environments, f"{name} at {part}")) == []


@pytest.mark.parametrize("name", ["lambert", "disney", "ggx", "ashikhmin_shirley"])
def test_no_pixel_of_the_interactive_tier_is_bad_at_the_bounds_of_a_model(name: str):
    options = {"anisotropy": "anisotropic"} if name == "ggx" else {}
    whole = _model(name, 1.0, **options)
    for part in (0.0, 1.0):
        model = _through_block(_model(name, part, **options), whole)
        for environment in (load_environment("night"), _one_texel()):
            scene = Scene((Part(model),), environment, 2.0, width=24, height=24, tier="interactive", tone_map="none")
            pixels = render(scene).pixels
            is_good = np.isfinite(pixels).all() and pixels.min() >= 0
            assert is_good, f"{part} under {environment.name}: {_counts(pixels)}"


@pytest.mark.heavy
@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_no_pixel_is_bad_at_any_corner_under_any_choice(name: str):
    names = ("furnace", "studio", "clear_sky", "night", "overcast")
    environments = [*(load_environment(one) for one in names), _black(), _one_texel()]
    rng = np.random.default_rng([5, list(brdf.MODELS).index(name)])
    alternatives = [{one.name: option} for one in choices(brdf.MODELS[name]) for option in one.options[1:]]
    faults: list[str] = []
    for options in ({}, *alternatives):
        whole = _model(name, 1.0, **options)
        for corner in (0.0, 1.0, 1e-6, 0.5, *[rng] * RANDOM_CORNERS):
            model = _model(name, corner, **options)
            values = {one.name: np.asarray(getattr(model, one.name)).tolist() for one in parameters(model)}
            faults += _faults(_through_block(model, whole), environments, f"{name} {options} {values}")
        # The program without what weights of 0 scale.
        faults += _faults(_model(name, 0.0, **options), environments, f"{name} {options}, all lower, own program")
    assert faults == []
