"""Synthetic measurements of known materials, seeded."""

from __future__ import annotations

import jax
import numpy as np

from brdf import MODELS, evaluate
from brdf.model import AbstractBRDF
from brdf.registry import combine
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


def plastic(albedo=(0.4, 0.2, 0.05), f0=(0.05, 0.06, 0.07), alpha: float = 0.15) -> AbstractBRDF:
    """`lambert+ggx`, the model that most tests of the fit share."""
    lambert = MODELS["lambert"](albedo=np.array(albedo))
    return combine({"lambert": lambert, "ggx": MODELS["ggx"](f0=np.array(f0), alpha=alpha)})


def noisy_in_log(model: AbstractBRDF, seed: int, count: int, sigma: float = 0.004, grey: bool = False) -> Reflectance:
    """A measurement whose errors are normal in log(1 + f cos_i), the same in all channels or in each its own."""
    clean = measure(model, seed, count)
    cos_i = clean.wi[:, 2:3]
    noise = sigma * np.random.default_rng(seed + 1).normal(size=(count, 1 if grey else 3)) * np.ones((1, 3))
    value = np.maximum(np.expm1(np.log1p(clean.value * cos_i) + noise) / cos_i, 0)
    return Reflectance(wi=clean.wi, wo=clean.wo, value=value, source=clean.source)
