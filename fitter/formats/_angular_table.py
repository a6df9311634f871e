"""Multilinear interpolation in a table with holes, shared by the formats that are tables."""

from __future__ import annotations

import itertools

import numpy as np

# Cells: angles computed from directions carry some 1e-16 of rounding, which the square root of
# MERL's theta_h axis turns into 1e-8 of the axis, 1e-6 of a cell. A coordinate this near to a cell
# means the cell itself.
SNAP_CELLS = 2e-6


class AngularTable:
    """A table of colours whose cells lie at whole-numbered coordinates.

    **Arguments:**

    - `planes`: (3, ...) 1/sr, one plane per channel, NaN in all three where a cell is invalid.
    - `periodic`: one bool per axis: whether the last cell is followed by the first. Other axes
      continue with their first or last cell.
    """

    def __init__(self, planes: np.ndarray, periodic: tuple[bool, ...]):
        self.size: tuple[int, ...] = planes.shape[1:]
        self._planes = planes.reshape(3, -1)
        self._periodic = periodic

    def interpolate(self, *coordinates: np.ndarray) -> np.ndarray:
        """The multilinear mean of the valid cells around each point.

        **Arguments:**

        - `coordinates`: one (n,) array per axis, in cells.

        **Returns:** (n, 3); exactly the cell's value at a cell. Invalid cells are left out and the
        other weights scaled up; NaN where none is valid.
        """
        lower, upper, weight = zip(*map(self._bracket, coordinates, self.size, self._periodic), strict=True)
        count = len(coordinates[0])
        total, value = np.zeros(count), np.zeros((3, count))
        for corner in itertools.product((False, True), repeat=len(self.size)):
            cell = np.zeros(count, np.intp)
            share = np.ones(count)
            for axis, high in enumerate(corner):
                cell = cell * self.size[axis] + (upper[axis] if high else lower[axis])
                share *= weight[axis] if high else 1 - weight[axis]
            part = self._planes[:, cell]
            used = (share > 0) & np.isfinite(part[0])
            total += np.where(used, share, 0.0)
            value += np.where(used, share * part, 0.0)
        with np.errstate(invalid="ignore"):  # 0 / 0 is the NaN that is promised
            return (value / total).T

    @staticmethod
    def _bracket(coordinate: np.ndarray, size: int, periodic: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The two cells around each coordinate and the weight of the upper one."""
        nearest = np.round(coordinate)
        coordinate = np.where(np.abs(coordinate - nearest) < SNAP_CELLS, nearest, coordinate)
        if periodic:
            floor = np.floor(coordinate)
            lower = floor.astype(np.intp) % size
            return lower, (lower + 1) % size, coordinate - floor
        coordinate = np.clip(coordinate, 0, size - 1)
        lower = np.minimum(coordinate.astype(np.intp), max(size - 2, 0))
        return lower, np.minimum(lower + 1, size - 1), coordinate - lower
