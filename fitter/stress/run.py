"""The stress test of one model: the sweep and the errors against 50 digits, in every arithmetic."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator

import numpy as np

from brdf.model import AbstractBRDF
from brdf.registry import expression_of

from .accuracy import Errors, sample, values_glsl, values_jax
from .evaluation import Evaluate
from .points import structures
from .sweep import Counts, sweep_glsl, sweep_jax

JAX_32, JAX_64, GLSL = "JAX float32", "JAX float64", "GLSL float32"
# Shares of the points: GLSL has no gradient, and is slow where a processor plays the GPU.
_SHARES = {JAX_32: 0.4, JAX_64: 0.4, GLSL: 0.2}
_SAY_EVERY_SECONDS = 2.0


@dataclasses.dataclass(frozen=True)
class Stressed:
    """What the stress test of one model found.

    - `name`: the model's expression.
    - `structures`: the combinations of static choices that were tried.
    - `counts`, `errors`: one for each arithmetic.
    """

    name: str
    structures: list[AbstractBRDF]
    counts: list[Counts]
    errors: list[Errors]
    seconds: float

    @property
    def points(self) -> int:
        """Evaluations of a pair of directions with a set of parameters, over all arithmetics."""
        return sum(counts.points for counts in self.counts)

    @property
    def faults(self) -> int:
        """How often something occurred that never may."""
        return sum(sum(counts.faults.values()) for counts in self.counts)

    @property
    def passed(self) -> bool:
        """No fault, and no error above its bar."""
        return not self.faults and not any(errors.not_finite or errors.worst_ratio > 1 for errors in self.errors)


def stress(
    model: AbstractBRDF,
    points: int,
    exact_points: int,
    seed: int = 0,
    evaluate: Evaluate | None = None,
    say: Callable[[str], None] = lambda sentence: None,
    most_structures: int | None = None,
) -> Stressed:
    """Tries a model where formulas break.

    **Arguments:**

    - `model`: any model or sum; its own parameters and choices do not matter.
    - `points`: at least so many evaluations are counted, over JAX float32, JAX float64 and GLSL float32.
    - `exact_points`: about so many evaluations are compared with 50 digits, in each arithmetic; 0 for none.
    - `seed`: the same seed tries the same points.
    - `evaluate`: the GLSL evaluation, `shaders.evaluate`; left out, GLSL is not tried.
    - `say`: takes a sentence about the progress, now and then.
    - `most_structures`: stops after so many combinations of choices, for a short run that does not compile them all.

    **Returns:** counts of faults with the first offenders, and errors.
    """
    start, name = time.monotonic(), expression_of(model)
    # Every model and seed has its own points, whichever models are tried with it.
    rng = np.random.default_rng([seed, *name.encode()])
    tried = structures(model, rng)[:most_structures]
    shares = _SHARES if evaluate else {key: share for key, share in _SHARES.items() if key != GLSL}
    counts = {key: Counts(key) for key in shares}
    errors = {key: Errors(key, key.split()[1]) for key in shares}
    said = start
    for number, structure in enumerate(tried, 1):
        for key, share in shares.items():
            count = -(-int(np.ceil(points * share / sum(shares.values()))) // len(tried))
            steps: Iterator[None]
            if key == GLSL:
                assert evaluate is not None
                steps = sweep_glsl(structure, rng, count, counts[key], evaluate)
            else:
                steps = sweep_jax(structure, rng, count, counts[key], key.split()[1])
            for _ in steps:
                if time.monotonic() > said + _SAY_EVERY_SECONDS:
                    said = time.monotonic()
                    total = sum(one.points for one in counts.values())
                    say(f"{name}: {total / 1e6:.1f} of {points / 1e6:g} million points, choice {number}/{len(tried)}")
        if exact_points:
            say(f"{name}: 50 digits, choice {number}/{len(tried)}")
            _compare(structure, rng, -(-exact_points // len(tried)), errors, evaluate)
    return Stressed(name, tried, list(counts.values()), list(errors.values()), time.monotonic() - start)


def _compare(
    model: AbstractBRDF, rng: np.random.Generator, count: int, errors: dict[str, Errors], evaluate: Evaluate | None
) -> None:
    """Adds the errors of one structure; JAX and GLSL in float32 are compared at the same points."""
    single, double = (sample(model, rng, count, precision) for precision in ("float32", "float64"))
    errors[JAX_32].add(single, values_jax(single))
    errors[JAX_64].add(double, values_jax(double))
    if evaluate:
        errors[GLSL].add(single, values_glsl(single, evaluate))
