"""Directions and parameters on which models are tested: random ones and the awkward ones, seeded."""

from __future__ import annotations

import dataclasses

import numpy as np

from brdf import MODELS, build, choices, parameters
from brdf.model import AbstractBRDF
from brdf.registry import combine, split

EXPRESSIONS = (*MODELS, "lambert+ggx", "oren_nayar+beckmann", "lambert+ggx+ggx")


def directions(rng: np.random.Generator, count: int) -> np.ndarray:
    """Unit vectors of the upper hemisphere, (count, 3), a quarter of them within 1e-7 to 1e-1 of the horizon."""
    cosine = rng.uniform(1e-4, 1, count)
    grazing = np.arange(count) % 4 == 0
    cosine = np.where(grazing, 10 ** rng.uniform(-7, -1, count), cosine)
    phi = rng.uniform(-np.pi, np.pi, count)
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


def pairs(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`wi` and `wo`, (count, 3): anything, near and at the mirror direction, retro-reflection, normal incidence."""
    rng = np.random.default_rng(seed)
    wi, wo = directions(rng, count), directions(rng, count)
    kind = np.arange(count) % 8
    mirror = wi * [-1, -1, 1]
    near = mirror + 10 ** rng.uniform(-5, -1, (count, 1)) * rng.normal(size=(count, 3)) * [1, 1, 0.1]
    near[:, 2] = np.abs(near[:, 2])
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wo = np.select([(kind == 1)[:, None], (kind == 2)[:, None], (kind == 3)[:, None]], [near, mirror, wi], wo)
    normal = np.broadcast_to([0.0, 0.0, 1.0], wi.shape)
    wo = np.where((kind == 4)[:, None], normal, wo)
    wi = np.where((np.arange(count) % 16 == 12)[:, None], normal, wi)
    opposite = np.concatenate([-wi[:, :2], np.maximum(wi[:, 2:], 1e-7)], axis=1)
    opposite[:, 2] = np.minimum(opposite[:, 2], 1e-7)
    opposite /= np.linalg.norm(opposite, axis=1, keepdims=True)
    return wi, np.where((kind == 5)[:, None], opposite, wo)


def structures(expression: str) -> list[AbstractBRDF]:
    """Models at their defaults whose static choices together hold every option of every choice."""
    base = split(build(expression))
    rounds = max((len(c.options) for model in base.values() for c in choices(model)), default=1)
    found = []
    for number in range(rounds if len(base) == 1 else 1):
        chosen = {
            lobe: {c.name: c.options[number % len(c.options)] for c in choices(model)} for lobe, model in base.items()
        }
        found.append(combine({lobe: dataclasses.replace(model, **chosen[lobe]) for lobe, model in base.items()}))
    return found


def inside(model: AbstractBRDF, rng: np.random.Generator, corners: float) -> AbstractBRDF:
    """The model with random parameters, each at a bound with the probability `corners`."""
    lobes = {}
    for lobe, part in split(model).items():
        values: dict[str, object] = {}
        for p in parameters(type(part)):
            corner = rng.choice([p.lower, p.upper], p.size)
            # Slopes and exponents matter by their order of magnitude.
            if p.lower > 0 and p.upper > 1e3 * p.lower:
                inner = np.exp(rng.uniform(np.log(p.lower), np.log(p.upper), p.size))
            else:
                inner = rng.uniform(p.lower, p.upper, p.size)
            value = np.where(rng.random(p.size) < corners, corner, inner)
            values[p.name] = value if p.size == 3 else value[0]
        lobes[lobe] = dataclasses.replace(part, **values)
    return combine(lobes)


def broad(model: AbstractBRDF) -> AbstractBRDF:
    """The model with no lobe narrower than a grid of a few hundred directions resolves."""
    lobes = {}
    for lobe, part in split(model).items():
        values: dict[str, object] = {}
        for p in parameters(type(part)):
            value = getattr(part, p.name)
            if p.slope or "roughness" in p.name:
                values[p.name] = np.maximum(value, 0.15 if p.slope else 0.4)
            elif "exponent" in p.name:
                values[p.name] = np.minimum(value, 80.0)
            elif p.name in ("clearcoat_gloss",):
                values[p.name] = np.zeros_like(value)
        lobes[lobe] = dataclasses.replace(part, **values)
    return combine(lobes)


def models(expression: str, seed: int, count: int) -> list[AbstractBRDF]:
    """At least `count` models: every structure of `structures`, with parameters at their bounds and between them."""
    rng = np.random.default_rng(seed)
    known = structures(expression)
    return [inside(known[n % len(known)], rng, 0.3) for n in range(max(count, len(known)))]
