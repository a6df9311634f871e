"""A Levenberg-Marquardt solver with bounds, for Optimistix.

Marquardt's scaling by the diagonal keeps it free of the parameters' units; an active set, projected anew at each step,
keeps it inside the bounds without a transform of the parameters that would freeze at them. It works on the normal
equations alone, so that a large measurement never stores its Jacobian. Where a model misses the data, residuals stay
large and Gauss-Newton steps converge slowly: the curvature that they leave out is estimated from how the gradient
changes.

- Marquardt 1963, "An Algorithm for Least-Squares Estimation of Nonlinear Parameters".
- Nielsen 1999, "Damping Parameter in Marquardt's Method" (the update of the damping).
- Dennis, Gay, Welsch 1981, "An Adaptive Nonlinear Least-Squares Algorithm" (curvature from the change of gradients).
- Kanzow, Yamashita, Fukushima 2004, "Levenberg-Marquardt methods with strong local convergence properties for solving
  nonlinear equations with convex constraints" (projection).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float

from .normal import NormalEquations

# Damping up to which a step that would change nothing is proof of a minimum.
_DAMPING_FULL = 0.1
# Damping beyond which no step is left to try, its floor, and the most that one acceptance lowers it.
_DAMPING_MAX = 1e12
_DAMPING_MIN = 1e-12
_SHRINK_MIN = 0.02
# A rank-one update whose denominator is a smaller share than this of its factors is skipped as unsafe.
_PRODUCT_MIN = 1e-8
# A matrix whose smallest pivot, scaled, is below this is not used for a Newton step.
_PIVOT_MIN = 1e-10
# Rounds of solving and putting on a bound what a step would carry past it.
_ROUNDS = 3
# A diagonal element below this share of the largest one counts as zero when steps are scaled by the diagonal.
_DIAGONAL_MIN = 1e-14


class _State(NamedTuple):
    """Where the solver stands.

    - `equations`: at the current point; `curvature`: the estimate of what their Hessian leaves out, and `trusted`:
      whether it predicted the last step better than the Hessian alone.
    - `damping`, `growth`: relative to the diagonal of the Hessian, and the factor of the next rejection.
    - `done`: at a minimum; `failed`: not finite at the start; `stuck`: no step lowers the cost, yet a slope is left.
    """

    equations: NormalEquations
    curvature: Float[Array, "k k"]
    trusted: Bool[Array, ""]
    damping: Float[Array, ""]
    growth: Float[Array, ""]
    done: Bool[Array, ""]
    failed: Bool[Array, ""]
    stuck: Bool[Array, ""]


class BoundedLevenbergMarquardt(optx.AbstractLeastSquaresSolver):
    """Levenberg-Marquardt with bounds for `optimistix.least_squares`.

    `options` may hold `lower` and `upper`, arrays like `y`, which must be a vector.

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
    damping: float = 1e-3

    def _equations(self, fn: Any, y: Array, args: Any) -> NormalEquations:
        if self.normal_equations is not None:
            return self.normal_equations(y, args)

        def residual(y: Array) -> Array:
            return ravel_pytree(fn(y, args)[0])[0]

        r, push = jax.linearize(residual, y)
        jacobian = jax.vmap(push, out_axes=1)(jnp.eye(y.size, dtype=y.dtype))
        return NormalEquations(0.5 * jnp.vdot(r, r), jacobian.T @ r, jacobian.T @ jacobian)

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> _State:
        equations = self._equations(fn, y, args)
        one = jnp.ones((), y.dtype)
        failed = ~_is_finite(equations)
        curvature = jnp.zeros_like(equations.hessian)
        lower, upper = _bounds(y, options)
        done = (equations.cost <= self.atol) & jnp.all((y >= lower) & (y <= upper))
        no = jnp.zeros((), bool)
        return _State(equations, curvature, no, self.damping * one, 2 * one, done, failed, no)

    def step(self, fn, y, args, options, state, tags):
        lower, upper = _bounds(y, options)
        equations = state.equations
        full = equations._replace(hessian=equations.hessian + state.curvature)
        newton = bounded_step(full, y, lower, upper, state.damping)
        gauss = bounded_step(equations, y, lower, upper, state.damping)
        use = state.trusted & is_positive(full.hessian)
        delta, decrease = jax.tree.map(lambda a, b: jnp.where(use, a, b), newton, gauss)
        # A start outside the bounds is put on them first, whatever it costs.
        inside = jnp.clip(y, lower, upper)
        outside = jnp.any(inside != y)
        delta = jnp.where(outside, inside - y, delta)
        # The last step would change nothing: spare its evaluation. Damping alone must not make a step look so.
        small = (decrease >= 0) & (decrease <= self.rtol * equations.cost)
        stalled = small & (state.damping <= _DAMPING_FULL) & ~outside
        trial = jax.lax.cond(stalled, lambda: equations, lambda: self._equations(fn, y + delta, args))
        actual = equations.cost - trial.cost
        accepted = ((actual > 0) | outside) & _is_finite(trial)
        ratio = actual / jnp.maximum(decrease, jnp.finfo(y.dtype).tiny)
        shrink = jnp.clip(1 - (2 * ratio - 1) ** 3, _SHRINK_MIN, 2.0)
        damping = jnp.where(accepted, jnp.maximum(state.damping * shrink, _DAMPING_MIN), state.damping * state.growth)
        new = jax.tree.map(lambda a, b: jnp.where(accepted, a, b), trial, equations)
        curvature = jnp.where(accepted, _curvature(state.curvature, equations, trial, delta), state.curvature)
        # The curvature is used after it has predicted a step better than Gauss-Newton.
        trusted = jnp.abs(actual - _decrease(full, delta)) < jnp.abs(actual - _decrease(equations, delta))
        growth = jnp.where(accepted, 2.0, 2 * state.growth)
        done = stalled | ((new.cost <= self.atol) & accepted)
        stuck = damping > _DAMPING_MAX
        return (
            y + jnp.where(accepted, delta, 0.0),
            _State(new, curvature, trusted, damping, growth, done, state.failed, stuck),
            None,
        )

    def terminate(self, fn, y, args, options, state, tags):
        result = optx.RESULTS.where(state.stuck, optx.RESULTS.nonlinear_divergence, optx.RESULTS.successful)
        result = optx.RESULTS.where(state.failed, optx.RESULTS.nonfinite, result)
        return state.done | state.failed | state.stuck, result

    def postprocess(self, fn, y, aux, args, options, state, tags, result):
        return y, aux, {}


