"""Slices at phi_d = 90 degrees: what the formats that hold one share.

Row i of n stands for theta_d = i / n x 90 degrees, column j of m for theta_h = j / m x 90 degrees, or (j / m)^2 x 90
degrees where it is quadratic; half a step further where a value belongs to the cell's centre instead of its lower edge.

A slice at phi_d = 90 degrees has both directions at the same height, so that no cell lies below the horizon. It says
nothing about how the reflectance depends on phi_d: `evaluate` takes it to be the same everywhere (a bivariate BRDF, in
theta_h and theta_d).
"""

from __future__ import annotations

import os

import numpy as np

from brdf.errors import FileError
from fitter.formats._angular_table import AngularTable
from fitter.reflectance import HORIZON_COSINE, Grid, Reflectance
from fitter.rusinkiewicz import directions, half_difference

CELL_OFFSET = {"edge": 0.0, "centre": 0.5}
EXPONENT = {"linear": 1, "quadratic": 2}


def slice_measurement(
    path: str | os.PathLike[str],
    values: np.ndarray,
    *,
    what: str,
    source: str,
    format: str,
    theta_h: str = "quadratic",
    cells: str = "edge",
) -> Reflectance:
    """The measurement that a slice holds.

    **Arguments:**

    - `path`: what errors name.
    - `values`: (rows, columns, 3) float64, 1/sr; it is changed: invalid cells become NaN.
    - `what`: the place in the file, for errors, or nothing.
    - `source`, `format`: as in `Reflectance`.
    - `theta_h`: `linear` or `quadratic`.
    - `cells`: whether a value belongs to the cell's lower `edge` or its `centre`.

    **Returns:** one sample per cell that is finite and has no negative channel, with `grid` over `theta_d`, `theta_h`.
    `evaluate` is bilinear in the cells' coordinates, constant beyond the first and last cell, and does not depend on
    phi_d; invalid cells are left out and the other weights scaled up.

    **Raises:** `FileError` if no cell is valid.
    """
    rows, columns = values.shape[:2]
    offset, exponent = CELL_OFFSET[cells], EXPONENT[theta_h]
    angle_d = (np.arange(rows) + offset) / rows * (np.pi / 2)
    angle_h = ((np.arange(columns) + offset) / columns) ** exponent * (np.pi / 2)
    finite = np.isfinite(values).all(2)
    with np.errstate(invalid="ignore"):
        valid = (values >= 0).all(2)
    above = np.cos(angle_d)[:, None] * np.cos(angle_h) > HORIZON_COSINE
    dropped = {
        "below horizon": int(np.count_nonzero(~above)),
        "not finite": int(np.count_nonzero(above & ~finite)),
        "marked invalid": int(np.count_nonzero(above & finite & ~valid)),
    }
    i, j = np.nonzero(above & finite & valid)
    if not len(i):
        raise FileError(
            path,
            f"{what}has no valid cell: of {values[..., 0].size} {dropped['not finite']} are not finite and "
            f"{dropped['marked invalid']} negative.",
            "Export it again.",
        )
    wi, wo = directions(angle_h[j], angle_d[i], np.full(len(i), np.pi / 2))
    value = values[i, j]
    values[~(finite & valid)] = np.nan
    return Reflectance(
        wi=wi,
        wo=wo,
        value=value,
        source=source,
        format=format,
        dropped={reason: count for reason, count in dropped.items() if count},
        grid=Grid({"theta_d": angle_d, "theta_h": angle_h}, i * columns + j),
        interpolant=_Interpolant(AngularTable(np.moveaxis(values, 2, 0), (False, False)), offset, exponent),
    )


class _Interpolant:
    """(wi, wo) to the slice's value; see `slice_measurement`."""

    def __init__(self, table: AngularTable, offset: float, exponent: int):
        self.table, self.offset, self.exponent = table, offset, exponent

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        angles = half_difference(wi, wo)
        rows, columns = self.table.size
        across = angles.theta_h / (np.pi / 2)
        return self.table.interpolate(
            angles.theta_d / (np.pi / 2) * rows - self.offset,
            (np.sqrt(across) if self.exponent == 2 else across) * columns - self.offset,
        )
