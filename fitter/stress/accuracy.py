"""The relative error of a model against 50 digits, and how much of it the mathematics itself explains.

The condition number of the value f in all its inputs x (parameters and components of the directions) is

    kappa = sum_i |x_i df/dx_i| / |f|.

One rounding of the inputs changes f by about `eps kappa`; an algorithm without extra precision errs by a few times as
much. Where the mathematics cancels (the tail of a Gaussian, a large exponent, a difference that is cut at zero, the
half vector of opposite directions) kappa is large. The bar is `BAR` where kappa is at most `KAPPA`, and grows in
proportion to kappa beyond. It forgives more than necessary: nearly mirrored directions have a large kappa though their
half vector is exact, and compensated arithmetic undercuts `eps kappa`. The raw errors show both.

- Higham 2002, "Accuracy and Stability of Numerical Algorithms", chapter 1.
"""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from brdf.model import AbstractBRDF

from . import points
from .evaluation import Array, Evaluate, values_and_gradients, with_leaves
from .exact import digits, exact, number

# Largest relative error in float32 where the condition number is at most KAPPA; in float64 it is as many eps.
BAR = 1e-5
KAPPA = 10.0
# Below it an intermediate result may have underflowed: float32 ends at 1.2e-38, float64 at 2.2e-308.
SMALLEST = {"float32": 1e-30, "float64": 1e-290}
# Pairs of directions per set of parameters: GLSL takes the parameters as uniforms.
PAIRS = 32


