"""A Levenberg-Marquardt method with bounds, as one pure function from a trial point to the next.

Marquardt's scaling by the diagonal keeps it free of the parameters' units; an active set, projected anew at each step,
keeps it inside the bounds without a transform of the parameters that would freeze at them. It works on the normal
equations alone, so that a large measurement never stores its Jacobian. Where a model misses the data, residuals stay
large and Gauss-Newton steps converge slowly: the curvature that they leave out is estimated from how the gradient
changes.

It owns no loop: `fitter.minimise` drives it from the host, where the equations are a compiled pass over the data, and
`fitter.solver` from within JAX.

- Marquardt 1963, "An Algorithm for Least-Squares Estimation of Nonlinear Parameters".
- Nielsen 1999, "Damping Parameter in Marquardt's Method" (the update of the damping).
- Nocedal, Wright 2006, "Numerical Optimization" (active set of a bounded quadratic).
- Dennis, Gay, Welsch 1981, "An Adaptive Nonlinear Least-Squares Algorithm" (curvature from the change of gradients).
- Kanzow, Yamashita, Fukushima 2004, "Levenberg-Marquardt methods with strong local convergence properties for solving
  nonlinear equations with convex constraints" (projection).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

Scalar = Float[Array | np.ndarray, ""]
Flag = Bool[Array | np.ndarray, ""]
Vector = Float[Array | np.ndarray, " k"]
Matrix = Float[Array | np.ndarray, "k k"]

# The first damping.
DAMPING = 1e-3
# Damping up to which a step that would change nothing is proof of a minimum.
_DAMPING_FULL = 0.1
# Damping beyond which no step is left to try, its floor, and the most that one acceptance lowers it.
_DAMPING_MAX = 1e12
_DAMPING_MIN = 1e-12
_SHRINK_MIN = 0.02
_SHRINK_AFTER = 0.5
# A rank-one update whose denominator is a smaller share than this of its factors is skipped as unsafe.
_PRODUCT_MIN = 1e-8
# A matrix whose smallest pivot, scaled, is below this is not used for a Newton step.
_PIVOT_MIN = 1e-10
# Rounds of the search for the elements that a step puts on their bounds, per element.
_ROUNDS = 3
# A slope below this share of the largest does not pull an element from its bound.
_PULL_MIN = 1e-12
# A diagonal element below this share of the largest one counts as zero when steps are scaled by the diagonal.
_DIAGONAL_MIN = 1e-14


class NormalEquations(NamedTuple):
    """Cost, gradient and Gauss-Newton Hessian of a least-squares problem at one point.

    - `cost`: half the sum of squared residuals.
    - `gradient`: shape (k,), J^T r.
    - `hessian`: shape (k, k), J^T J.
    """

    cost: Scalar
    gradient: Vector
    hessian: Matrix


class State(NamedTuple):
    """Where the method stands.

    - `y`, `equations`: the best point so far, and what was found there.
    - `delta`, `decrease`: the step to the next trial point, and by how much the cost should fall.
    - `curvature`: the estimate of what the Hessian leaves out, and `trusted`: whether it predicted the last step better
      than the Hessian alone.
    - `damping`, `growth`: relative to the diagonal of the Hessian, and the factor of the next rejection.
    - `done`: at a minimum; `failed`: not finite at the start; `stuck`: no step lowers the cost, yet a slope is left.
    """

    y: Vector
    equations: NormalEquations
    delta: Vector
    decrease: Scalar
    curvature: Matrix
    trusted: Flag
    damping: Scalar
    growth: Scalar
    done: Flag
    failed: Flag
    stuck: Flag

    @property
    def trial(self) -> Vector:
        """Where the equations are wanted next."""
        return self.y + self.delta


def begin(
    y: Vector,
    lower: Vector,
    upper: Vector,
    curvature: Matrix | None = None,
    damping: float = DAMPING,
) -> State:
    """The state before anything is known: its trial point is `y`, put inside the bounds.

    **Arguments:**

    - `curvature`: what is known beforehand of the curvature that J^T J leaves out, which is trusted then.
    - `damping`: the first, relative to the diagonal of the Hessian.
    """
    # Outside JAX nothing is to be compiled for this.
    xp: Any = np if isinstance(y, np.ndarray) else jnp
    k, no = y.size, xp.zeros((), bool)
    one, infinite = xp.ones((), y.dtype), xp.full((), np.inf, y.dtype)
    blank = NormalEquations(infinite, xp.zeros(k, y.dtype), xp.zeros((k, k), y.dtype))
    known = xp.zeros((k, k), y.dtype) if curvature is None else xp.asarray(curvature, y.dtype)
    return State(
        y=xp.clip(y, lower, upper),
        equations=blank,
        delta=xp.zeros(k, y.dtype),
        decrease=infinite,
        curvature=known,
        trusted=xp.asarray(curvature is not None),
        damping=xp.asarray(damping * one),
        growth=xp.asarray(2 * one),
        done=no,
        failed=no,
        stuck=no,
    )


def advance(
    state: State,
    trial: NormalEquations,
    lower: Vector,
    upper: Vector,
    rtol: float | Scalar,
    atol: float | Scalar,
) -> State:
    """Takes or leaves the trial point, whose equations are given, and proposes the next.

    **Arguments:**

    - `trial`: the equations at `state.trial`.
    - `rtol`: done when a full step would lower the cost by less than this share of it; `delta` holds that last step.
    - `atol`: done when the cost is below it.
    """
    old, y = state.equations, state.y
    is_first = jnp.isinf(old.cost)
    is_good = is_finite(trial)
    actual = old.cost - trial.cost
    accepted = (actual > 0) & is_good
    taken = accepted & ~is_first
    ratio = actual / jnp.maximum(state.decrease, jnp.finfo(y.dtype).tiny)
    # Damping that has just had to rise must not fall at once below what was refused.
    shrink = jnp.clip(1 - (2 * ratio - 1) ** 3, jnp.where(state.growth > 2, _SHRINK_AFTER, _SHRINK_MIN), 2.0)
    lowered = jnp.maximum(state.damping * shrink, _DAMPING_MIN)
    damping = jnp.where(taken, lowered, jnp.where(is_first, state.damping, state.damping * state.growth))
    equations = jax.tree.map(lambda a, b: jnp.where(accepted, a, b), trial, old)
    y = jnp.where(accepted, state.trial, y)
    curvature = jnp.where(taken, _curvature(state.curvature, old, trial, state.delta), state.curvature)
    # The curvature is used after it has predicted a step better than Gauss-Newton.
    full = _decrease(old, state.delta) - 0.5 * jnp.vdot(state.delta, state.curvature @ state.delta)
    better = jnp.abs(actual - full) < jnp.abs(actual - _decrease(old, state.delta))
    trusted = jnp.where(is_first, state.trusted, better)
    bent = equations.hessian + curvature
    use = trusted & is_positive(bent)
    proposed = equations._replace(hessian=jnp.where(use, bent, equations.hessian))
    delta, decrease = bounded_step(proposed, y, lower, upper, damping)
    # Damping alone must not make a step look as if it changed nothing.
    small = (decrease >= 0) & (decrease <= rtol * equations.cost) & (damping <= _DAMPING_FULL)
    return State(
        y=y,
        equations=equations,
        delta=delta,
        decrease=decrease,
        curvature=curvature,
        trusted=trusted,
        damping=damping,
        growth=jnp.where(accepted, 2.0, 2 * state.growth),
        done=small | (equations.cost <= atol),
        failed=is_first & ~is_good,
        stuck=damping > _DAMPING_MAX,
    )


def is_finite(equations: NormalEquations) -> Flag:
    return jnp.all(jnp.stack([jnp.all(jnp.isfinite(part)) for part in equations]))


def _curvature(curvature: Matrix, old: NormalEquations, new: NormalEquations, delta: Vector) -> Matrix:
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
    return curvature + jnp.where(usable, missing[:, None] * missing[None, :] / jnp.where(usable, product, 1.0), 0.0)


def is_positive(matrix: Matrix) -> Flag:
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


def bounded_step(
    equations: NormalEquations,
    y: Vector,
    lower: Vector,
    upper: Vector,
    damping: Scalar,
) -> tuple[Vector, Scalar]:
    """The damped Gauss-Newton step that is best inside the bounds, and the decrease of cost that it predicts.

    An active set (Nocedal, Wright 2006): it walks to the first bound in the way and holds that element,
    and when nothing is in the way lets go of the held element whose slope most wants to leave its bound.
    """
    gradient, hessian = equations.gradient, equations.hessian
    diagonal = jnp.diagonal(hessian)
    scale = jnp.maximum(diagonal, _DIAGONAL_MIN * jnp.max(diagonal) + jnp.finfo(y.dtype).tiny)
    damped = hessian + jnp.diag(damping * scale)
    root = jnp.sqrt(scale)
    low, high, fixed = lower - y, upper - y, lower >= upper

    def walk(state: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        held, delta, rounds, _ = state
        free = ~held
        slope = gradient + damped @ delta
        matrix = jnp.where(free[:, None] & free[None, :], damped, jnp.diag(scale))
        step = solve_positive(matrix, jnp.where(free, -slope, 0.0))
        end = jnp.where(step > 0, high, low)
        room = jnp.where(free & (step != 0), (end - delta) / jnp.where(step == 0, 1.0, step), jnp.inf)
        first = jnp.argmin(room)
        is_blocked = room[first] < 1
        delta = jnp.clip(jnp.where(is_blocked, delta + room[first] * step, delta + step), low, high)
        delta = jnp.where(is_blocked & (jnp.arange(y.size) == first), end, delta)
        slope = (gradient + damped @ delta) / root
        pull = jnp.where(held & ~fixed, jnp.where(delta <= low, -slope, slope), 0.0)
        worst = jnp.argmax(pull)
        is_pulled = ~is_blocked & (pull[worst] > _PULL_MIN * jnp.linalg.norm(gradient / root))
        change = jnp.where(is_blocked, first, worst)
        held = jnp.where((jnp.arange(y.size) == change) & (is_blocked | is_pulled), is_blocked, held)
        return held, delta, rounds + 1, is_blocked | is_pulled

    held = jnp.asarray(((y <= lower) & (gradient > 0)) | ((y >= upper) & (gradient < 0)) | fixed)
    start = held, jnp.zeros_like(y), jnp.zeros((), jnp.int32), jnp.ones((), bool)
    delta = jax.lax.while_loop(lambda state: state[3] & (state[2] < _ROUNDS * y.size), walk, start)[1]
    return delta, _decrease(equations, delta)


def _decrease(equations: NormalEquations, delta: Vector) -> Scalar:
    return -(jnp.vdot(equations.gradient, delta) + 0.5 * jnp.vdot(delta, equations.hessian @ delta))


def solve_positive(matrix: Matrix, right: Vector) -> Vector:
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