def _is_finite(equations: NormalEquations) -> Bool[Array, ""]:
    return jnp.all(jnp.stack([jnp.all(jnp.isfinite(part)) for part in equations]))


def _curvature(
    curvature: Float[Array, "k k"], old: NormalEquations, new: NormalEquations, delta: Float[Array, " k"]
) -> Float[Array, "k k"]:
    """The part of the Hessian that J^T J leaves out, from the change of the gradient (symmetric rank one).

    Sized first, as in Dennis, Gay, Welsch 1981: where the residuals shrink, what was left out shrinks with them.
    """
    change = new.gradient - old.gradient - new.hessian @ delta
    before = jnp.vdot(delta, curvature @ delta)
    size = jnp.abs(jnp.vdot(delta, change)) / jnp.maximum(jnp.abs(before), jnp.finfo(delta.dtype).tiny)
    curvature = curvature * jnp.minimum(size, 1.0)
    missing = change - curvature @ delta
    product = jnp.vdot(missing, delta)
    usable = jnp.abs(product) > _PRODUCT_MIN * jnp.linalg.norm(missing) * jnp.linalg.norm(delta)
    return curvature + jnp.where(usable, jnp.outer(missing, missing) / jnp.where(usable, product, 1.0), 0.0)


def is_positive(matrix: Float[Array, "k k"]) -> Bool[Array, ""]:
    """Whether a symmetric matrix is positive definite, by its pivots relative to its diagonal."""
    diagonal = jnp.diagonal(matrix)
    root = 1 / jnp.sqrt(jnp.maximum(diagonal, jnp.finfo(matrix.dtype).tiny))

    def eliminate(index: Array, state: tuple[Array, Array]) -> tuple[Array, Array]:
        matrix, smallest = state
        pivot = matrix[index, index]
        row = matrix[index] / jnp.where(pivot == 0, 1.0, pivot)
        matrix = matrix - jnp.outer(jnp.where(jnp.arange(len(row)) > index, matrix[:, index], 0.0), row)
        return matrix, jnp.minimum(smallest, pivot)

    scaled = matrix * root[:, None] * root[None, :]
    smallest = jax.lax.fori_loop(0, len(diagonal), eliminate, (scaled, jnp.ones((), matrix.dtype)))[1]
    return (smallest > _PIVOT_MIN) & jnp.all(diagonal > 0)


