"""MERL `.binary`: a full isotropic table in half and difference angles.

Three little-endian int32 (90, 90, 180), then the red, green and blue planes in float64, each
[theta_h][theta_d][phi_d]. The value in 1/sr is raw x (1, 1.15, 1.66) / 1500. Cell i of theta_h
stands for (i / 90)^2 x 90 degrees; theta_d (90 degrees) and phi_d (180 degrees) are linear, and
phi_d + 180 degrees is the same cell, by reciprocity. A negative raw value in any channel marks a
cell as invalid.

Whether the value belongs to a cell's lower edge or to its centre is disputed among readers: the
option `cells` says it. `edge` agrees best with published slices and is the default.

Matusik 2003: W. Matusik, H. Pfister, M. Brand, L. McMillan, "A Data-Driven Reflectance Model", ACM
TOG 22(3), 2003.
"""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable
from typing import Literal

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError, UserError
from fitter.formats._angular_table import AngularTable
from fitter.reflectance import HORIZON_COSINE, Grid, Reflectance
from fitter.rusinkiewicz import directions, half_difference

NAME = "MERL"
DESCRIPTION = "isotropic table over half and difference angles, 90 x 90 x 180 (Matusik 2003)"
SUFFIXES = (".binary",)
OPTIONS = {"cells": ("edge", "centre")}

SCALE = np.array([1.0, 1.15, 1.66]) / 1500
SIZE = (90, 90, 180)
HEADER_BYTES = 12
INVALID = -1.0
CELL_OFFSET = {"edge": 0.0, "centre": 0.5}


def sniff(head: bytes) -> bool:
    """Whether the file starts with the header of a standard table."""
    return head[:HEADER_BYTES] == np.array(SIZE, "<i4").tobytes()


def axes(size: tuple[int, int, int] = SIZE, cells: str = "edge") -> dict[str, np.ndarray]:
    """The angles that a table's cells stand for.

    **Arguments:**

    - `size`: number of cells along theta_h, theta_d and phi_d.
    - `cells`: `edge` or `centre`.

    **Returns:** `theta_h`, `theta_d`, `phi_d`, each one-dimensional, radians.
    """
    i, j, k = (np.arange(count) + CELL_OFFSET[cells] for count in size)
    return {
        "theta_h": (i / size[0]) ** 2 * (np.pi / 2),
        "theta_d": j / size[1] * (np.pi / 2),
        "phi_d": k / size[2] * np.pi,
    }


def cells_of(grid: Grid | None) -> Literal["edge", "centre"] | None:
    """`edge` or `centre` if a grid is laid out as a MERL table with these cells, of whatever size; else None."""
    if grid is None or tuple(grid.axes) != ("theta_h", "theta_d", "phi_d"):
        return None
    size = grid.shape
    assert len(size) == 3
    for cells in ("edge", "centre"):
        if all(np.allclose(grid.axes[name], axis) for name, axis in axes(size, cells).items()):
            return cells
    return None


