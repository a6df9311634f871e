"""What each sample counts in a fit."""

from __future__ import annotations

import jax
import numpy as np
from jaxtyping import Float

from brdf.errors import UserError, nearest

from .loss import Loss, compressed
from .reflectance import Reflectance

WEIGHTS = ("samples", "grid", "solid_angle", "sigma")


def weights(data: Reflectance, kind: str, loss: Loss) -> Float[np.ndarray, "n _"]:
    """The weight of each sample, shape (n, 1), or (n, 3) where channels differ.

    **Arguments:**

    - `kind`: on top of the file's own weights,
        - `"samples"`: every sample the same;
        - `"grid"`: a table's samples by the part of the half and difference angles that a cell covers,
          `sin(theta_h) sin(theta_d)` times its steps: the sum over cells stands for the integral over both angles
          (Rusinkiewicz 1998);
        - `"solid_angle"`: the same as an integral over the solid angles of both directions, `4 cos(theta_d)` more;
        - `"sigma"`: one over the square of the file's standard errors, carried through the loss's compression.
    - `loss`: what compresses the values.

    Raises `UserError` for an unknown kind, and where the measurement has no table or no standard errors.
    """
    if kind not in WEIGHTS:
        raise UserError(f"`{kind}` is not a kind of weights. {nearest(kind, WEIGHTS)}")
    own = data.weight[:, None]
    if kind == "samples":
        return own
    if kind == "sigma":
        return own * _precision(data, loss)
    if data.grid is None or "theta_h" not in data.grid.axes or "theta_d" not in data.grid.axes:
        raise UserError(
            f"`{data.source}` is no table over theta_h and theta_d, so that `{kind}` weights are not defined. "
            "Leave `--weights` out."
        )
    cell = np.ones(data.grid.shape)
    for place, (name, axis) in enumerate(data.grid.axes.items()):
        is_polar = name.startswith("theta")
        edges = _edges(axis)
        if is_polar:
            edges = np.clip(edges, 0, np.pi / 2)
        middle = 0.5 * (edges[1:] + edges[:-1])
        factor = np.diff(edges) * (np.sin(middle) if is_polar else 1.0)
        if kind == "solid_angle" and name == "theta_d":
            factor = factor * 4 * np.cos(middle)
        cell = cell * factor.reshape([-1 if axis_ == place else 1 for axis_ in range(cell.ndim)])
    return own * np.maximum(cell.ravel()[data.grid.index], 0.0)[:, None]


def _edges(axis: Float[np.ndarray, " m"]) -> Float[np.ndarray, " _"]:
    """Where the cells of an axis end: half-way between neighbours, and as far beyond the first and the last."""
    if len(axis) == 1:
        return np.array([axis[0] - 0.5, axis[0] + 0.5])
    middle = 0.5 * (axis[1:] + axis[:-1])
    return np.concatenate([[2 * axis[0] - middle[0]], middle, [2 * axis[-1] - middle[-1]]])


def _precision(data: Reflectance, loss: Loss) -> Float[np.ndarray, "n _"]:
    if data.sigma is None:
        raise UserError(f"`{data.source}` gives no standard errors. Add a column `sigma`, or leave `--weights` out.")
    with jax.enable_x64(True):
        _, rise = compressed(loss, data.value.T, data.wi[:, 2][None])
    sigma = data.sigma.reshape(len(data), -1)
    return 1 / (np.asarray(rise).T * sigma) ** 2
