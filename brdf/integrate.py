"""Integrals of models over the hemisphere in float64, by `quadrature`: albedos, and the picture of a lit sphere."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence

import jax
import numpy as np
from jaxtyping import Float

from .model import AbstractBRDF, Batch, evaluate
from .quadrature import half_vector_rule, unit_nodes

# A light from afar that is symmetric about an axis: towards its middle, and its radiance by the cosine to there.
Light = tuple[tuple[float, float, float], Callable[[np.ndarray], np.ndarray]]

# Pairs of directions per call of the compiled model: one shape means one compiled program, whatever is integrated. The
# arrays of one call stay inside the processor's cache.
_PAIRS_AT_ONCE = 1 << 14


def albedo(model: AbstractBRDF, theta: float, nodes: int = 128) -> Float[np.ndarray, "3"]:
    """The fraction of light from all around that is reflected towards one direction.

    By reciprocity it is also the fraction of light from that direction that is reflected at all. Use it for models
    without a sharp highlight: the nodes resolve slopes down to about 0.1.

    **Arguments:**

    - `model`: any model or sum.
    - `theta`: polar angle of the direction in radians, in [0, pi/2).
    - `nodes`: of the Gauss-Legendre rule over the cosine, and twice as many around.

    **Returns:** shape (3,), linear Rec. 709.
    """
    wi, weight = _hemisphere(nodes)
    wo = np.broadcast_to([np.sin(theta), 0.0, np.cos(theta)], wi.shape)
    with jax.enable_x64(True):
        value = np.asarray(evaluate(model, wi, wo))
    return (value * (wi[:, 2] * weight)[:, None]).sum(axis=0)


@functools.cache
def _hemisphere(nodes: int) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
    """Directions and weights in sr, which add up to 2 pi."""
    cosine, weights = unit_nodes(nodes)
    phi = (np.arange(2 * nodes) + 0.5) * (np.pi / nodes)
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    across = [np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cosine, np.ones_like(phi))]
    return np.stack(across, axis=-1).reshape(-1, 3), np.repeat(weights, 2 * nodes) * (np.pi / nodes)


def evaluate_in_chunks(
    model: AbstractBRDF,
    wi: Float[np.ndarray, "n 3"],
    wo: Float[np.ndarray, "n 3"],
    program: Callable[[AbstractBRDF, np.ndarray, np.ndarray], Batch] = evaluate,
) -> Float[np.ndarray, "n 3"]:
    """The values of a model at any number of pairs by one compiled program of a fixed shape, in float64.

    Use it where the number of pairs varies: `evaluate` compiles a program, for seconds, for every number that it meets.

    **Arguments:** `wi`, `wo`: unit, to the light and to the viewer; `program`: what evaluates one chunk. **Returns:**
    1/sr, without the cosine.
    """
    value = np.empty(wi.shape)
    with jax.enable_x64(True):
        for start in range(0, len(wi), _PAIRS_AT_ONCE):
            rows = slice(start, start + _PAIRS_AT_ONCE)
            count = len(wi[rows])
            # The rest of the last chunk looks along the normal.
            pair = np.tile([0.0, 0.0, 1.0], (2, _PAIRS_AT_ONCE, 1))
            pair[0, :count], pair[1, :count] = wi[rows], wo[rows]
            value[rows] = np.asarray(program(model, pair[0], pair[1]))[:count]
    return value


def albedos(
    model: AbstractBRDF, theta: Float[np.ndarray, " n"], phi: Float[np.ndarray, " n"], polar: int = 48, around: int = 64
) -> Float[np.ndarray, "n 3"]:
    """The fraction of light from each of n directions that is reflected at all, down to slopes of 1e-4.

    **Arguments:**

    - `theta`, `phi`: of the directions, radians, `theta` in [0, pi/2).
    - `polar`, `around`: nodes of `half_vector_rule`.

    **Returns:** linear Rec. 709.
    """
    rules = [half_vector_rule(float(angle), polar, around) for angle in theta]
    wo = np.concatenate([_turned(w, angle) for (w, _), angle in zip(rules, phi, strict=True)])
    one = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    value = evaluate_in_chunks(model, np.repeat(one, polar * around, axis=0), wo)
    value = value * (wo[:, 2] * np.concatenate([weight for _, weight in rules]))[:, None]
    return value.reshape(len(theta), -1, 3).sum(axis=1)


@dataclasses.dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere that is seen from afar under a fixed light: which values of a BRDF it needs, and what it looks like.

    Its pixels lie on rings about the centre, in sectors, all of the same area. Every pixel of a ring sees the same
    pairs of directions, so that the number of values is that of the rings, not of the pixels. An anisotropic material
    is brushed along a spiral: from the centre to the rim the viewer's azimuth goes once around, linear in radius
    squared.

    **Arguments:**

    - `wi`, `wo`: (n, 3), the pairs of directions of all rings, in the local frame.
    - `cosine`: (n,), cos_i times the solid angle of each, in sr.
    - `light`: (rings, sectors, n / rings), the radiance of the light from the pairs' `wi` at each pixel.
    - `radius`: (rings,), of the pixels' centres, in units of the sphere's radius.
    - `azimuth`: (sectors,), of the pixels' centres, radians counter-clockwise from the right.
    """

    wi: np.ndarray
    wo: np.ndarray
    cosine: np.ndarray
    light: np.ndarray
    radius: np.ndarray
    azimuth: np.ndarray

    def picture(self, value: Float[np.ndarray, "n channels"]) -> Float[np.ndarray, "rings sectors channels"]:
        """The radiance of every pixel, from the values of a BRDF in 1/sr at `wi` and `wo`."""
        reflected = (value * self.cosine[:, None]).astype(np.float32)
        return (self.light @ reflected.reshape(len(self.light), -1, value.shape[1])).astype(np.float64)


