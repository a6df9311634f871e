"""The contestants of a fit: ours, and named peers in their best reasonable configuration on the same residual.

A peer that is not installed is no error: `contestant` says so. Peers are imported by name, since none is a dependency.
"""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from .adam import prepare as adam
from .problem import LOSS, MAX_THETA_DEG, Problem
from .trace import Run, Stopped, Trace

Array = NDArray[Any]
OURS = "brdf-fitter"
# Peers stop when the cost changes by a smaller share: tight enough for the common final cost, and no tighter.
_FTOL = 1e-8
# Optimistix also wants the parameters to have settled to the same tolerance.
_OPTIMISTIX_TOL = 1e-6
_STEPS_MAX = 500
# Samples per residual block of Ceres, whose values then stay in the cache.
_CERES_BLOCK = 8192


@dataclasses.dataclass(frozen=True)
class Contestant:
    """A compiled fit.

    - `run`: CPU seconds at which to give up, to the outcome.
    - `trace`: the same, step by step, for the error over time.
    """

    run: Callable[[float], Run]
    trace: Callable[[float], Run]


@dataclasses.dataclass(frozen=True)
class _Peer:
    package: str
    setup: str
    prepare: Callable[[Problem], Contestant | None]


def names() -> tuple[str, ...]:
    """Every contestant, ours first."""
    return tuple(_PEERS)


def setup(name: str) -> str:
    """How a contestant is configured, for the docs."""
    return _PEERS[name].setup


def contestant(name: str, problem: Problem) -> Contestant | str:
    """A compiled contestant, or why there is none."""
    peer = _PEERS[name]
    if importlib.util.find_spec(peer.package) is None:
        return f"not installed: pip install {peer.package}"
    return peer.prepare(problem) or f"no {peer.package} version of {problem.model}"


def _alike(run: Callable[[float], Run]) -> Contestant:
    return Contestant(run, run)


def _ours(problem: Problem) -> Contestant:
    from ..fitting import fit

    def run(limit: float) -> Run:
        trace = Trace(limit, problem.start)
        found = fit(problem.model, problem.data, fixed=problem.fixed, loss=LOSS, max_theta_deg=MAX_THETA_DEG)
        return trace.end(problem.vector(found.brdf))

    run(0.0)  # compiles
    return _alike(run)


def _optimistix(problem: Problem) -> Contestant:
    import equinox as eqx

    lineax, optx = map(importlib.import_module, ("lineax", "optimistix"))
    solver = optx.LevenbergMarquardt(
        rtol=_OPTIMISTIX_TOL, atol=_OPTIMISTIX_TOL, linear_solver=lineax.Normal(lineax.Cholesky())
    )
    start = jnp.asarray(problem.start)

    @jax.jit
    def solve(y: jax.Array, samples: Any) -> jax.Array:
        return optx.least_squares(problem.residual, solver, y, samples, max_steps=_STEPS_MAX, throw=False).value

    compiled = solve.lower(start, problem.samples).compile()
    fixed = {"fn": lambda y, samples: (problem.residual(y, samples), None), "options": {}, "tags": frozenset()}

    @eqx.filter_jit
    def step(y: jax.Array, state: Any, samples: Any) -> Any:
        return solver.step(y=y, args=samples, state=state, **fixed)[:2]

    @eqx.filter_jit
    def done(y: jax.Array, state: Any, samples: Any) -> Any:
        return solver.terminate(y=y, args=samples, state=state, **fixed)[0]

    def run(limit: float) -> Run:
        trace = Trace(limit, problem.start)
        return trace.end(np.asarray(compiled(start, problem.samples)))

    def stepwise(limit: float) -> Run:
        trace, samples = Trace(limit, problem.start), problem.samples
        shape = jax.eval_shape(problem.residual, start, samples)
        state, y = solver.init(y=start, args=samples, f_struct=shape, aux_struct=None, **fixed), start
        try:
            for _ in range(_STEPS_MAX):
                y, state = step(y, state, samples)
                # A rejected step leaves `y` as it was.
                trace.see(np.asarray(y))
                if done(y, state, samples):
                    break
        except Stopped:
            return trace.stop()
        return trace.end(np.asarray(y))

    shape = jax.eval_shape(problem.residual, start, problem.samples)
    first = solver.init(y=start, args=problem.samples, f_struct=shape, aux_struct=None, **fixed)
    y, state = step(start, first, problem.samples)
    done(y, state, problem.samples)
    return Contestant(run, stepwise)


def _lmfit(problem: Problem) -> Contestant:
    lmfit = importlib.import_module("lmfit")
    residual, rows = _warm(problem)
    parameters = lmfit.Parameters()
    for i, (value, low, high) in enumerate(zip(problem.start, *problem.bounds, strict=True)):
        parameters.add(f"p{i}", value=value, min=low, max=high)

    def run(limit: float) -> Run:
        trace = Trace(limit, problem.start)

        def fun(p: Any) -> Array:
            y = np.array([p[name].value for name in p])
            trace.see(y)
            return np.asarray(residual(y))

        def jac(p: Any) -> Array:
            return np.array(rows(np.array([p[name].value for name in p])))

        try:
            found = lmfit.minimize(
                fun, parameters.copy(), method="leastsq", Dfun=jac, col_deriv=1, ftol=_FTOL, xtol=_FTOL
            )
        except Stopped:
            return trace.stop()
        return trace.end(np.array([found.params[name].value for name in found.params]))

    return _alike(run)


