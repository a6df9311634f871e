"""Smooth functions of one or two numbers without a closed form, as sums of Chebyshev polynomials.

Such a table is computed once by quadrature, has every derivative, and is the same few hundred numbers in Python and in
GLSL (`shaders/table_text.py` writes the twin).

- Trefethen 2013, "Approximation Theory and Approximation Practice", chapters 3 and 19.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .frame import Scalar


@dataclasses.dataclass(frozen=True)
class Chebyshev:
    """A function of x, or of x and y, both in [0, 1].

    - `coefficients`: shape (m,) or (m, n), float64: of T_i(2x - 1), or of T_i(2x - 1) T_j(2y - 1).
    """

    coefficients: Float[np.ndarray, "..."]

    def __call__(self, x: Scalar, *y: Scalar) -> Scalar:
        """The value at x, or at x and y. What depends on y alone is computed first: it is often a parameter."""
        t = 2 * jnp.asarray(x) - 1
        rows = jnp.asarray(self.coefficients, t.dtype)
        if y:
            rows = rows @ self._polynomials(2 * jnp.asarray(y[0]) - 1, rows.shape[1])
        return _clenshaw([rows[index] for index in range(len(rows))], t)

    @staticmethod
    def _polynomials(t: Scalar, count: int) -> Float[Array, " n"]:
        found = [jnp.ones_like(t), t]
        while len(found) < count:
            found.append(2 * t * found[-1] - found[-2])
        return jnp.stack(found)


def _clenshaw(coefficients: list[Scalar], t: Scalar) -> Scalar:
    after = later = jnp.zeros_like(t)
    for coefficient in coefficients[:0:-1]:
        after, later = 2 * t * after - later + coefficient, after
    return t * after - later + coefficients[0]


def interpolate(function: Callable[..., Float[np.ndarray, "..."]], *counts: int) -> Chebyshev:
    """The polynomial that equals a function at Chebyshev points.

    **Arguments:**

    - `function`: takes an array per variable, all of one shape, in (0, 1), and returns the values, float64.
    - `counts`: the number of points per variable, one or two.
    """
    points = [0.5 + 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count) for count in counts]
    values = np.asarray(function(*np.meshgrid(*points, indexing="ij")), np.float64)
    for axis, count in enumerate(counts):
        cosines = np.cos(np.pi * np.outer(np.arange(count), np.arange(count) + 0.5) / count) * (2 / count)
        cosines[0] *= 0.5
        values = np.moveaxis(np.tensordot(cosines, values, (1, axis)), 0, axis)
    return Chebyshev(values)
