"""The furnace: under light that is 1 everywhere a white material that keeps the energy cannot be seen.

Which models these are, their claims and values say: with all colours at 1, and energy of multiple scattering where
there is the choice, the albedo may not be above 1 (but for 0.01), and is 1.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters
from brdf.registry import MODELS

from ..environment import load_environment
from ..evaluation import evaluate
from ..renderer import Renderer
from ..scene import Part, Scene, Tier

# The bar of the picture: the tables of what one scattering loses are as good.
_WITHIN = 0.01
_THETA, _PHI = 512, 256
_RINGS = 8


@dataclasses.dataclass(frozen=True)
class FurnaceRow:
    """How far a model, whose rough parameter has this value, is from 1, by tier.

    - `largest`: of all pixels and channels of the sphere: noise and bias.
    - `ring`: of the means over rings of as many pixels each around its middle, which have little noise left.
    """

    model: str
    setting: str
    largest: dict[str, float]
    ring: dict[str, float]


@dataclasses.dataclass(frozen=True)
class Furnace:
    """The pictures, and model -> why it has none."""

    rows: tuple[FurnaceRow, ...]
    left_out: dict[str, str]


def measure_furnace(
    names: Sequence[str], size: int, error: float, roughness: Sequence[float], say: Callable[[str], None]
) -> Furnace:
    """Renders every white model of these at every roughness in every tier; the truth down to this error."""
    rows, left_out = [], {}
    renderer, light = Renderer(), load_environment("furnace")
    for name in names:
        why = _why_not(name)
        if why:
            left_out[name] = why
            continue
        for setting, model in _whites(name, roughness):
            say(f"furnace: {name} {setting}")
            largest, ring = {}, {}
            for tier in get_args(Tier):
                scene = Scene((Part(model),), light, width=size, height=size, tier=tier, sky="none", tone_map="none")
                if tier == "truth":
                    scene = dataclasses.replace(scene, error=error)
                largest[tier], ring[tier] = deviations(renderer.render(scene).pixels)
            rows.append(FurnaceRow(name, setting, largest, ring))
    return Furnace(tuple(rows), left_out)


def deviations(pixels: NDArray[np.float32]) -> tuple[float, float]:
    """`FurnaceRow.largest` and `ring` of a picture, shape (h, h, 4), whose sphere is in its middle."""
    inside = pixels[..., 3] > 0.5
    middle = 0.5 * (len(pixels) - 1)
    radius = np.hypot(*(np.indices(inside.shape) - middle))[inside]
    deviation = (pixels[inside][:, :3] / pixels[inside][:, 3:] - 1.0)[np.argsort(radius, kind="stable")]
    means = [part.mean(axis=0) for part in np.array_split(deviation, _RINGS)]
    return float(np.abs(deviation).max()), float(np.abs(means).max())


def _why_not(name: str) -> str | None:
    _, model = _whites(name, (0.6,))[0]
    most = model.claims().albedo_max
    if math.isinf(most):
        return "claims no bound of its albedo"
    if most > 1 + _WITHIN:
        return f"may reflect {most:g} of the light"
    albedo = _albedo(model)
    if abs(albedo - 1) > _WITHIN:
        return f"is not white: it reflects {albedo:.2f} at most, at roughness 0.6 seen at 45 degrees"
    return None


def _whites(name: str, roughness: Sequence[float]) -> list[tuple[str, AbstractBRDF]]:
    """The model with white colours, by roughness if it has one; `alpha` is its square."""
    model = MODELS[name]()
    if any(one.name == "energy" for one in choices(MODELS[name])):
        model = dataclasses.replace(model, energy="multiple")
    white: dict[str, Any] = {one.name: (1.0, 1.0, 1.0) for one in parameters(model) if one.kind == "color"}
    model = dataclasses.replace(model, **white)
    names = [one.name for one in parameters(model)]
    for rough, power in (("roughness", 1), ("alpha", 2)):
        if rough in names:
            return [(f"{rough} {r**power:g}", dataclasses.replace(model, **{rough: r**power})) for r in roughness]
    return [("", model)]


def _albedo(model: AbstractBRDF) -> float:
    """Of light seen at 45 degrees: the midpoint rule over the hemisphere, by the square of the sine."""
    square, phi = np.meshgrid((np.arange(_THETA) + 0.5) / _THETA, 2 * np.pi * (np.arange(_PHI) + 0.5) / _PHI)
    sine = np.sqrt(square)
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - square)], axis=-1).reshape(-1, 3)
    wo = np.broadcast_to(np.array([math.sqrt(0.5), 0.0, math.sqrt(0.5)]), wi.shape)
    return float(np.pi * evaluate(model, wi, wo).astype(np.float64).mean())