@dataclasses.dataclass(frozen=True)
class Sample:
    """Points of one structure of a model with their exact values.

    - `model`: its structure.
    - `leaves`: one value per set of parameters; `PAIRS` rows of `wi` and `wo` belong to each set.
    - `truth`: (n, 3), mpmath numbers.
    - `kappa`: (n, 3), the condition number of every channel.
    """

    model: AbstractBRDF
    leaves: list[Array]
    wi: Array
    wo: Array
    truth: Array
    kappa: Array

    def at(self, index: int) -> AbstractBRDF:
        """The model with the parameters of one point."""
        return with_leaves(self.model, [leaf[index // PAIRS, ...] for leaf in self.leaves])


def sample(model: AbstractBRDF, rng: np.random.Generator, count: int, precision: str) -> Sample:
    """At least `count` points of one structure with inputs that `precision` holds exactly, evaluated to 50 digits."""
    sets = -(-count // PAIRS)
    leaves = points.parameter_sets(model, rng, sets, precision)
    # A product with the smallest number of all underflows, which is no rounding: that is for the sweep.
    limits = np.finfo(precision)
    leaves = [np.where(leaf == limits.tiny, limits.eps, leaf) for leaf in leaves]
    width = points.widths(model, leaves, rng, sets)
    wi, wo = points.directions(np.repeat(width, PAIRS), rng, precision)
    inputs = [np.repeat(leaf, PAIRS, axis=0).astype(np.float64) for leaf in leaves]
    inputs += [wi.astype(np.float64), wo.astype(np.float64)]
    truth = exact(jax.vmap(lambda *x: with_leaves(model, list(x[:-2]))(x[-2], x[-1])), *inputs)
    return Sample(model, leaves, wi, wo, truth, np.stack([_condition(model, inputs, truth, c) for c in range(3)], -1))


def _condition(model: AbstractBRDF, inputs: list[Array], truth: Array, channel: int) -> Array:
    """kappa of one channel from float64 derivatives, (n,)."""
    weights = tuple(float(c == channel) for c in range(3))
    _, gradient, _ = values_and_gradients(model, inputs[:-2], inputs[-2], inputs[-1], weights)
    columns = np.concatenate([x.reshape(len(x), -1) for x in inputs], axis=1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return np.abs(gradient * columns).sum(axis=1) / np.abs(truth[:, channel].astype(np.float64))


def values_jax(points_: Sample) -> Array:
    """The values of a sample in JAX, in the precision of its directions."""
    leaves = [np.repeat(leaf, PAIRS, axis=0) for leaf in points_.leaves]
    return values_and_gradients(points_.model, leaves, points_.wi, points_.wo)[0]


def values_glsl(points_: Sample, evaluate: Evaluate) -> Array:
    """The values of a float32 sample in GLSL."""
    starts = range(0, len(points_.wi), PAIRS)
    return np.concatenate(
        [evaluate(points_.at(s), points_.wi[s : s + PAIRS], points_.wo[s : s + PAIRS]) for s in starts]
    )


@dataclasses.dataclass(frozen=True)
class Worst:
    """The point whose error is the largest in units of its bar."""

    model: AbstractBRDF
    wi: Array
    wo: Array
    value: Array
    exact: list[str]
    error: float
    kappa: float


@dataclasses.dataclass
class Errors:
    """Relative errors in one arithmetic, channel by channel, collected over the structures of a model.

    - `left_out`: values too small to count, of which most are zero: light below the horizon, tails.
    - `not_finite`: values without an error, because they are NaN or Inf.
    """

    arithmetic: str
    precision: str
    left_out: int = 0
    not_finite: int = 0
    errors: list[Array] = dataclasses.field(default_factory=list)
    kappas: list[Array] = dataclasses.field(default_factory=list)
    worst: Worst | None = None
    worst_ratio: float = 0.0

    def add(self, points_: Sample, value: Array) -> None:
        """Compares the values of a sample with its exact ones."""
        counted = points_.truth > SMALLEST[self.precision]
        self.left_out += int((~counted).sum())
        pairs = zip(value[counted], points_.truth[counted], strict=True)
        found = np.array([float(abs((number(v) - t) / t)) if np.isfinite(v) else np.nan for v, t in pairs])
        self.not_finite += int(np.isnan(found).sum())
        kappa = points_.kappa[counted]
        self.errors.append(found)
        self.kappas.append(kappa)
        ratio = found / self._bar(kappa)
        if not np.isfinite(ratio).any():
            return
        place = int(np.nanargmax(ratio))
        if ratio[place] > self.worst_ratio:
            self.worst_ratio = float(ratio[place])
            row = int(np.argwhere(counted)[place][0])
            exact_ = [digits(x) for x in points_.truth[row]]
            at = (points_.at(row), points_.wi[row], points_.wo[row], value[row], exact_)
            self.worst = Worst(*at, float(found[place]), float(kappa[place]))

    @property
    def eps(self) -> float:
        return float(np.finfo(self.precision).eps)

    def _bar(self, kappa: Array) -> Array:
        return BAR * self.eps / np.finfo(np.float32).eps * np.maximum(1, kappa / KAPPA)

    def figures(self) -> dict[str, float]:
        """The figures of the report.

        `max`, `p99.9`, `median`: of the raw relative error. `max_conditioned`: its maximum where kappa is at most
        `KAPPA`. `max_units`: the largest error in units of `eps max(1, kappa)`. `of_bar`: the largest error as a share
        of its bar. `values`, `left_out`, `not_finite`: how many were counted, and how many not.
        """
        errors, kappas = (np.concatenate(part) if part else np.zeros(0) for part in (self.errors, self.kappas))
        known = np.isfinite(errors)
        errors, kappas = errors[known], kappas[known]
        if not errors.size:
            return {"values": 0, "left_out": self.left_out, "not_finite": self.not_finite}
        tame = errors[kappas <= KAPPA]
        return {
            "max": float(errors.max()),
            "p99.9": float(np.quantile(errors, 0.999)),
            "median": float(np.median(errors)),
            "max_conditioned": float(tame.max()) if tame.size else 0.0,
            "max_units": float(np.max(errors / (self.eps * np.maximum(1, kappas)))),
            "of_bar": self.worst_ratio,
            "values": int(errors.size),
            "left_out": self.left_out,
            "not_finite": self.not_finite,
        }