def _bounds(y: Array, options: dict[str, Any]) -> tuple[Array, Array]:
    infinite = jnp.full_like(y, jnp.inf)
    return options.get("lower", -infinite), options.get("upper", infinite)


def bounded_step(
    equations: NormalEquations,
    y: Float[Array, " k"],
    lower: Float[Array, " k"],
    upper: Float[Array, " k"],
    damping: Float[Array, ""],
) -> tuple[Float[Array, " k"], Float[Array, ""]]:
    """A damped Gauss-Newton step that stays inside the bounds, and the decrease of cost that it predicts.

    Elements at a bound whose gradient points outwards stay; those that the step would carry past a bound are put on it
    and the others solved again.
    """
    gradient, hessian = equations.gradient, equations.hessian
    diagonal = jnp.diagonal(hessian)
    scale = jnp.maximum(diagonal, _DIAGONAL_MIN * jnp.max(diagonal) + jnp.finfo(y.dtype).tiny)
    held = ((y <= lower) & (gradient > 0)) | ((y >= upper) & (gradient < 0))
    delta = jnp.zeros_like(y)
    for _ in range(_ROUNDS):
        right = jnp.where(held, delta, -gradient - hessian @ jnp.where(held, delta, 0.0))
        free = ~held
        matrix = jnp.where(free[:, None] & free[None, :], hessian, 0.0)
        matrix = matrix + jnp.diag(jnp.where(free, damping * scale, 1.0))
        delta = solve_positive(matrix, right)
        outside = (y + delta < lower) | (y + delta > upper)
        delta = jnp.clip(y + delta, lower, upper) - y
        held = held | outside
    decrease = _decrease(equations, delta)
    # Cutting can spoil a step. A projected gradient step, scaled by the diagonal and shorter than 1 / k, never goes
    # uphill, since no eigenvalue of a k x k matrix with unit diagonal exceeds k.
    safe = jnp.clip(y - gradient / ((y.size + damping) * scale), lower, upper) - y
    use = decrease > 0
    return jnp.where(use, delta, safe), jnp.where(use, decrease, _decrease(equations, safe))


def _decrease(equations: NormalEquations, delta: Float[Array, " k"]) -> Float[Array, ""]:
    return -(jnp.vdot(equations.gradient, delta) + 0.5 * jnp.vdot(delta, equations.hessian @ delta))


def solve_positive(matrix: Float[Array, "k k"], right: Float[Array, " k"]) -> Float[Array, " k"]:
    """Solves a small symmetric positive definite system by elimination, without LAPACK.

    A compiled program that calls LAPACK cannot be kept on disk and loaded by another process.
    """
    root = 1 / jnp.sqrt(jnp.maximum(jnp.diagonal(matrix), jnp.finfo(matrix.dtype).tiny))
    augmented = jnp.concatenate([matrix * root[:, None] * root[None, :], (right * root)[:, None]], axis=1)

    def eliminate(index: Array, augmented: Array) -> Array:
        pivot = augmented[index] / jnp.maximum(augmented[index, index], jnp.finfo(matrix.dtype).eps)
        factors = augmented[:, index].at[index].set(0.0)
        return (augmented - factors[:, None] * pivot[None, :]).at[index].set(pivot)

    return jax.lax.fori_loop(0, right.size, eliminate, augmented)[:, -1] * root
