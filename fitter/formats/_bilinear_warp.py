"""Warps between the unit square and a bilinearly interpolated density on it.

A density given at the nodes of a regular grid (x fast, y slow) is sampled by its marginal in y,
then by its conditional in x. The warp takes uniform numbers `(u_x, u_y)` to `(x, y)` distributed
like the density; its inverse takes `(x, y)` to the cumulative probabilities. Between densities at
several parameter values, densities and cumulative sums are interpolated linearly.

Dupuy and Jakob 2018: J. Dupuy, W. Jakob, "An Adaptive Parameterization for Efficient Material
Acquisition and Rendering", ACM TOG 37(6), 2018, which stores reflectance over such squares.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np


def bracket(axis: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The interval of an ascending axis that holds each value, and how far along it lies.

    **Arguments:**

    - `axis`: (m,) ascending.
    - `value`: (n,) in the axis' unit; beyond the ends the end counts.

    **Returns:** (n,) lower index (0 for an axis of one), and (n,) fraction in [0, 1].
    """
    if len(axis) == 1:
        return np.zeros(len(value), np.intp), np.zeros(len(value))
    lower = np.clip(np.searchsorted(axis, value, side="right") - 1, 0, len(axis) - 2)
    fraction = (value - axis[lower]) / (axis[lower + 1] - axis[lower])
    return lower, np.clip(fraction, 0.0, 1.0)