def read(path: str | os.PathLike[str], cells: str = "edge") -> Reflectance:
    """Reads a MERL table. Other sizes than 90 x 90 x 180 are accepted if the file has their length.

    **Arguments:**

    - `path`: the file.
    - `cells`: whether a cell's value belongs to its lower `edge` or its `centre`.

    **Returns:** one sample for every valid cell above the horizon, with `grid`. `evaluate` is
    trilinear in the cells' own coordinates (the square root of theta_h), periodic in phi_d,
    constant beyond the first and last cell; invalid cells are left out of the mean and the other
    weights scaled up. At theta_d = 0, where phi_d means nothing, the cell of phi_d = 0 counts.

    **Raises:** `FileError` if the header or the length is wrong, or no cell is valid.
    """
    raw, size = _load(pathlib.Path(path))
    table_axes = axes(size, cells)
    above = _above_horizon(table_axes)
    plane = raw.reshape(3, -1)
    finite = np.isfinite(plane).all(0)
    valid = (plane >= 0).all(0)
    index = np.flatnonzero(above & valid & finite)
    dropped = {
        "below horizon": int(np.count_nonzero(~above)),
        "not finite": int(np.count_nonzero(above & ~finite)),
        "marked invalid": int(np.count_nonzero(above & finite & ~valid)),
    }
    if not index.size:
        raise FileError(
            path,
            f"has no valid cell: of {above.sum()} above the horizon {dropped['not finite']} are "
            f"not finite and {dropped['marked invalid']} negative.",
            "Download it again.",
        )
    # Invalid cells are NaN from here on: the interpolation leaves them out.
    plane[:, ~(valid & finite)] = np.nan
    plane *= SCALE[:, None]
    i, j, k = np.unravel_index(index, size)
    wi, wo = directions(table_axes["theta_h"][i], table_axes["theta_d"][j], table_axes["phi_d"][k])
    del i, j, k, above, valid, finite
    return Reflectance(
        wi=wi,
        wo=wo,
        value=np.ascontiguousarray(plane[:, index].T),
        source=f"{os.path.basename(path)} ({NAME}, values at the cells' {cells})",
        format=NAME,
        dropped={reason: count for reason, count in dropped.items() if count},
        grid=Grid(table_axes, index),
        interpolant=_Interpolant(AngularTable(raw, (False, False, True)), CELL_OFFSET[cells]),
    )


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes a measurement whose grid is a MERL table; cells without a sample become -1.

    **Arguments:**

    - `reflectance`: with a grid over theta_h (quadratic), theta_d and phi_d, of either `cells`.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `UserError` if the grid is another; `FileError` if the file cannot be written.
    """
    grid = reflectance.grid
    if grid is None or cells_of(grid) is None:
        raise UserError(
            f"`{reflectance.source}` is not laid out as a MERL table. Resample it: "
            "`fitter.formats.merl.write_function(data.evaluate, path)`, or write a `.csv`."
        )
    _store(grid.scatter(reflectance.value), path, force)


def write_function(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    path: str | os.PathLike[str],
    size: tuple[int, int, int] = SIZE,
    cells: str = "edge",
    force: bool = False,
) -> None:
    """Tabulates any BRDF as a MERL file: synthetic tables, or another format resampled.

    **Arguments:**

    - `function`: (wi, wo), each (n, 3), to (n, 3) in 1/sr without the cosine.
    - `path`: where to.
    - `size`: number of cells along theta_h, theta_d and phi_d.
    - `cells`: the place in a cell at which `function` is taken, `edge` or `centre`.
    - `force`: whether an existing file may be replaced.

    Cells below the horizon, and those where a channel is negative or not finite, become -1.

    **Raises:** `FileError` if the file cannot be written.
    """
    table_axes = axes(size, cells)
    above = _above_horizon(table_axes).reshape(size)
    full = np.full((*size, 3), np.nan)
    # One theta_h at a time bounds the memory of `function`.
    for i, theta_h in enumerate(table_axes["theta_h"]):
        j, k = np.nonzero(above[i])
        if len(j):
            theta_d, phi_d = table_axes["theta_d"][j], table_axes["phi_d"][k]
            full[i, j, k] = function(*directions(theta_h, theta_d, phi_d))
    _store(full, path, force)


def _load(path: pathlib.Path) -> tuple[np.ndarray, tuple[int, int, int]]:
    """The raw planes, (3, theta_h, theta_d, phi_d), after the header was checked against the size."""
    length = path.stat().st_size
    if length < HEADER_BYTES:
        raise FileError(
            path,
            f"ends at byte {length}, inside the header of {HEADER_BYTES} bytes.",
            "It is truncated: download it again.",
        )
    with open(path, "rb") as file:
        rows, columns, layers = (int(count) for count in np.fromfile(file, "<i4", 3))
        size = (rows, columns, layers)
        expected = HEADER_BYTES + 24 * size[0] * size[1] * size[2]
        if min(size) < 1 or max(size) > 65536:
            raise FileError(
                path,
                f"gives the table sizes {size} in bytes 0-11.",
                f"A MERL file has {SIZE}: this is another format, or damaged.",
            )
        if length != expected:
            truncated = size == SIZE and length < expected
            raise FileError(
                path,
                f"is {length} bytes long, but a table of {size[0]} x {size[1]} x {size[2]} (bytes "
                f"0-11) takes {expected}.",
                "It is truncated: download it again."
                if truncated
                else "It is damaged or not a MERL file: check where it comes from.",
            )
        raw = np.fromfile(file, "<f8", 3 * size[0] * size[1] * size[2])
    return raw.astype(np.float64, copy=False).reshape(3, *size), size


def _store(values: np.ndarray, path: str | os.PathLike[str], force: bool) -> None:
    """Writes (theta_h, theta_d, phi_d, 3) in 1/sr; cells that are not all valid as -1."""
    valid = (values >= 0).all(-1) & np.isfinite(values).all(-1)
    with atomic_path(path, force) as temporary, open(temporary, "wb") as file:
        file.write(np.array(values.shape[:3], "<i4").tobytes())
        for channel in range(3):
            plane = np.where(valid, values[..., channel] / SCALE[channel], INVALID)
            file.write(plane.astype("<f8", copy=False).tobytes())


def _above_horizon(table_axes: dict[str, np.ndarray]) -> np.ndarray:
    """(cells,) whether both directions of a cell are above the horizon (Rusinkiewicz 1998)."""
    theta_h, theta_d = table_axes["theta_h"][:, None, None], table_axes["theta_d"][:, None]
    middle = np.cos(theta_h) * np.cos(theta_d)
    aside = np.abs(np.sin(theta_h) * np.sin(theta_d) * np.cos(table_axes["phi_d"]))
    return (middle - aside > HORIZON_COSINE).ravel()


class _Interpolant:
    """(wi, wo) to the table's value; see `read`."""

    def __init__(self, table: AngularTable, offset: float):
        self.table, self.offset = table, offset

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        angles = half_difference(wi, wo)
        rows, columns, layers = self.table.size
        return self.table.interpolate(
            np.sqrt(angles.theta_h / (np.pi / 2)) * rows - self.offset,
            angles.theta_d / (np.pi / 2) * columns - self.offset,
            # phi_d and phi_d + pi are the same cell: the axis is periodic in pi.
            angles.phi_d / np.pi * layers - self.offset,
        )
