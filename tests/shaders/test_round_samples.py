"""The non-negative least squares of the round lobes. Oracle: `scipy.optimize.nnls`, an active-set method."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from shaders.round_samples import non_negative


@pytest.mark.parametrize(("rows", "size"), [(40, 12), (200, 49), (70, 70), (300, 3)])
def test_amplitudes_are_those_of_an_active_set_method(rows: int, size: int):
    rng = np.random.default_rng([rows, size])
    for _ in range(10):
        # Of positive columns, as kernels are: many of the best coefficients are 0.
        a, b = rng.random((rows, size)), rng.normal(size=rows)
        found, expected = non_negative(a.T @ a, a.T @ b), nnls(a, b)[0]
        np.testing.assert_allclose(found, expected, atol=1e-6 * max(np.abs(expected).max(), 1))
        assert found.min() >= 0


@pytest.mark.parametrize("rank", [1, 3])
def test_columns_that_depend_on_each_other_give_as_small_an_error(rank: int):
    rng = np.random.default_rng(rank)
    for _ in range(10):
        a = rng.random((30, rank)) @ rng.random((rank, 9))
        b = rng.random(30)
        found = non_negative(a.T @ a, a.T @ b)
        assert np.linalg.norm(a @ found - b) == pytest.approx(nnls(a, b)[1], rel=1e-5)
        assert found.min() >= 0


@pytest.mark.parametrize("right", [np.zeros(4), -np.ones(4)], ids=["zero", "negative"])
def test_nothing_to_explain_is_nothing(right: np.ndarray):
    a = np.random.default_rng(2).random((9, 4))
    np.testing.assert_array_equal(non_negative(a.T @ a, right), 0)


def test_columns_of_zeros_are_not_used():
    a = np.random.default_rng(3).random((20, 5))
    a[:, 2] = 0
    found = non_negative(a.T @ a, a.T @ np.ones(20))
    assert np.isfinite(found).all()
    assert found[2] == pytest.approx(0, abs=1e-9)
