"""The solver against closed forms, SciPy and Optimistix's own Levenberg-Marquardt."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
import scipy.optimize

from fitter.levenberg import NormalEquations, bounded_step, solve_positive
from fitter.solver import BoundedLevenbergMarquardt

SOLVER = BoundedLevenbergMarquardt(rtol=1e-14, atol=1e-28)


def solve(fn, y0, args=None, **options):
    options = {name: jnp.asarray(value) for name, value in options.items()}
    return optx.least_squares(fn, SOLVER, jnp.asarray(y0), args, options, max_steps=500, throw=False)


def rosenbrock(y, _):
    return jnp.stack([10 * (y[1] - y[0] ** 2), 1 - y[0]])


def decay(y, t):
    return y[0] * jnp.exp(-y[1] * t) + y[2]


def test_rosenbrock_reaches_its_known_minimum():
    solution = solve(rosenbrock, [-1.2, 1.0])
    assert solution.result == optx.RESULTS.successful
    np.testing.assert_allclose(solution.value, [1, 1], rtol=1e-9)


def test_a_bound_that_cuts_off_the_minimum_holds_the_solution():
    # On y0 = 0.5 the best y1 is y0^2, in closed form.
    solution = solve(rosenbrock, [-1.2, 1.0], lower=[-2.0, -2.0], upper=[0.5, 2.0])
    np.testing.assert_allclose(solution.value, [0.5, 0.25], rtol=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_bounded_linear_problems_equal_scipy(seed):
    rng = np.random.default_rng(seed)
    matrix, right = rng.normal(size=(40, 6)), rng.normal(size=40) * 3
    lower, upper = -0.3 * rng.random(6), 0.3 * rng.random(6)
    truth = scipy.optimize.lsq_linear(matrix, right, (lower, upper), method="bvls", tol=1e-14).x
    solution = solve(lambda y, a: a[0] @ y - a[1], np.zeros(6), (matrix, right), lower=lower, upper=upper)
    np.testing.assert_allclose(solution.value, truth, atol=1e-9)


def test_a_noisy_curve_equals_optimistix_levenberg_marquardt():
    rng = np.random.default_rng(3)
    t = np.linspace(0, 4, 80)
    data = 2.0 * np.exp(-1.3 * t) + 0.5 + 0.05 * rng.normal(size=80)
    fn = lambda y, _: decay(y, t) - data  # noqa: E731
    peer = optx.least_squares(fn, optx.LevenbergMarquardt(rtol=1e-12, atol=1e-12), jnp.ones(3), max_steps=500)
    np.testing.assert_allclose(solve(fn, np.ones(3)).value, peer.value, rtol=1e-6)


def test_parameters_of_very_different_units_are_found():
    # Oracle: the problem's own construction. Unscaled damping stalls here.
    t = np.linspace(0, 4, 60)
    data = decay(np.array([2e6, 1.3, 5e-4 * 1e6]), t)
    solution = solve(lambda y, _: (y[0] * 1e6 * jnp.exp(-y[1] * t) + y[2] * 1e-3) - data, [1.0, 1.0, 1.0])
    np.testing.assert_allclose(solution.value, [2, 1.3, 5e5], rtol=1e-6)


def test_a_start_that_is_not_finite_is_reported():
    solution = solve(lambda y, _: jnp.log(y), [-1.0])
    assert solution.result == optx.RESULTS.nonfinite


def test_a_start_without_a_finite_gradient_is_reported():
    solution = solve(lambda y, _: jnp.stack([jnp.sqrt(y[0]) - 1, y[1] - 3]), [0.0, 0.0])
    assert solution.result == optx.RESULTS.nonfinite


def test_a_wall_of_nan_is_never_called_a_minimum():
    def wall(y, _):
        return jnp.stack([y[0] - 2, y[1] - 1 + 0 * jnp.sqrt(1 - y[0])])

    solution = solve(wall, [0.0, 0.0])
    if solution.result == optx.RESULTS.successful:
        np.testing.assert_allclose(solution.value[1], 1, atol=1e-6)


def test_a_start_outside_the_bounds_is_put_inside():
    solution = solve(lambda y, _: y + 5, [-1.0], lower=[0.0], upper=[9.0])
    assert solution.result == optx.RESULTS.successful
    np.testing.assert_allclose(solution.value, [0.0], atol=1e-12)


MEYER = np.array(
    [34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820, 3307, 2872], float
)


def test_meyer_reaches_its_published_minimum():
    # Oracle: More, Garbow, Hillstrom 1981, problem 10: sum of squares 87.9458.
    t = 45 + 5.0 * np.arange(1, 17)
    solution = solve(lambda y, _: y[0] * jnp.exp(y[1] / (t + y[2])) - MEYER, [0.02, 4000.0, 250.0])
    assert 2 * float(solution.state.equations.cost) == pytest.approx(87.9458, rel=1e-5)


def test_helical_valley_reaches_its_minimum_quickly():
    # Oracle: More, Garbow, Hillstrom 1981, problem 7: zero at (1, 0, 0).
    def helix(y, _):
        theta = jnp.arctan2(y[1], y[0]) / (2 * jnp.pi)
        return jnp.stack([10 * (y[2] - 10 * theta), 10 * (jnp.hypot(y[0], y[1]) - 1), y[2]])

    solution = solve(helix, [-1.0, 1e-3, 0.0])
    np.testing.assert_allclose(solution.value, [1, 0, 0], atol=1e-9)
    assert int(solution.stats["num_steps"]) < 40


def test_running_out_of_steps_is_reported():
    solution = optx.least_squares(rosenbrock, SOLVER, jnp.array([-1.2, 1.0]), max_steps=2, throw=False)
    assert solution.result == optx.RESULTS.nonlinear_max_steps_reached


def test_small_systems_equal_numpy():
    rng = np.random.default_rng(4)
    for size in (1, 2, 7, 15):
        root = rng.normal(size=(size, size)) * 10.0 ** rng.uniform(-4, 4, size)
        matrix, right = root.T @ root + 1e-3 * np.diag(np.diag(root.T @ root)), rng.normal(size=size)
        truth = np.linalg.solve(matrix, right)
        np.testing.assert_allclose(solve_positive(jnp.asarray(matrix), jnp.asarray(right)), truth, rtol=1e-6)


def test_a_step_never_leaves_the_bounds():
    rng = np.random.default_rng(5)
    step = jax.jit(bounded_step)
    for _ in range(20):
        root = rng.normal(size=(8, 5))
        lower, upper = -rng.random(5), rng.random(5)
        y = rng.uniform(lower, upper)
        equations = NormalEquations(jnp.ones(()), jnp.asarray(rng.normal(size=5) * 5), jnp.asarray(root.T @ root))
        delta, decrease = step(equations, jnp.asarray(y), jnp.asarray(lower), jnp.asarray(upper), jnp.asarray(1e-3))
        assert (y + delta >= lower - 1e-15).all()
        assert (y + delta <= upper + 1e-15).all()
        assert decrease >= 0