def slice_weights(
    axes: tuple[np.ndarray, ...], values: tuple[np.ndarray, ...]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Multilinear interpolation between slices: the (slice, weight) pairs to sum over.

    **Arguments:**

    - `axes`: one ascending axis per parameter; slices are numbered in C order.
    - `values`: one (n,) array per parameter.

    **Returns:** an iterator over (n,) slice numbers and (n,) weights, 2 per axis longer than one.
    """
    brackets = [bracket(axis, value) for axis, value in zip(axes, values, strict=True)]
    choices = [(0, 1) if len(axis) > 1 else (0,) for axis in axes]
    for corner in itertools.product(*choices):
        number = np.zeros(len(values[0]), np.intp)
        weight = np.ones(len(values[0]))
        for axis, (lower, fraction), high in zip(axes, brackets, corner, strict=True):
            number = number * len(axis) + lower + high
            weight = weight * (fraction if high else 1 - fraction)
        yield number, weight


def patch(position: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """The cell of a node-centred unit axis: (n,) lower node and (n,) fraction towards the next."""
    scaled = np.clip(position, 0.0, 1.0) * (size - 1)
    lower = np.minimum(scaled.astype(np.intp), size - 2)
    return lower, scaled - lower


def bilinear(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """An image with nodes at the borders of the unit square, between its nodes.

    **Arguments:**

    - `image`: (rows, columns).
    - `x`, `y`: (n,) in [0, 1], along columns and rows.

    **Returns:** (n,).
    """
    column, s = patch(x, image.shape[1])
    row, t = patch(y, image.shape[0])
    lower = (1 - s) * image[row, column] + s * image[row, column + 1]
    upper = (1 - s) * image[row + 1, column] + s * image[row + 1, column + 1]
    return (1 - t) * lower + t * upper


class BilinearWarp:
    """The warp of a density that depends on parameters.

    **Arguments:**

    - `density`: (parameter sizes..., rows, columns), not negative; each slice is normalised here.
    - `axes`: one ascending axis per parameter.

    **Raises:** `ValueError` if a slice integrates to nothing.
    """

    def __init__(self, density: np.ndarray, axes: tuple[np.ndarray, ...]):
        self.axes = axes
        self.rows, self.columns = density.shape[-2:]
        slices = density.astype(np.float64).reshape(-1, self.rows, self.columns)
        # Trapezoidal sums are exact for what is piecewise linear. The unit of x and y is a cell.
        along = np.zeros_like(slices)
        np.cumsum((slices[..., :-1] + slices[..., 1:]) / 2, axis=2, out=along[..., 1:])
        totals = along[..., -1]
        marginal = np.zeros_like(totals)
        np.cumsum((totals[:, :-1] + totals[:, 1:]) / 2, axis=1, out=marginal[:, 1:])
        mass = marginal[:, -1].copy()
        if not (mass > 0).all():
            raise ValueError(f"slice {int(np.argmin(mass > 0))} integrates to nothing")
        self._density = slices / mass[:, None, None]
        self._conditional = along / mass[:, None, None]
        self._marginal = marginal / mass[:, None]

    def invert(self, x: np.ndarray, y: np.ndarray, parameters: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Takes points to their cumulative probabilities (Dupuy and Jakob 2018).

        **Arguments:**

        - `x`, `y`: (n,) in [0, 1].
        - `parameters`: one (n,) array per axis.

        **Returns:** `u_x`, `u_y`, each (n,) in [0, 1]; `u_x` is 0 where a whole row is empty.
        """
        column, s = patch(x, self.columns)
        row, t = patch(y, self.rows)
        count = len(column)
        corners = np.zeros((4, count))  # densities around the point
        sums = np.zeros((4, count))  # conditional sums at the cell's left; totals of both rows
        below = np.zeros(count)  # marginal sum below the cell
        for number, weight in slice_weights(self.axes, parameters):
            line = number * self.rows + row
            cell = line * self.columns + column
            density, conditional = self._density.reshape(-1), self._conditional.reshape(-1)
            corners += weight * np.stack(
                [
                    density[cell],
                    density[cell + 1],
                    density[cell + self.columns],
                    density[cell + self.columns + 1],
                ]
            )
            last = line * self.columns + self.columns - 1
            sums += weight * np.stack(
                [
                    conditional[cell],
                    conditional[cell + self.columns],
                    conditional[last],
                    conditional[last + self.columns],
                ]
            )
            below += weight * self._marginal.reshape(-1)[line]
        left = (1 - t) * corners[0] + t * corners[2]
        right = (1 - t) * corners[1] + t * corners[3]
        partial = (1 - t) * sums[0] + t * sums[1] + s * (left + s / 2 * (right - left))
        total = (1 - t) * sums[2] + t * sums[3]
        u_x = np.divide(partial, total, out=np.zeros(count), where=total > 0)
        u_y = below + t * (sums[2] + t / 2 * (sums[3] - sums[2]))
        return np.clip(u_x, 0.0, 1.0), np.clip(u_y, 0.0, 1.0)

    def warp(self, number: int, u_x: np.ndarray, u_y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Takes a grid of uniform numbers to points distributed like one slice's density.

        **Arguments:**

        - `number`: the slice, in C order of the parameters.
        - `u_x`: (columns,) in [0, 1].
        - `u_y`: (rows,) in [0, 1].

        **Returns:** `x` and `y`, each (rows, columns): row `i` belongs to `u_y[i]`.
        """
        totals = self._conditional[number, :, -1]
        row, t = _invert_sums(self._marginal[number][None], totals[None], u_y[None])
        row, t = row[0], t[0]
        mix = t[:, None]
        sums = self._conditional[number]
        sums = (1 - mix) * sums[row] + mix * sums[row + 1]
        density = self._density[number]
        density = (1 - mix) * density[row] + mix * density[row + 1]
        column, s = _invert_sums(sums, density, u_x[None] * sums[:, -1:])
        y = np.broadcast_to(((row + t) / (self.rows - 1))[:, None], column.shape)
        return (column + s) / (self.columns - 1), y


def _invert_sums(sums: np.ndarray, density: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where trapezoidal sums reach a target: (m, k) cell and fraction, for rows of (m, size).

    At the very ends of the sum the border of the support is meant, not of the axis.
    """
    size = sums.shape[1]
    cell = np.empty(np.broadcast_shapes(target.shape, (len(sums), 1)), np.intp)
    for line in range(len(sums)):
        wanted = target[line]
        found = np.searchsorted(sums[line], wanted, side="right") - 1
        # A target equal to the whole sum is reached first at the end of the support.
        first = np.searchsorted(sums[line], wanted, side="left") - 1
        cell[line] = np.where(wanted >= sums[line, -1], first, found)
    cell = np.clip(cell, 0, size - 2)
    at, after = (np.take_along_axis(density, cell + step, 1) for step in (0, 1))
    missing = np.maximum(target - np.take_along_axis(sums, cell, 1), 0.0)
    # missing = at t + (after - at) t^2 / 2, in the form that does not cancel.
    root = np.sqrt(np.maximum(at**2 + 2 * (after - at) * missing, 0.0))
    bottom = at + root
    fraction = np.divide(2 * missing, bottom, out=np.zeros_like(missing), where=bottom > 0)
    return cell, np.clip(fraction, 0.0, 1.0)
