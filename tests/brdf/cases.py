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


def models(expression: str, seed: int, count: int) -> list[AbstractBRDF]:
    """Models of a structure with parameters at the corners of their bounds and between them, and every choice."""
    rng = np.random.default_rng(seed)
    found = [build(expression)]
    while len(found) < count:
        lobes = {}
        for lobe, model in split(found[0]).items():
            values: dict[str, object] = {}
            for p in parameters(model):
                corner = rng.choice([p.lower, p.upper], p.size)
                # Slopes matter by their order of magnitude.
                low = np.log(max(p.lower, 1e-12))
                inner = np.exp(rng.uniform(low, np.log(p.upper), p.size)) if p.slope else None
                inner = rng.uniform(p.lower, p.upper, p.size) if inner is None else inner
                value = np.where(rng.random(p.size) < 0.3, corner, inner)
                values[p.name] = value if p.size == 3 else value[0]
            for c in choices(model):
                values[c.name] = str(rng.choice(c.options))
            lobes[lobe] = dataclasses.replace(model, **values)
        found.append(combine(lobes))
    return found
