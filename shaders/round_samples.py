"""A material's values for some viewers, and the non-negative least squares by which round lobes are fitted to them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from brdf.quadrature import half_vector_rule

Array = NDArray[np.float64]
Evaluate = Callable[[Array, Array], NDArray[np.float32]]

# By whether the material is brushed: the degree of amplitudes in cos_o, and the viewers' cosines and azimuths.
_DEGREE = {False: 6, True: 4}
_COSINES = {False: 10, True: 7}
_AZIMUTHS = {False: 1, True: 4}
# Nodes of the rule over half vectors.
_POLAR, _AROUND = 24, 32
# Directions below the horizon, from which nothing is reflected but a round kernel may take light.
_BELOW = (10, 20)
# Cells about the mirror direction, as large as they are far from it: an error is one of the light that a cell reflects.
# Within the first ring, in radians, no environment tells directions apart.
_RINGS = np.array([0.02, 0.035, 0.06, 0.1, 0.17, 0.28, 0.46, 0.75, 1.2])
_SECTORS = 8
_CELLS = (len(_RINGS) + 1) * _SECTORS
# An error counts relative to the light of its cell, above this part of a diffuse surface's: a highlight's tail is seen
# too.
_FLOOR = 0.01
# How much more an error of the directional albedo counts: it is what a furnace shows.
_ENERGY = 1e4
# The viewer from whom the wide direction is found, by its cosine.
_COS_ABOVE = 0.999
# Below it a material is black.
_ALBEDO_MIN = 1e-9


@dataclasses.dataclass(frozen=True, eq=False)
class Samples:
    """The weights f cos_i of a material for v viewers at k directions of light each, summed over c cells.

    - `wi`: shape (v, k, 3). `wo`: shape (v, 3).
    - `cell`: shape (v, k), of 0 to v c - 1: the viewer times c plus the cell that the direction belongs to.
    - `solid_angle`: shape (v, k), of each direction.
    - `value`: shape (v, c, 3), what each cell reflects over the viewer's mean albedo.
    - `albedo`: shape (v, 3), over the mean of its channels.
    - `importance`: shape (v, c), of the square of an error of `value`.
    - `area`: shape (v,), the part of a sphere's picture that is seen so.
    - `basis`: shape (v, b), of the amplitudes, over the viewer's mean albedo: Bernstein's polynomials in cos_o; of a
      brushed material times cos^2 and sin^2 of the azimuth from the wide direction.
    - `azimuth`: of the wide direction, radians.
    """

    wi: Array
    wo: Array
    cell: NDArray[np.intp]
    solid_angle: Array
    value: Array
    albedo: Array
    importance: Array
    area: Array
    basis: Array
    azimuth: float

    def in_cells(self, values: Array) -> Array:
        """Values at the directions of light, shape (v, k), integrated over each cell, shape (v, c)."""
        return _in_cells(self.cell, values * self.solid_angle)

    def amplitudes(self, columns: Array, value: Array, albedo: Array) -> Array:
        """The non-negative coefficients, shape (n, b), by which n kernels come nearest to one channel.

        **Arguments:** `columns`: shape (v, c, n), of the kernels; `value`: (v, c) and `albedo`: (v,), of the channel.
        """
        energy = _ENERGY * self.area
        weighted = columns * self.importance[..., None]
        gram = np.matmul(weighted.transpose(0, 2, 1), columns) + energy[:, None, None]
        target = np.einsum("vkn,vk->vn", weighted, value) + (energy * albedo)[:, None]
        size = columns.shape[2] * self.basis.shape[1]
        pairs = np.einsum("vb,vd->vbd", self.basis, self.basis).reshape(len(gram), -1)
        matrix = (pairs.T @ gram.reshape(len(gram), -1)).reshape(*2 * (self.basis.shape[1],), *2 * (columns.shape[2],))
        matrix = matrix.transpose(2, 0, 3, 1).reshape(size, size)
        right = np.einsum("vb,vn->nb", self.basis, target).reshape(size)
        return non_negative(matrix, right).reshape(columns.shape[2], -1)

    def mean_amplitudes(self, columns: Array) -> Array:
        """`amplitudes` for the mean of the channels."""
        return self.amplitudes(columns, self.value.mean(axis=2), self.albedo.mean(axis=1))

    def error(self, columns: Array, coefficients: Array) -> Array:
        """The weighted errors of such amplitudes, shape (v c,)."""
        amplitude = self.basis @ coefficients.T
        error = (columns @ amplitude[..., None])[..., 0] - self.value.mean(axis=2)
        return (error * np.sqrt(self.importance)).ravel()

    def cost(self, columns: Array) -> float:
        """The sum of their squares for the best amplitudes."""
        error = self.error(columns, self.mean_amplitudes(columns))
        return float(error @ error)


def sample_material(evaluate: Evaluate, is_anisotropic: bool) -> Samples:
    """The samples of a material.

    **Arguments:**

    - `evaluate`: from wi and wo, shapes (n, 3), to values in 1/sr without the cosine.
    - `is_anisotropic`: whether they depend on the azimuth.
    """
    u, weights = np.polynomial.legendre.leggauss(_COSINES[is_anisotropic])
    cosine, around = 0.5 * (1 + u), _AZIMUTHS[is_anisotropic]
    azimuth = _wide_direction(evaluate) if is_anisotropic else 0.0
    phi = (np.arange(around) + 0.5) * (0.5 * np.pi / around) if is_anisotropic else np.zeros(1)
    cos_o, turn = np.repeat(cosine, around), np.tile(phi, len(cosine))
    wi, wo, solid_angle = _pairs(cos_o, np.add(turn, azimuth, dtype=np.float64))
    value = evaluate(wi.reshape(-1, 3), np.repeat(wo, wi.shape[1], axis=0)).reshape(wi.shape).astype(np.float64)
    value = np.nan_to_num(value, posinf=0.0) * np.maximum(wi[..., 2:], 0)
    below, around_below = _below()
    wi = np.concatenate([wi, np.broadcast_to(below, (len(wo), *below.shape))], axis=1)
    solid_angle = np.concatenate([solid_angle, np.broadcast_to(around_below, (len(wo), len(below)))], axis=1)
    value = np.concatenate([value, np.zeros((len(wo), *below.shape))], axis=1)
    albedo = (value * solid_angle[..., None]).sum(axis=1)
    scale = np.maximum(albedo.mean(axis=1), _ALBEDO_MIN)
    value, albedo = value / scale[:, None, None], albedo / scale[:, None]
    area = np.repeat(weights * cosine, around)
    area /= area.sum()
    cell = _cells(wi, wo)
    reflected = np.stack([_in_cells(cell, value[..., c] * solid_angle) for c in range(3)], axis=-1)
    diffuse = _FLOOR / np.pi * _in_cells(cell, solid_angle)
    importance = area[:, None] / (reflected.mean(axis=2) + diffuse + 1e-12)
    degree = _DEGREE[is_anisotropic]
    basis = np.stack([math.comb(degree, b) * cos_o**b * (1 - cos_o) ** (degree - b) for b in range(degree + 1)], axis=1)
    if is_anisotropic:
        basis = np.concatenate([basis * (np.cos(turn) ** 2)[:, None], basis * (np.sin(turn) ** 2)[:, None]], axis=1)
    return Samples(wi, wo, cell, solid_angle, reflected, albedo, importance, area, basis / scale[:, None], azimuth)


def _pairs(cos_o: Array, phi: Array) -> tuple[Array, Array, Array]:
    """Directions of light, viewers, and solid angles."""
    wi, solid_angle = zip(*(half_vector_rule(math.acos(c), _POLAR, _AROUND) for c in cos_o), strict=True)
    sine = np.sqrt(1 - cos_o**2)
    c, s = np.cos(phi)[:, None], np.sin(phi)[:, None]
    x, y, z = np.moveaxis(np.stack(wi), -1, 0)
    turned = np.stack([c * x - s * y, s * x + c * y, z], axis=-1)
    return turned, np.stack([sine * c[:, 0], sine * s[:, 0], cos_o], axis=-1), np.stack(solid_angle)


def _below() -> tuple[Array, Array]:
    """Directions below the horizon, shape (n, 3), and their solid angles."""
    polar, around = _BELOW
    u, weights = np.polynomial.legendre.leggauss(polar)
    z, phi = np.repeat(-0.5 * (1 + u), around), np.tile((np.arange(around) + 0.5) * (2 * np.pi / around), polar)
    sine = np.sqrt(1 - z**2)
    w = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    return w, np.repeat(0.5 * weights, around) * (2 * np.pi / around)


def _cells(wi: Array, wo: Array) -> NDArray[np.intp]:
    """See `Samples.cell`."""
    mirrored = wo * [-1.0, -1.0, 1.0]
    distance = 2 * np.arcsin(np.minimum(0.5 * np.linalg.norm(wi - mirrored[:, None], axis=2), 1.0))
    # Seen along the mirror direction: across the plane of incidence, and in it.
    across = np.stack([-wo[:, 1], wo[:, 0], np.zeros(len(wo))], axis=1) / np.hypot(wo[:, 0], wo[:, 1])[:, None]
    within = np.cross(across, mirrored)
    turn = np.arctan2(np.einsum("vki,vi->vk", wi, across), np.einsum("vki,vi->vk", wi, within))
    sector = np.floor((turn / (2 * np.pi) + 0.5) * _SECTORS).astype(int) % _SECTORS
    return np.searchsorted(_RINGS, distance) * _SECTORS + sector + np.arange(len(wo))[:, None] * _CELLS


def _in_cells(cell: NDArray[np.intp], weights: Array) -> Array:
    """The sums of weights, shape (v, k), over each cell, shape (v, c)."""
    sums = np.bincount(cell.ravel(), weights.ravel(), len(cell) * _CELLS)
    return np.asarray(sums, np.float64).reshape(-1, _CELLS)


def _wide_direction(evaluate: Evaluate) -> float:
    """The azimuth along which the light that is reflected straight up comes from farthest, by its second moments."""
    wi, wo, solid_angle = _pairs(np.array([_COS_ABOVE]), np.zeros(1))
    value = evaluate(wi[0], np.repeat(wo, wi.shape[1], axis=0)).mean(axis=1) * wi[0, :, 2] * solid_angle[0]
    # Of the half vectors' slopes, so that the narrow part of the highlight counts.
    slope = (wi[0] + wo)[:, :2] / (wi[0] + wo)[:, 2:]
    xx, yy, xy = (float((value * a * b / (1 + (slope**2).sum(axis=1)) ** 2).sum()) for a, b in (
        (slope[:, 0], slope[:, 0]), (slope[:, 1], slope[:, 1]), (slope[:, 0], slope[:, 1])))  # fmt: skip
    return 0.5 * math.atan2(2 * xy, xx - yy)


def non_negative(matrix: Array, right: Array) -> Array:
    """The x >= 0 that minimises x' matrix x / 2 - right' x, for a symmetric matrix, positive semi-definite.

    By block principal pivoting (Portugal, Judice, Vicente 1994, "A comparison of block pivoting and interior-point
    algorithms for linear least squares problems with nonnegative variables").
    """
    size = len(right)
    matrix = matrix + 1e-10 * np.trace(matrix) / size * np.eye(size)
    free = right > 0
    x, gradient = np.zeros(size), -right
    fewest, patience = size + 1, 3
    for _ in range(10 * size):
        x[:] = 0
        x[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free])
        gradient = matrix @ x - right
        gradient[free] = 0
        wrong = (free & (x < 0)) | (~free & (gradient < -1e-12 * np.abs(right).max(initial=1e-300)))
        count = int(wrong.sum())
        if count == 0:
            break
        # All at once as long as that leads on, else one at a time, which ends for certain.
        if count < fewest:
            fewest, patience = count, 3
        elif patience:
            patience -= 1
        else:
            wrong &= np.arange(size) == np.flatnonzero(wrong)[-1]
        free ^= wrong
    return np.maximum(x, 0)
