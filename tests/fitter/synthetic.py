"""Synthetic measurements of known materials, seeded."""

from __future__ import annotations

import jax
import numpy as np

from brdf import evaluate
from brdf.model import AbstractBRDF
from fitter.reflectance import Reflectance


def scattered(seed: int, count: int, theta_max: float = 1.35) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions, half of them near the mirror direction where a highlight is."""
    rng = np.random.default_rng(seed)

    def hemisphere() -> np.ndarray:
        cosine, phi = rng.uniform(np.cos(theta_max), 1, count), rng.uniform(0, 2 * np.pi, count)
        sine = np.sqrt(1 - cosine**2)
        return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)

    wi, wo = hemisphere(), hemisphere()
    near = wi * [-1, -1, 1] + 10 ** rng.uniform(-2.5, -0.5, (count, 1)) * rng.normal(size=(count, 3))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    use = (np.arange(count) % 2 == 0) & (near[:, 2] > np.cos(theta_max))
    return wi, np.where(use[:, None], near, wo)


def measure(model: AbstractBRDF, seed: int = 1, count: int = 3000, noise: float = 0.0) -> Reflectance:
    """A measurement of a model with multiplicative Gaussian noise."""
    wi, wo = scattered(seed, count)
    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, wi, wo))
    value = value * (1 + noise * np.random.default_rng(seed + 1).normal(size=value.shape))
    return Reflectance(wi=wi, wo=wo, value=np.maximum(value, 0), source=f"synthetic {seed}")
