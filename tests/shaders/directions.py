"""Pairs of directions that are hard on float32: near-mirror, exact mirror, retro, normal incidence, grazing to 1e-7."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Pairs = tuple[NDArray[np.float32], NDArray[np.float32]]


def _around(rng: np.random.Generator, cosine: NDArray[np.float64], phi: NDArray[np.float64]) -> NDArray[np.float64]:
    sine = np.sqrt(1 - cosine * cosine)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


def _near_mirror(rng: np.random.Generator, wo: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
    """Directions whose half vectors have slopes up to 9.5 alpha: into the last decades of Beckmann's tail."""
    slope = 9.5 * alpha * np.sqrt(rng.random(len(wo)))
    phi = 2 * np.pi * rng.random(len(wo))
    h = np.stack([slope * np.cos(phi), slope * np.sin(phi), np.ones(len(wo))], axis=-1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    return 2 * (wo * h).sum(axis=-1, keepdims=True) * h - wo


def adversarial_pairs(seed: int, alpha: float, count: int) -> Pairs:
    """About ten times `count` pairs (wi, wo), rounded to float32, some below the horizon."""
    rng = np.random.default_rng(seed)
    phi, turn = 2 * np.pi * rng.random(count), rng.choice([0, 1e-6, 1e-3, 0.1, 1, np.pi], count)
    anywhere, elsewhere = (_around(rng, rng.random(count), 2 * np.pi * rng.random(count)) for _ in range(2))
    grazing, beside = (
        _around(rng, 10 ** (-7 * rng.random(count)), phi),
        _around(rng, 10 ** (-7 * rng.random(count)), phi + turn),
    )
    up = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    pairs = [
        (elsewhere, anywhere),
        (_near_mirror(rng, anywhere, alpha), anywhere),
        (_near_mirror(rng, grazing, alpha), grazing),
        (elsewhere, grazing),
        (grazing * [-1, -1, 1], grazing),
        (anywhere * [-1, -1, 1], anywhere),
        (grazing, grazing),
        (beside, grazing),
        (elsewhere, up),
        (_near_mirror(rng, up, alpha), up),
        (up[:1], up[:1]),
    ]
    wi, wo = (np.concatenate(side).astype(np.float32) for side in zip(*pairs, strict=True))
    return wi, wo
