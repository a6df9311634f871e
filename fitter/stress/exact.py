"""A function traced by JAX, evaluated in 50-digit arithmetic: the exact value of a formula as it is written.

`exact` runs the function's own jaxpr on NumPy arrays of mpmath numbers, so it needs no second version of any model. The
inputs and the constants in the jaxpr count as exact binary numbers. Nothing overflows or underflows, and there is no
negative zero; division by zero, and functions outside their domain, give Inf and NaN as IEEE arithmetic does.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Sequence
from typing import Any

import jax
import mpmath
import numpy as np
from jax.extend import core
from numpy.typing import NDArray

DIGITS = 50
# Typed loosely: mpmath makes most of its functions at run time.
_MP: Any = mpmath.MPContext()
_MP.dps = DIGITS
# exp of more is zero or infinite in any arithmetic that is compared with this one, and takes mpmath for ever.
_EXPONENT_MAX = _MP.mpf(10) ** 8

Array = NDArray[Any]


def number(value: Any) -> Any:
    """A floating-point number as the 50-digit number that it stands for exactly."""
    return _MP.mpf(float(value))


def digits(value: Any) -> str:
    """A 50-digit number, shortened for a message."""
    return _MP.nstr(value, 20)


def exact(function: Callable[..., Any], *arguments: Any) -> Array:
    """The value of a function in 50-digit arithmetic.

    **Arguments:**

    - `function`: what JAX can trace, from arrays to one array. It is traced in float64.
    - `arguments`: trees of floating-point arrays, taken as exact.

    **Returns:** an array of mpmath numbers, as many as the function's value has.

    **Raises:** `NotImplementedError`, naming it, for an operation that has no 50-digit version here.
    """
    leaves = [np.asarray(leaf, np.float64) for leaf in jax.tree.leaves(arguments)]
    with jax.enable_x64(True):
        traced = jax.make_jaxpr(function)(*jax.tree.map(lambda leaf: np.asarray(leaf, np.float64), arguments))
        (value,) = _run(traced.jaxpr, [_lift(c) for c in traced.consts], [_lift(leaf) for leaf in leaves])
    return value


def _lift(value: Any) -> Array:
    """Floats become mpmath numbers; integers and booleans stay as they are."""
    array = np.asarray(value)
    return _NUMBER(array.astype(np.float64)) if array.dtype.kind == "f" else array


def _objects(function: Callable[..., Any], arity: int) -> Callable[..., Array]:
    """A function of mpmath numbers as one of arrays."""
    ufunc = np.frompyfunc(function, arity, 1)
    # Of arrays without axes NumPy makes plain objects.
    return lambda *arrays: np.asarray(ufunc(*arrays), object)


_NUMBER = _objects(number, 1)


def _run(jaxpr: Any, consts: Sequence[Array], arguments: Sequence[Array]) -> list[Array]:
    known: dict[Any, Array] = dict(zip([*jaxpr.constvars, *jaxpr.invars], [*consts, *arguments], strict=True))

    def read(atom: Any) -> Array:
        return _lift(atom.val) if isinstance(atom, core.Literal) else known[atom]

    for equation in jaxpr.eqns:
        found = _apply(equation, [read(atom) for atom in equation.invars])
        known.update(zip(equation.outvars, found, strict=True))
    return [read(atom) for atom in jaxpr.outvars]


def _apply(equation: Any, inputs: list[Array]) -> list[Array]:
    name, params = equation.primitive.name, equation.params
    inner = next((params[key] for key in ("jaxpr", "call_jaxpr", "fun_jaxpr") if key in params), None)
    if name in _CALLS and inner is not None:
        closed = hasattr(inner, "consts")
        return _run(inner.jaxpr if closed else inner, [_lift(c) for c in inner.consts] if closed else [], inputs)
    if not any(array.dtype == object for array in inputs) and equation.outvars[0].aval.dtype.kind != "f":
        # Integers and truth values are exact in JAX itself.
        found = equation.primitive.bind(*inputs, **params)
        return [np.asarray(one) for one in (found if equation.primitive.multiple_results else [found])]
    if name in _ELEMENTWISE:
        return [_ELEMENTWISE[name](*inputs)]
    if name in _COMPARISONS:
        return [np.asarray(_COMPARISONS[name](*inputs), bool)]
    if name in _REDUCTIONS:
        return [np.asarray(_REDUCTIONS[name](inputs[0], axis=tuple(params["axes"])), object)]
    if name in _MOVES:
        return _move(equation, inputs)
    if name in _WITH_PARAMS:
        return [_WITH_PARAMS[name](params, *inputs)]
    raise NotImplementedError(
        f"`{name}` has no 50-digit version. Add it to fitter/stress/exact.py, beside the operations that it resembles."
    )


def _move(equation: Any, inputs: list[Array]) -> list[Array]:
    """What only moves elements: JAX moves their positions, and the numbers follow."""
    places, pool, start = [], [], 0
    for array, atom in zip(inputs, equation.invars, strict=True):
        if atom.aval.dtype.kind == "f":
            places.append(np.arange(start, start + array.size, dtype=np.int64).reshape(array.shape))
            pool.append(array.reshape(-1))
            start += array.size
        else:
            places.append(array)
    # What lies outside its array reads the last of the numbers, a NaN, as it does in JAX.
    pool.append(np.array([_MP.nan], object))
    params = equation.params | ({"fill_value": -1} if "fill_value" in equation.params else {})
    found = equation.primitive.bind(*places, **params)
    found = found if equation.primitive.multiple_results else [found]
    return [np.asarray(np.concatenate(pool)[np.asarray(moved)], object) for moved in found]


def _nan_outside(function: Callable[[Any], Any], inside: Callable[[Any], bool]) -> Callable[[Any], Any]:
    return lambda x: function(x) if inside(x) else _MP.nan


def _divide(x: Any, y: Any) -> Any:
    if y != 0:
        return x / y
    return _MP.nan if x == 0 or x != x else _MP.inf * (1 if x > 0 else -1)


def _exp(x: Any) -> Any:
    if abs(x) <= _EXPONENT_MAX or x != x:
        return _MP.exp(x)
    return _MP.inf if x > 0 else _MP.zero


def _log(x: Any) -> Any:
    if x > 0:
        return _MP.log(x)
    return -_MP.inf if x == 0 else _MP.nan


def _power(x: Any, y: Any) -> Any:
    if x > 0:
        return _exp(y * _MP.log(x))
    if x == 0:
        return _MP.one if y == 0 else (_MP.zero if y > 0 else _MP.inf)
    return x ** int(y) if y == int(y) else _MP.nan


def _larger(x: Any, y: Any) -> Any:
    return x if x >= y or x != x else y


def _smaller(x: Any, y: Any) -> Any:
    return x if x <= y or x != x else y


def _erfc(x: Any) -> Any:
    # Beyond it, the leading term decides whether the result is zero: exp(-x^2).
    return _MP.erfc(x) if abs(x) < 10**4 else (_MP.zero if x > 0 else _MP.mpf(2))


def _select(cases: Array, *options: Array) -> Array:
    chosen = options[0]
    for index, option in enumerate(options[1:], 1):
        chosen = np.where(cases.astype(int) == index, option, chosen)
    return np.asarray(chosen)


def _convert(params: Any, x: Array) -> Array:
    kind = np.dtype(params["new_dtype"]).kind
    if x.dtype != object:
        return _lift(x.astype(np.float64) if kind == "f" else x.astype(params["new_dtype"]))
    return x if kind == "f" else np.asarray(np.frompyfunc(int, 1, 1)(x)).astype(params["new_dtype"])


def _dot(params: Any, a: Array, b: Array) -> Array:
    (contract_a, contract_b), (batch_a, batch_b) = params["dimension_numbers"]
    axes_a, axes_b = list(range(a.ndim)), list(range(a.ndim, a.ndim + b.ndim))
    for i, j in (*zip(contract_a, contract_b, strict=True), *zip(batch_a, batch_b, strict=True)):
        axes_b[j] = axes_a[i]
    free_a = [axes_a[i] for i in range(a.ndim) if i not in (*contract_a, *batch_a)]
    free_b = [axes_b[j] for j in range(b.ndim) if j not in (*contract_b, *batch_b)]
    return np.asarray(np.einsum(a, axes_a, b, axes_b, [*(axes_a[i] for i in batch_a), *free_a, *free_b]), object)


_CALLS = {"jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "checkpoint", "remat"}
_MOVES = {
    *("broadcast_in_dim", "reshape", "squeeze", "expand_dims", "concatenate", "stack", "split", "tile", "transpose"),
    *("rev", "slice", "dynamic_slice", "dynamic_update_slice", "gather", "copy", "copy_p", "stop_gradient"),
}
_COMPARISONS: dict[str, Callable[..., Any]] = {
    name: np.frompyfunc(getattr(operator, name), 2, 1) for name in ("eq", "ne", "lt", "le", "gt", "ge")
} | {"is_finite": np.frompyfunc(_MP.isfinite, 1, 1)}
_REDUCTIONS: dict[str, Callable[..., Any]] = {
    "reduce_sum": np.add.reduce,
    "reduce_prod": np.multiply.reduce,
    "reduce_max": np.frompyfunc(_larger, 2, 1).reduce,
    "reduce_min": np.frompyfunc(_smaller, 2, 1).reduce,
}
_ELEMENTWISE: dict[str, Callable[..., Array]] = {
    name: _objects(function, 1)
    for name, function in {
        "neg": operator.neg,
        "abs": abs,
        "sign": _MP.sign,
        "floor": _MP.floor,
        "ceil": _MP.ceil,
        "square": lambda x: x * x,
        "sqrt": _nan_outside(_MP.sqrt, lambda x: x >= 0),
        "rsqrt": _nan_outside(lambda x: _divide(_MP.one, _MP.sqrt(x)), lambda x: x >= 0),
        "cbrt": lambda x: _MP.sign(x) * _MP.cbrt(abs(x)),
        "exp": _exp,
        "exp2": lambda x: _power(_MP.mpf(2), x),
        "expm1": lambda x: _MP.expm1(x) if abs(x) < 1 else _exp(x) - 1,
        "log": _log,
        "log1p": lambda x: _MP.log1p(x) if x > -1 else _log(1 + x),
        "logistic": lambda x: _divide(_MP.one, 1 + _exp(-x)),
        "sin": _MP.sin,
        "cos": _MP.cos,
        "tan": _MP.tan,
        "asin": _nan_outside(_MP.asin, lambda x: abs(x) <= 1),
        "acos": _nan_outside(_MP.acos, lambda x: abs(x) <= 1),
        "atan": _MP.atan,
        "sinh": _MP.sinh,
        "cosh": _MP.cosh,
        "tanh": _MP.tanh,
        "asinh": _MP.asinh,
        "erf": _MP.erf,
        "erfc": _erfc,
        "erf_inv": _nan_outside(_MP.erfinv, lambda x: abs(x) <= 1),
    }.items()
} | {
    name: _objects(function, 2)
    for name, function in {
        "add": operator.add,
        "add_any": operator.add,
        "sub": operator.sub,
        "mul": operator.mul,
        "div": _divide,
        "pow": _power,
        "atan2": _MP.atan2,
        "max": _larger,
        "min": _smaller,
    }.items()
}
_ELEMENTWISE["clamp"] = _objects(lambda low, x, high: _smaller(_larger(x, low), high), 3)
_ELEMENTWISE["select_n"] = _select
_WITH_PARAMS: dict[str, Callable[..., Array]] = {
    "convert_element_type": _convert,
    "dot_general": _dot,
    "integer_pow": lambda params, x: _objects(functools.partial(_integer_power, params["y"]), 1)(x),
}


def _integer_power(exponent: int, x: Any) -> Any:
    return x**exponent if exponent >= 0 else _divide(_MP.one, x**-exponent)
