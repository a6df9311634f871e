"""`make bench`: the fit against named peers, interleaved, on the same data at the same loss and final cost.

    python -m tests.benchmarks [samples]

Prints CPU seconds (median of interleaved rounds, everything compiled before), their ratio to ours, and the final cost
relative to the best. The data are synthetic: a known plastic with 5 % noise at random directions.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp
import lineax
import numpy as np
import optimistix as optx
import scipy.optimize

import brdf
import fitter
from brdf.material import from_dict
from fitter.unknowns import choose

ROUNDS = 5
MODEL = "lambert+ggx"
TRUTH = {"lambert": {"albedo": [0.4, 0.2, 0.05]}, "ggx": {"f0": [0.05, 0.06, 0.07], "alpha": 0.15}}
# Peers start here; ours finds its own start, which is part of its time.
START = np.array([0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.3])


def measurement(count: int) -> fitter.Reflectance:
    rng = np.random.default_rng(1)
    cosine, phi = rng.uniform(0.2, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    sine = np.sqrt(1 - cosine**2)
    wi, wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    value = np.asarray(brdf.evaluate(from_dict({"model": MODEL, "parameters": TRUTH}).brdf, wi, wo))
    noisy = np.maximum(value * (1 + 0.05 * rng.normal(size=value.shape)), 0)
    return fitter.Reflectance(wi=wi, wo=wo, value=noisy, source="synthetic")


def contestants(data: fitter.Reflectance) -> dict[str, Callable[[], float]]:
    """Name -> a run from data to final cost."""
    unknowns = choose(brdf.build(MODEL), {})
    lower, upper = unknowns.bounds()
    wi, wo = jnp.asarray(data.wi), jnp.asarray(data.wo)
    cos_i, target = wi[:, 2:3], jnp.log1p(jnp.asarray(data.value) * jnp.asarray(data.wi[:, 2:3]))

    def residual(y: jax.Array, _: object = None) -> jax.Array:
        return (jnp.log1p(jax.vmap(unknowns.model(y))(wi, wo) * cos_i) - target).ravel()

    compiled = jax.jit(residual)
    jacobian = jax.jit(jax.jacfwd(residual))
    peer = optx.LevenbergMarquardt(rtol=1e-8, atol=1e-8, linear_solver=lineax.Normal(lineax.Cholesky()))

    def ours() -> float:
        return fitter.fit(MODEL, data, loss="log_squares", max_theta_deg=90.0).errors["cost"]

    def optimistix() -> float:
        value = optx.least_squares(residual, peer, jnp.asarray(START), max_steps=500, throw=False).value
        return float(0.5 * jnp.sum(compiled(value) ** 2))

    def scipy_trf() -> float:
        found = scipy.optimize.least_squares(
            lambda y: np.asarray(compiled(y)), START, lambda y: np.asarray(jacobian(y)), (lower, upper), x_scale="jac"
        )
        return float(found.cost)

    return {"brdf-fitter": ours, "optimistix LM, Cholesky": optimistix, "scipy trf": scipy_trf}


def main(count: int = 30_000) -> None:
    jax.config.update("jax_enable_x64", True)
    data = measurement(count)
    runs = contestants(data)
    costs = {name: run() for name, run in runs.items()}
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, run in runs.items():
            start = time.process_time()
            run()
            seconds[name].append(time.process_time() - start)
    ours = statistics.median(seconds["brdf-fitter"])
    print(f"{MODEL}, {count} samples, float64, log_squares, median CPU seconds of {ROUNDS} interleaved rounds")
    for name in runs:
        middle = statistics.median(seconds[name])
        excess = costs[name] / min(costs.values()) - 1
        print(f"{name:26} {middle:8.3f} s  {middle / ours:6.1f} x ours  cost above best {excess:.1e}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
