"""A function traced by JAX, as NumPy code would compute it: operation by operation on whole arrays.

The jaxpr is the model's own, so that both compute the same formula. NumPy gets what a careful author would give it:
nothing unused is computed, nothing twice, powers are products, broadcasts and slices are views, the channels of colours
are apart in memory, and every array is dropped after its last use.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
import scipy.special
from jax.extend import core
from jax.interpreters import partial_eval

# An array, or the plain number that NumPy makes of one without axes.
Array = Any


class NumpyProgram:
    """A function of arrays, compiled to a list of NumPy calls.

    **Arguments:**

    - `function`: what JAX can trace, from arrays to a tree of arrays.
    - `arguments`: trees of arrays of the shapes and types that it will be called with.

    **Raises:** `NotImplementedError`, naming it, for an operation that has no NumPy version here.
    """

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        traced = jax.make_jaxpr(function)(*arguments)
        jaxpr, _ = partial_eval.dce_jaxpr(traced.jaxpr, [True] * len(traced.jaxpr.outvars), instantiate=True)
        self._registers: list[Array | None] = []
        self._steps: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []
        self._known: dict[Any, int] = {}
        self._inputs = [self._register() for _ in jaxpr.invars]
        consts = [self._constant(value) for value in traced.consts]
        self._outputs = self._inline(jaxpr, consts, self._inputs)
        last = {place: step for step, (_, inputs, _) in enumerate(self._steps) for place in inputs}
        kept = {*self._outputs, *(i for i, value in enumerate(self._registers) if value is not None)}
        self._dropped: list[list[int]] = [[] for _ in self._steps]
        for place, step in last.items():
            if place not in kept:
                self._dropped[step].append(place)

    @property
    def size(self) -> int:
        """The number of operations."""
        return len(self._steps)

    def __call__(self, *arguments: Any) -> list[Array]:
        """The leaves of the function's value."""
        registers = list(self._registers)
        for place, leaf in zip(self._inputs, jax.tree.leaves(arguments), strict=True):
            registers[place] = leaf
        with np.errstate(all="ignore"):
            for (apply, inputs, output), dropped in zip(self._steps, self._dropped, strict=True):
                registers[output] = apply(*[registers[place] for place in inputs])
                for place in dropped:
                    registers[place] = None
        return [np.asarray(registers[place]) for place in self._outputs]

    def _register(self, value: Array | None = None) -> int:
        self._registers.append(value)
        return len(self._registers) - 1

    def _constant(self, value: Any) -> int:
        array = np.asarray(value)
        key = (array.dtype, array.shape, array.tobytes())
        if key not in self._known:
            self._known[key] = self._register(array)
        return self._known[key]

    def _inline(self, jaxpr: Any, consts: list[int], inputs: list[int]) -> list[int]:
        """Appends the steps of a jaxpr, those of its calls in place."""
        places: dict[Any, int] = dict(zip([*jaxpr.constvars, *jaxpr.invars], [*consts, *inputs], strict=True))

        def read(atom: Any) -> int:
            if not isinstance(atom, core.Literal):
                return places[atom]
            # A literal without a type of its own has that of its place.
            place: Any = atom.aval
            return self._constant(np.asarray(atom.val, place.dtype))

        for equation in jaxpr.eqns:
            arguments = [read(atom) for atom in equation.invars]
            inner = next((equation.params[key] for key in _INNER if key in equation.params), None)
            if inner is None:
                found = [self._step(equation, tuple(arguments))]
            elif hasattr(inner, "consts"):
                found = self._inline(inner.jaxpr, [self._constant(value) for value in inner.consts], arguments)
            else:
                found = self._inline(inner, [], arguments)
            places.update(zip(equation.outvars, found, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def _step(self, equation: Any, inputs: tuple[int, ...]) -> int:
        name, params = equation.primitive.name, equation.params
        if name in _SAME:
            return inputs[0]
        key = (name, str(params), inputs)
        if key not in self._known:
            apply = _OPERATIONS.get(name)
            if apply is None and name in _WITH_PARAMS:
                apply = functools.partial(_WITH_PARAMS[name], params)
            if apply is None:
                raise NotImplementedError(
                    f"`{name}` has no NumPy version. Add it to fitter/bench/numpy_program.py, beside its likes."
                )
            self._known[key] = self._register()
            self._steps.append((apply, inputs, self._known[key]))
        return self._known[key]


def _integer_power(params: Any, x: Array) -> Array:
    exponent = abs(params["y"])
    power = None
    while exponent:
        if exponent & 1:
            power = x if power is None else power * x
        exponent >>= 1
        x = x * x if exponent else x
    power = np.ones_like(x) if power is None else power
    return power if params["y"] >= 0 else 1 / power


def _broadcast(params: Any, x: Array) -> Array:
    shape = [1] * len(params["shape"])
    for axis, size in zip(params["broadcast_dimensions"], np.shape(x), strict=True):
        shape[axis] = size
    return np.broadcast_to(np.reshape(x, shape), params["shape"])


def _slice(params: Any, x: Array) -> Array:
    strides = params["strides"] or (1,) * np.ndim(x)
    return x[tuple(map(slice, params["start_indices"], params["limit_indices"], strides))]


def _dot(params: Any, a: Array, b: Array) -> Array:
    (contract_a, contract_b), (batch_a, batch_b) = params["dimension_numbers"]
    axes_a, axes_b = list(range(a.ndim)), list(range(a.ndim, a.ndim + b.ndim))
    for i, j in (*zip(contract_a, contract_b, strict=True), *zip(batch_a, batch_b, strict=True)):
        axes_b[j] = axes_a[i]
    free_a = [axes_a[i] for i in range(a.ndim) if i not in (*contract_a, *batch_a)]
    free_b = [axes_b[j] for j in range(b.ndim) if j not in (*contract_b, *batch_b)]
    return np.einsum(a, axes_a, b, axes_b, [*(axes_a[i] for i in batch_a), *free_a, *free_b])


_INNER = ("jaxpr", "call_jaxpr", "fun_jaxpr")
_SAME = {"stop_gradient", "copy", "copy_p"}
_UFUNCS: dict[str, np.ufunc] = {
    **{name: getattr(np, name) for name in ("abs", "sign", "square", "sqrt", "cbrt", "exp", "exp2", "expm1", "log")},
    **{name: getattr(np, name) for name in ("log1p", "sin", "cos", "tan", "tanh", "sinh", "cosh", "floor", "ceil")},
    "add": np.add,
    "add_any": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "pow": np.power,
    "atan2": np.arctan2,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "erf": scipy.special.erf,
    "erfc": scipy.special.erfc,
    "logistic": scipy.special.expit,
    "max": np.maximum,
    "min": np.minimum,
    "eq": np.equal,
    "ne": np.not_equal,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "is_finite": np.isfinite,
}
# With the points along the fast axis: NumPy would otherwise loop over three channels at a time.
_OPERATIONS: dict[str, Callable[..., Any]] = {
    name: functools.partial(ufunc, order="F") for name, ufunc in _UFUNCS.items()
} | {
    "rsqrt": lambda x: 1 / np.sqrt(x),
    "clamp": lambda low, x, high: np.minimum(np.maximum(x, low), high),
    "select_n": lambda which, *cases: (
        np.where(which, cases[1], cases[0]) if len(cases) == 2 else np.choose(which, cases)
    ),
}
_WITH_PARAMS: dict[str, Callable[..., Any]] = {
    "integer_pow": _integer_power,
    "broadcast_in_dim": _broadcast,
    "slice": _slice,
    "dot_general": _dot,
    "convert_element_type": lambda params, x: np.asarray(x).astype(params["new_dtype"], copy=False),
    "reshape": lambda params, x: np.reshape(x, params["new_sizes"]),
    "squeeze": lambda params, x: np.squeeze(x, tuple(params["dimensions"])),
    "expand_dims": lambda params, x: np.expand_dims(x, tuple(params["dimensions"])),
    "transpose": lambda params, x: np.transpose(x, params["permutation"]),
    "rev": lambda params, x: np.flip(x, params["dimensions"]),
    "concatenate": lambda params, *xs: np.concatenate(xs, params["dimension"]),
    "stack": lambda params, *xs: np.stack(xs, params["axis"]),
    "reduce_sum": lambda params, x: np.sum(x, tuple(params["axes"])),
    "reduce_prod": lambda params, x: np.prod(x, tuple(params["axes"])),
    "reduce_max": lambda params, x: np.max(x, tuple(params["axes"])),
    "reduce_min": lambda params, x: np.min(x, tuple(params["axes"])),
}
