"""Random materials, their noise-free measurements, and how well a fit finds them again."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

import fitter
from brdf import build, evaluate, parameters
from brdf.model import AbstractBRDF
from brdf.registry import combine, split
from fitter.loss import LOSSES
from fitter.minimise import Problem
from fitter.reflectance import Reflectance
from fitter.samples import arrange
from fitter.start import interchangeable, sort_lobes
from fitter.unknowns import Unknowns
from fitter.wishes import Wishes, choose

ONE_LOBE = (
    *("ggx", "beckmann", "gaussian", "gtr", "general_gtr", "ward", "phong", "blinn_phong", "cook_torrance"),
    *("ashikhmin_shirley", "oren_nayar", "burley", "eon", "hanrahan_krueger", "lambert"),
)
SEVERAL_LOBES = ("lambert+ggx", "ggx+ggx", "lambert+ggx+ggx", "lambert+ggx+beckmann", "disney")
# A parameter is identifiable if a change of 1e-6 of it, all others fitted again, changes the residuals' root mean
# square by more than 1e-13: a hundred times what float64 rounds.
IDENTIFIABLE = 1e-7
RELATIVE = 1e-6
# Mean square of the residuals that counts as found.
EXACT = 1e-12


def material(expression: str, seed: int) -> AbstractBRDF:
    """Parameters from the whole of their bounds: slopes and exponents log-uniform, the others uniform."""
    rng = np.random.default_rng(seed)
    lobes = split(build(expression))
    for name, lobe in lobes.items():
        drawn = {}
        for p in parameters(lobe):
            u = rng.random(p.size)
            if p.held:
                value = np.full(1, rng.choice(p.held))
            elif p.slope or p.name == "exponent":
                value = p.lower * (p.upper / p.lower) ** u
            else:
                value = p.lower + u * (p.upper - p.lower)
            drawn[p.name] = value if p.size == 3 else float(value[0])
        lobes[name] = dataclasses.replace(lobe, **drawn)
    unknowns = choose(combine(lobes), Wishes())
    return unknowns.model(sort_lobes(unknowns.vector(combine(lobes)), interchangeable(unknowns)))


def measurement(model: AbstractBRDF, seed: int, count: int = 2400) -> Reflectance:
    """Random directions up to 74 degrees, half of them 3e-5 to 0.5 rad beside the mirror direction."""
    rng = np.random.default_rng([seed, count])

    def hemisphere() -> np.ndarray:
        cosine, phi = rng.uniform(np.cos(1.3), 1, count), rng.uniform(0, 2 * np.pi, count)
        sine = np.sqrt(1 - cosine**2)
        return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)

    wi, wo = hemisphere(), hemisphere()
    near = wi * [-1, -1, 1] + 10 ** rng.uniform(-4.5, -0.3, (count, 1)) * rng.normal(size=(count, 3))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    use = (np.arange(count) % 2 == 0) & (near[:, 2] > np.cos(1.3))
    wo = np.where(use[:, None], near, wo)
    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, wi, wo))
    return Reflectance(wi=wi, wo=wo, value=value, source=f"synthetic {seed}")


@dataclasses.dataclass(frozen=True)
class Recovery:
    """Whether every identifiable parameter was found, the mean square residual, and how many were identifiable."""

    found: bool
    cost: float
    identifiable: int
    elements: int


def recover(expression: str, seed: int) -> Recovery:
    """Fits a random material's own model to its measurement."""
    truth = material(expression, seed)
    data = measurement(truth, seed)
    result = fitter.fit(build(expression), data, quick=True)
    unknowns = result.unknowns
    wanted, got = (unknowns.values(unknowns.vector(one)) for one in (truth, result.brdf))
    held = {f"{lobe}.{name}": float(getattr(split(truth)[lobe], name)) for (lobe, name), _ in unknowns.held}
    sure = _sensitivity(choose(build(expression), Wishes(fixed=held)), truth, data) > IDENTIFIABLE
    error = np.abs(got - wanted) / np.maximum(np.abs(wanted), 1e-9)
    cost = result.errors["cost"] / len(data)
    return Recovery(bool((error[sure] <= RELATIVE).all()), cost, int(sure.sum()), len(sure))


def _sensitivity(unknowns: Unknowns, truth: AbstractBRDF, data: Reflectance) -> np.ndarray:
    """The change of the residuals' root mean square by a relative change of each element, all others fitted again."""
    y = unknowns.vector(truth)
    with jax.enable_x64(True):
        problem = Problem(unknowns, arrange(data, LOSSES["log"], np.ones((len(data), 1))), "log")
        hessian = problem.assess(y).equations.hessian
    root = np.sqrt(np.maximum(np.diagonal(hessian), 1e-300))
    values, vectors = np.linalg.eigh(hessian / root[:, None] / root[None, :])
    spread = np.sqrt(np.einsum("ij,j,ij->i", vectors, 1 / np.maximum(values, 1e-20), vectors))
    return np.abs(y) * root / spread / np.sqrt(3 * len(data))
