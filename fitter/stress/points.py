"""What a model is stressed with: every option of its choices, parameters at, next to and between their bounds, and
directions at which formulas break."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from brdf.model import AbstractBRDF
from brdf.parameter import Parameter, choices, parameters
from brdf.registry import combine, split

# The smallest cosine that is tried; the models' own horizon lies below it.
GRAZING = 1e-7
# Slopes of half vectors reach this many lobe widths: into the last decades of a Gaussian tail.
_WIDTHS = 9.5
# Widths of lobes whose slope is no parameter of its own.
_WIDTH_MIN, _WIDTH_MAX = 1e-4, 1.0
KINDS = 16

Array = NDArray[Any]


def structures(model: AbstractBRDF, rng: np.random.Generator) -> list[AbstractBRDF]:
    """Models with other static choices than the given one, so that every option of every choice occurs at least once.

    The first has every default; in the others the options of different choices meet at random.
    """
    lobes = split(model)
    orders: dict[tuple[str, str], list[str]] = {}
    for name, lobe in lobes.items():
        for choice in choices(lobe):
            others = [str(option) for option in rng.permutation(choice.options[1:])]
            orders[name, choice.name] = [choice.options[0], *others]
    count = max(map(len, orders.values()), default=1)
    found = []
    for number in range(count):
        chosen: dict[str, AbstractBRDF] = {}
        for name, lobe in lobes.items():
            own = {choice.name: orders[name, choice.name] for choice in choices(lobe)}
            options = {key: order[number % len(order)] for key, order in own.items()}
            chosen[name] = dataclasses.replace(lobe, **options) if options else lobe
        found.append(combine(chosen))
    return found


def declared(model: AbstractBRDF) -> list[tuple[str, Parameter]]:
    """Lobe name and declaration of every parameter, in the order of the model's leaves."""
    return [(name, parameter) for name, lobe in split(model).items() for parameter in parameters(type(lobe))]


def parameter_sets(model: AbstractBRDF, rng: np.random.Generator, count: int, dtype: DTypeLike) -> list[Array]:
    """Values of every parameter, one array of shape (count,) or (count, 3) per leaf of the model.

    A quarter of the sets lies wholly between the bounds and a quarter wholly at or next to them; the others mix.
    """
    edge_share = rng.choice([0.0, 0.3, 0.7, 1.0], (count, 1))
    return [_values(parameter, rng, edge_share, dtype) for _, parameter in declared(model)]


def _values(parameter: Parameter, rng: np.random.Generator, edge_share: Array, dtype: DTypeLike) -> Array:
    shape = (len(edge_share), parameter.size)
    lower, upper = np.array([parameter.lower, parameter.upper], dtype)
    # JAX takes subnormal numbers for zero: next to it is the smallest normal one.
    above = np.finfo(dtype).tiny if lower == 0 else np.nextafter(lower, upper)
    edges = np.array([lower, upper, above, np.nextafter(upper, lower)], dtype)
    edge = rng.choice(edges, shape, p=[0.35, 0.35, 0.15, 0.15])
    if parameter.slope:
        inner = np.exp(rng.uniform(np.log(parameter.lower), np.log(parameter.upper), shape))
    else:
        # Half of them crowd towards a bound by orders of magnitude, where formulas cancel or divide.
        part = np.where(rng.random(shape) < 0.5, rng.random(shape), 10 ** rng.uniform(-8, 0, shape))
        part = np.where(rng.random(shape) < 0.25, 1 - part, part)
        inner = parameter.lower + (parameter.upper - parameter.lower) * part
    value = np.where(rng.random(shape) < edge_share, edge, np.clip(inner.astype(dtype), lower, upper))
    return value if parameter.kind == "color" else value[:, 0]


def widths(model: AbstractBRDF, values: list[Array], rng: np.random.Generator, count: int) -> Array:
    """For every parameter set the width of a lobe to aim at: half of the time one of its own slopes, else any."""
    width = np.exp(rng.uniform(np.log(_WIDTH_MIN), np.log(_WIDTH_MAX), count))
    slopes = [v for v, (_, parameter) in zip(values, declared(model), strict=True) if parameter.slope]
    if slopes:
        own = np.stack(slopes)[rng.integers(len(slopes), size=count), np.arange(count)]
        width = np.where(rng.random(count) < 0.5, own, width)
    return width


