"""Error bars where the model misses the data: a bootstrap over incident angles.

Neighbouring samples then err together, and standard errors that take them as independent are far too small. The samples
are cut into blocks of neighbouring incident angles, whole blocks are drawn again with replacement, and each draw's
solution follows from the blocks' own normal equations by one Newton step from the common solution.

- Kuensch 1989, "The Jackknife and the Bootstrap for General Stationary Observations" (blocks).
- Davidson, MacKinnon 1999, "Bootstrap Testing in Nonlinear Models" (one step instead of a fit).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float

from .identify import Certainty
from .minimise import Problem
from .reflectance import Reflectance
from .samples import CHUNK, CHUNKS, Slab, arrange_blocks

# Enough blocks for percentiles, few enough that neighbours in different ones err independently.
BLOCKS = 32
_DRAWS = 2000
_SEED = 19890101
# Angles that all lie closer together than this, in degrees, are one.
_SPREAD_DEG = 5.0
# The variance of the solution over that of independent samples from which on the misfit, not noise, decides.
_INFLATED = 3.0
# Below this the blocks show no misfit: with independent samples their number lets the ratio scatter by a quarter.
_SEEN = 1.75
# Smallest eigenvalue of the scaled Hessian from which on a Newton step with all its curvature is safe.
_STEEP = 1e-3


@dataclasses.dataclass(frozen=True)
class Blocks:
    """What each block of samples tells about a solution.

    - `gradients`: shape (b, k), of the cost.
    - `hessians`: shape (b, k, k).
    """

    gradients: Float[np.ndarray, "b k"]
    hessians: Float[np.ndarray, "b k k"]


def assess_blocks(problem: Problem, y: Float[np.ndarray, " k"], data: Reflectance, weight: np.ndarray) -> Blocks:
    """The normal equations at `y` of each block of incident angles, from the samples of the subset.

    Where all samples have one incident angle, outgoing angles take its place.
    """
    rows = problem.arranged.rows
    angles = [np.degrees(np.arccos(np.clip(w[rows, 2], -1, 1))) for w in (data.wi, data.wo)]
    angle = angles[0] if np.ptp(angles[0]) > _SPREAD_DEG else angles[1]
    parts = np.array_split(rows[np.argsort(angle, kind="stable")], min(BLOCKS, len(rows)))
    per_block = CHUNKS // BLOCKS
    slab = arrange_blocks(data, weight, parts, per_block, problem.arranged.subset.samples.scale)
    found = [
        problem.assess(y, Slab(slab, CHUNKS), place * per_block, -(-len(part) // CHUNK)).equations
        for place, part in enumerate(parts)
    ]
    return Blocks(np.stack([one.gradient for one in found]), np.stack([one.hessian for one in found]))


def inflation(blocks: Blocks, scores: Float[np.ndarray, "k k"], free: np.ndarray) -> float:
    """How much more the solution scatters by blocks than by independent samples: the ratio of the variances, its mean
    over the free elements.

    With independent samples the sum over blocks of the outer product of their gradients has the mean of `scores`.
    """
    gradients = blocks.gradients[:, free] - blocks.gradients[:, free].mean(axis=0)
    place = np.ix_(free, free)
    hessian = blocks.hessians.sum(axis=0)[place]
    root = np.sqrt(np.maximum(np.diagonal(hessian), np.finfo(float).tiny))
    scale = np.outer(root, root)
    # Directions in the space of the solution: what hardly moves it must not count, however it scatters by itself.
    inverse = np.linalg.pinv(hessian / scale, rcond=1e-10, hermitian=True)
    by_blocks, by_samples = (
        np.diagonal(inverse @ (part / scale) @ inverse) for part in (gradients.T @ gradients, scores[place])
    )
    return float(np.mean(by_blocks / np.maximum(by_samples, np.finfo(float).tiny)))


def _usable(curvature: Float[np.ndarray, "k k"] | None, blocks: Blocks, free: np.ndarray) -> np.ndarray | float:
    """The curvature beside the Hessian, or nothing where their sum has no minimum."""
    if curvature is None:
        return 0.0
    bent = curvature[np.ix_(free, free)]
    total = blocks.hessians[:, free][:, :, free].sum(axis=0) + bent
    diagonal = np.diagonal(total)
    if (diagonal <= 0).any():
        return 0.0
    scaled = total / np.sqrt(np.outer(diagonal, diagonal))
    return bent if np.linalg.eigvalsh(scaled)[0] > _STEEP else 0.0


def bootstrapped(
    problem: Problem,
    y: Float[np.ndarray, " k"],
    sure: Certainty,
    scores: Float[np.ndarray, "k k"],
    curvature: Float[np.ndarray, "k k"] | None,
    data: Reflectance,
    weight: np.ndarray,
) -> Certainty:
    """The certainty with standard errors and 95 % intervals of the bootstrap, if misfit decides about them.

    **Arguments:**

    - `y`, `sure`: the solution and what is known of it.
    - `scores`: of the subset, see `fitter.normal`.
    - `curvature`: of the subset: what its Hessian leaves out, if known.
    - `data`, `weight`: all samples.
    """
    free = np.flatnonzero(np.isfinite(sure.standard_errors))
    if free.size == 0 or len(problem.arranged.rows) < 2 * BLOCKS:
        return sure
    blocks = assess_blocks(problem, y, data, weight)
    seen = inflation(blocks, scores, free)
    # The subset's own noise hides the misfit that remains when all samples have averaged theirs away.
    inflated = 1 + (seen - 1) / problem.arranged.share
    if not (seen > _SEEN and inflated > _INFLATED):
        return sure
    bent = _usable(curvature, blocks, free)
    gradients, hessians = blocks.gradients[:, free], blocks.hessians[:, free][:, :, free]
    # The common gradient is zero up to the last step's tolerance.
    gradients = gradients - gradients.mean(axis=0)
    count = len(gradients)
    drawn = np.random.default_rng(_SEED).multinomial(count, np.full(count, 1 / count), _DRAWS).astype(float)
    hessian = np.einsum("db,bij->dij", drawn, hessians) + bent
    diagonal = np.einsum("dii->di", hessian)
    root = np.sqrt(np.maximum(diagonal, 1e-9 * np.abs(diagonal).max(axis=0)))
    scaled = hessian / root[:, :, None] / root[:, None, :] + 1e-9 * np.eye(free.size)
    steps = -np.linalg.solve(scaled, ((drawn @ gradients) / root)[..., None])[..., 0] / root
    points = np.tile(y, (_DRAWS, 1))
    points[:, free] = np.clip(y[free] + steps, problem.lower[free], problem.upper[free])
    values = problem.unknowns.values(points)[:, free]
    errors, intervals = sure.standard_errors.copy(), sure.intervals.copy()
    errors[free] = values.std(axis=0)
    intervals[free] = np.percentile(values, [2.5, 97.5], axis=0).T
    return dataclasses.replace(sure, standard_errors=errors, intervals=intervals, inflation=inflated)
