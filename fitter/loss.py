"""How a fit compares a model with a measurement.

Both values are compressed, `z = c(f, cos_i)`, and the difference of the two is judged by a function that is quadratic
near 0. A loss is named by its compression and, if it has one, its treatment of large differences:

    log           log(1 + f cos_i), follows the eye's sense of brightness and keeps a highlight from drowning the rest
                  (Low 2012); softened beyond one e-fold, so that a highlight that no model can follow pulls less
    log_squares   the same with plain squares
    cosine        f cos_i (Lafortune 1997, Ngan 2005)
    cube_root     (f cos_i)^(1/3) (Fores 2012)
    square_root   (f cos_i)^(1/2)
    linear        f

and `log_huber`, `cosine_huber`, ... for the same with Huber's function, linear beyond a fifth of the median compressed
value. `adaptive` (see `fitter.fit`) fits with several of them and keeps the fit whose picture is nearest to the
measurement's (Bieron and Peers 2020).

- Bieron, Peers 2020, "An Adaptive BRDF Fitting Metric".
- Charbonnier, Blanc-Feraud, Aubert, Barlaud 1997, "Deterministic edge-preserving regularization in computed imaging".
- Fores, Ferwerda, Gu 2012, "Toward a Perceptually Based Metric for BRDF Modeling".
- Huber 1964, "Robust Estimation of a Location Parameter".
- Lafortune, Foo, Torrance, Greenberg 1997, "Non-Linear Approximation of Reflectance Functions".
- Low, Kronander, Ynnerman, Unger 2012, "BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces".
- Ngan, Durand, Matusik 2005, "Experimental Analysis of BRDF Models".
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Values = Float[Array | np.ndarray, "3 n"]
Cosines = Float[Array | np.ndarray, "1 n"]
Compression = Callable[[Values, Cosines], Values]

# Huber's threshold as a share of the median compressed value.
_HUBER = 0.2
# Roots have no derivative at 0: values are raised by this share of a white diffuse surface's.
_DARK = 1e-4


class Judged(NamedTuple):
    """What a residual r contributes, all shape (3, n).

    - `cost`: rho(r).
    - `slope`: rho'(r).
    - `curvature`: of the Gauss-Newton approximation to rho in the residual's root, `(d sqrt(2 rho) / dr)^2`.
    """

    cost: Values
    slope: Values
    curvature: Values


def _squares(r: Values, scale: Any) -> Judged:
    return Judged(0.5 * r * r, r, jnp.ones_like(r))


def _charbonnier(r: Values, scale: Any) -> Judged:
    """Quadratic below 1, linear above (Charbonnier 1997)."""
    q = jnp.sqrt(1 + r * r)
    inverse = 1 / q
    return Judged(r * r / (q + 1), r * inverse, 0.5 * (1 + q) * inverse * inverse)


def _huber(r: Values, scale: Any) -> Judged:
    """Quadratic below a share of the scale, linear above (Huber 1964)."""
    threshold = _HUBER * scale
    size = jnp.abs(r)
    beyond = size > threshold
    safe = jnp.where(beyond, size, threshold)
    cost = jnp.where(beyond, threshold * (safe - 0.5 * threshold), 0.5 * r * r)
    return Judged(cost, jnp.clip(r, -threshold, threshold), jnp.where(beyond, threshold / (2 * safe - threshold), 1.0))


def log_compress(value: Values, cos_i: Cosines) -> Values:
    """`log(1 + f cos_i)` (Low 2012), in which every fit reports its error."""
    return jnp.log1p(value * cos_i)


def _root(power: float) -> Compression:
    return lambda value, cos_i: (value * cos_i + _DARK) ** power


_COMPRESSIONS: dict[str, Compression] = {
    "log": log_compress,
    "cosine": lambda value, cos_i: value * cos_i,
    "cube_root": _root(1 / 3),
    "square_root": _root(1 / 2),
    "linear": lambda value, cos_i: value,
}


@dataclasses.dataclass(frozen=True)
class Loss:
    """A compression of values, and a function of the difference and, if it needs that scale, of the median compressed
    value."""

    compress: Compression
    judge: Callable[[Values, Any], Judged]
    needs_scale: bool = False


LOSSES: dict[str, Loss] = {
    "log": Loss(log_compress, _charbonnier),
    "log_squares": Loss(log_compress, _squares),
    **{name: Loss(compress, _squares) for name, compress in _COMPRESSIONS.items() if name != "log"},
    **{f"{name}_huber": Loss(compress, _huber, True) for name, compress in _COMPRESSIONS.items()},
}


def compressed(loss: Loss, value: Values, cos_i: Cosines) -> tuple[Values, Values]:
    """The compressed value and its derivative by the value, both (3, n)."""
    return jax.jvp(lambda f: loss.compress(f, cos_i), (value,), (jnp.ones_like(value),))
