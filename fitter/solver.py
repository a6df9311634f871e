"""The bounded Levenberg-Marquardt method of `fitter.levenberg` for Optimistix, to use inside JAX programs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array

from .levenberg import DAMPING, NormalEquations, State, advance, begin


class BoundedLevenbergMarquardt(optx.AbstractLeastSquaresSolver):
    """Levenberg-Marquardt with bounds for `optimistix.least_squares`.

    Use it where a small fit is part of a JAX program that is mapped or compiled as a whole; `fitter.fit` drives the
    same method from the host. `options` may hold `lower` and `upper`, arrays like `y`, which must be a vector.

    **Arguments:**

    - `rtol`: stops when a full step would lower the cost by less than this share of it.
    - `atol`: stops when the cost is below it.
    - `normal_equations`: `(y, args) -> NormalEquations`; by default they are formed from the residual function, whose
      Jacobian is then stored whole.
    - `damping`: initial damping, relative to the diagonal of the Hessian.
    """

    rtol: float
    atol: float
    norm: Callable[[Any], Array] = optx.max_norm
    normal_equations: Callable[[Array, Any], NormalEquations] | None = None
    damping: float = DAMPING

    def _equations(self, fn: Any, y: Array, args: Any) -> NormalEquations:
        if self.normal_equations is not None:
            return self.normal_equations(y, args)

        def residual(y: Array) -> Array:
            return ravel_pytree(fn(y, args)[0])[0]

        r, push = jax.linearize(residual, y)
        jacobian = jax.vmap(push, out_axes=1)(jnp.eye(y.size, dtype=y.dtype))
        return NormalEquations(0.5 * jnp.vdot(r, r), jacobian.T @ r, jacobian.T @ jacobian)

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> State:
        return begin(y, *_bounds(y, options), damping=self.damping)

    def step(self, fn, y, args, options, state, tags):
        trial = self._equations(fn, state.trial, args)
        state = advance(state, trial, *_bounds(y, options), self.rtol, self.atol)
        return state.y, state, None

    def terminate(self, fn, y, args, options, state, tags):
        result = optx.RESULTS.where(state.stuck, optx.RESULTS.nonlinear_divergence, optx.RESULTS.successful)
        result = optx.RESULTS.where(state.failed, optx.RESULTS.nonfinite, result)
        return state.done | state.failed | state.stuck, result

    def postprocess(self, fn, y, aux, args, options, state, tags, result):
        return y, aux, {}


def _bounds(y: Array, options: dict[str, Any]) -> tuple[Array, Array]:
    infinite = jnp.full_like(y, jnp.inf)
    return options.get("lower", -infinite), options.get("upper", infinite)