def directions(width: Array, rng: np.random.Generator, dtype: DTypeLike) -> tuple[Array, Array]:
    """One pair `wi`, `wo` per lobe width, (n, 3) each; any 16 in a row are of the 16 kinds below."""
    n = -(-len(width) // KINDS)
    tilt = np.resize(width, (n, KINDS)) * _WIDTHS
    tilt *= np.where(
        rng.random(tilt.shape) < 0.7, np.sqrt(rng.random(tilt.shape)), 10 ** rng.uniform(-9, 0, tilt.shape)
    )
    any_i, any_o = (_polar(rng.uniform(GRAZING, 1, n), _azimuth(rng, n)) for _ in range(2))
    low_phi = _azimuth(rng, n)
    low_i, low_o = _polar(GRAZING ** rng.random(n), _azimuth(rng, n)), _polar(GRAZING ** rng.random(n), low_phi)
    turn = rng.choice([0, 1e-7, 1e-3, 0.1, 1, np.pi - 1e-7, np.pi], n)
    beside = _polar(GRAZING ** rng.random(n), low_phi + turn)
    up = np.broadcast_to([0.0, 0.0, 1.0], (n, 3))
    both = rng.random((n, 1)) < 0.5
    start = np.where(both, low_o, any_o)
    wrap_i, wrap_o = _wrapped(rng, n, 1), _wrapped(rng, n, -1)
    kinds = [
        (any_i, any_o),
        (low_i, any_o),
        (low_i, low_o),
        (beside, low_o),
        (_mirror(any_o, tilt[:, 4], rng), any_o),
        (_mirror(low_o, tilt[:, 5], rng), low_o),
        (start * [-1, -1, 1], start),  # exact mirror
        (start, start),  # retro
        (_unit(start + tilt[:, 8:9] * rng.normal(size=(n, 3))), start),  # near retro
        (np.where(both, any_i, low_i), up),
        (np.where(both, up, _mirror(up, tilt[:, 10], rng)), up),
        (low_o * [-1, -1, 1] + [0, 0, GRAZING], low_o),  # next to the mirror
        (_opposite(rng, low_o), low_o),  # wi = -wo almost
        (np.where(both, wrap_i, wrap_o), wrap_o),
        (wrap_i, any_o),
        (start * np.where(both, [-1, -1, -1], [1, 1, -1]), start),  # exactly -wo; below the horizon
    ]
    wi, wo = (np.stack(side, axis=1).reshape(-1, 3)[: len(width)] for side in zip(*kinds, strict=True))
    swap = rng.random((len(width), 1)) < 0.5
    wi, wo = np.where(swap, wo, wi).astype(dtype), np.where(swap, wi, wo).astype(dtype)
    return _next_to(wi, rng), wo


def _azimuth(rng: np.random.Generator, n: int) -> Array:
    """Half of them at random, half along the axes of the tangent frame, as written with pi in float64."""
    axes = rng.choice([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi], n)
    return np.where(rng.random(n) < 0.5, rng.uniform(-np.pi, np.pi, n), axes)


def _polar(cosine: Array, phi: Array) -> Array:
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


def _unit(w: Array) -> Array:
    w = w / np.linalg.norm(w, axis=-1, keepdims=True)
    w[:, 2] = np.maximum(np.abs(w[:, 2]), GRAZING)
    return w


def _mirror(wo: Array, tilt: Array, rng: np.random.Generator) -> Array:
    """`wo` reflected about normals whose slopes are `tilt`, kept above the horizon."""
    phi = _azimuth(rng, len(wo))
    h = np.stack([tilt * np.cos(phi), tilt * np.sin(phi), np.ones(len(wo))], axis=-1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    return _unit(2 * np.sum(wo * h, axis=-1, keepdims=True) * h - wo)


def _opposite(rng: np.random.Generator, wo: Array) -> Array:
    """Directions across from `wo` that graze the surface too, turned by nothing or by very little."""
    turn = rng.choice([0.0, 1e-7, 1e-4], len(wo))
    away = np.arctan2(-wo[:, 1], -wo[:, 0]) + turn
    return _polar(GRAZING ** rng.uniform(0.5, 1, len(wo)), away)


def _wrapped(rng: np.random.Generator, n: int, side: int) -> Array:
    """Directions at the azimuth pi or next to it, on one side of the cut; `y` may be a signed zero."""
    beside = rng.choice([0, 1e-16, 1e-8, 1e-3], n)
    w = _polar(GRAZING ** rng.random(n), side * (np.pi - beside))
    w[:, 1] = np.where(beside == 0, side * 0.0, w[:, 1])
    return w


def _next_to(w: Array, rng: np.random.Generator) -> Array:
    """A fifth of the directions moved to a neighbouring floating-point number in the tangent plane."""
    moved = np.nextafter(w[:, :2], rng.choice([-2, 2], (len(w), 2)).astype(w.dtype))
    return np.where(rng.random((len(w), 1)) < 0.2, np.concatenate([moved, w[:, 2:]], axis=1), w)