def sphere(
    lights: Sequence[Light],
    theta_max: float,
    rings: int = 32,
    sectors: int = 64,
    polar: int = 32,
    around: int = 48,
) -> Sphere:
    """A sphere under a light; see `Sphere`.

    **Arguments:**

    - `lights`: each an axis (unit: x to the right, y up, z to the viewer) and its radiance as a function of the cosine
      of the angle to the axis, from and to float32 arrays; the argument may be overwritten. What varies within less
      than 5 degrees needs more nodes than by default.
    - `theta_max`: light and viewer beyond this polar angle are left out, radians, in (0, pi/2].
    - `rings`, `sectors`: of the pixels.
    - `polar`, `around`: nodes of `half_vector_rule`.
    """
    area = (np.arange(rings) + 0.5) / rings
    radius = np.sin(theta_max) * np.sqrt(area)
    azimuth = (np.arange(sectors) + 0.5) * (2 * np.pi / sectors)
    wi, wo, cosine, light = [], [], [], []
    for ring in range(rings):
        sine = radius[ring]
        cos_o = np.sqrt(1 - sine * sine)
        w, weight = half_vector_rule(float(np.arcsin(sine)), polar, around, np.cos(theta_max))
        # The local frame at azimuth 0, seen from outside: its x axis leans to the viewer, its z axis is the normal.
        frame = np.array([[-cos_o, 0, sine], [0, -1, 0], [sine, 0, cos_o]])
        light.append(_all_around(lights, w @ frame, azimuth))
        spiral = 2 * np.pi * area[ring]
        wi.append(_turned(w, spiral))
        wo.append(np.broadcast_to(_turned(np.array([[sine, 0.0, cos_o]]), spiral), w.shape))
        cosine.append(w[:, 2] * weight)
    return Sphere(np.concatenate(wi), np.concatenate(wo), np.concatenate(cosine), np.stack(light), radius, azimuth)


def _all_around(lights: Sequence[Light], w: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """The light from each direction in turn at every azimuth of the pixel, (azimuths, directions)."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    columns = np.ascontiguousarray(w.T, np.float32)
    total = np.zeros((len(azimuth), len(w)), np.float32)
    for (x, y, z), radiance in lights:
        # The axis turned back, instead of all directions turned.
        axes = np.stack([c * x + s * y, c * y - s * x, np.full_like(c, z)], axis=-1).astype(np.float32)
        total += radiance(axes @ columns)
    return total


def _turned(w: np.ndarray, angle: float) -> np.ndarray:
    """Directions turned about the normal by an angle in radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], axis=-1)