def _scipy(problem: Problem) -> Contestant:
    least_squares = importlib.import_module("scipy.optimize").least_squares
    residual, rows = _warm(problem)

    def run(limit: float) -> Run:
        trace = Trace(limit, problem.start)

        def fun(y: Array) -> Array:
            trace.see(y)
            return np.asarray(residual(y))

        try:
            found = least_squares(
                fun,
                problem.start,
                lambda y: np.asarray(rows(y)).T,
                problem.bounds,
                method="trf",
                x_scale="jac",
                ftol=_FTOL,
            )
        except Stopped:
            return trace.stop()
        return trace.end(found.x)

    return _alike(run)


def _ceres(problem: Problem) -> Contestant:
    ceres = importlib.import_module("pyceres")
    count, size = len(problem.data), len(problem.start)
    blocks = [tuple(a[i : i + _CERES_BLOCK] for a in problem.samples) for i in range(0, count, _CERES_BLOCK)]
    residual = jax.jit(problem.residual)
    jacobian = jax.jit(jax.jacfwd(problem.residual))
    # Both in one call, since Ceres asks for both at once.
    both = jax.jit(lambda y, samples: (residual(y, samples), jacobian(y, samples)))

    class Block(ceres.CostFunction):
        def __init__(self, samples: Any):
            super().__init__()
            self.samples = samples
            self.set_num_residuals(samples[0].size)
            self.set_parameter_block_sizes([size])

        def Evaluate(self, parameters: Any, residuals: Any, jacobians: Any) -> bool:
            y = jnp.asarray(parameters[0])
            if jacobians is None:
                residuals[:] = residual(y, self.samples)
                return True
            residuals[:], found = both(y, self.samples)
            jacobians[0][:] = np.asarray(found).ravel()
            return True

    class Watch(ceres.IterationCallback):
        def __init__(self, trace: Trace, y: Array):
            super().__init__()
            self.trace, self.y = trace, y

        def __call__(self, summary: Any) -> Any:
            try:
                self.trace.see(self.y)
            except Stopped:
                return ceres.CallbackReturnType.SOLVER_ABORT
            return ceres.CallbackReturnType.SOLVER_CONTINUE

    def run(limit: float) -> Run:
        y = problem.start.copy()
        trace = Trace(limit, y)
        program = ceres.Problem()
        costs = [Block(samples) for samples in blocks]
        for cost in costs:
            program.add_residual_block(cost, None, [y])
        for i, (low, high) in enumerate(zip(*problem.bounds, strict=True)):
            program.set_parameter_lower_bound(y, i, low)
            program.set_parameter_upper_bound(y, i, high)
        options, summary, watch = ceres.SolverOptions(), ceres.SolverSummary(), Watch(trace, y)
        options.linear_solver_type = ceres.LinearSolverType.DENSE_NORMAL_CHOLESKY
        options.function_tolerance = _FTOL
        options.max_num_iterations = _STEPS_MAX
        options.logging_type = ceres.LoggingType.SILENT
        options.update_state_every_iteration = True
        options.callbacks = [watch]
        ceres.solve(options, program, summary)
        return trace.stop() if trace.late else trace.end(y)

    for samples in {block[0].shape: block for block in blocks}.values():
        jax.block_until_ready((residual(problem.start, samples), both(problem.start, samples)))
    return _alike(run)


def _warm(problem: Problem) -> tuple[Callable[[Any], jax.Array], Callable[[Any], jax.Array]]:
    """The compiled residual and Jacobian, after they were compiled."""
    for function in problem.compiled:
        jax.block_until_ready(function(problem.start))
    return problem.compiled


def _adam(problem: Problem) -> Contestant | None:
    run = adam(problem)
    return run and _alike(run)


_PEERS: Mapping[str, _Peer] = {
    OURS: _Peer("fitter", "finds its own start, arranges the samples and judges the fit within its time", _ours),
    "Optimistix LM": _Peer(
        "optimistix",
        f"LevenbergMarquardt, rtol = atol = {_OPTIMISTIX_TOL:g}, lineax.Normal(lineax.Cholesky()), compiled whole; "
        "knows no bounds",
        _optimistix,
    ),
    "lmfit": _Peer(
        "lmfit", f"leastsq (MINPACK), compiled Jacobian as Dfun with col_deriv, bounds, ftol = {_FTOL:g}", _lmfit
    ),
    "scipy trf": _Peer(
        "scipy", f"least_squares(trf), x_scale = jac, compiled Jacobian, bounds, ftol = {_FTOL:g}", _scipy
    ),
    "Ceres": _Peer(
        "pyceres",
        f"C++ solver through pyceres, DENSE_NORMAL_CHOLESKY, compiled residual and Jacobian in blocks of "
        f"{_CERES_BLOCK} samples, bounds, function_tolerance = {_FTOL:g}",
        _ceres,
    ),
    "torch Adam": _Peer(
        "torch", "full batch, our lambert+ggx in torch, bounds by a sigmoid; see fitter/bench/adam.py", _adam
    ),
}
