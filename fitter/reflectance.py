"""`Reflectance`: what every reader returns and everything after it works on.

Directions follow the house convention: `wi` points to the light, `wo` to the viewer, both unit, in
the local frame whose normal is +z. Values are 1/sr, without the cosine, linear Rec. 709.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np

from brdf.errors import UserError

# A direction written with three decimals has a length within 0.9e-3 of one; anything further off
# was not meant to be a unit vector.
UNIT_TOLERANCE = 1e-3
# Below this the length is one up to rounding and is left alone, so that a file's own angles come
# back unchanged.
UNIT_ROUNDING = 1e-12
# A cosine below this is the horizon: float32 angles, such as pi/2 in an RGL file, tell no less.
HORIZON_COSINE = 1e-6
# Interpolation takes some hundred bytes per direction: this bounds it to tens of megabytes.
ROWS_AT_ONCE = 1 << 16

Interpolant = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclasses.dataclass(frozen=True, eq=False)
class Grid:
    """The regular table of angles behind the samples.

    Use it to draw slices, or to evaluate what depends on one angle only once per row.

    **Arguments:**

    - `axes`: name -> (size,) radians, in C order, such as `theta_h`, `theta_d`, `phi_d`.
    - `index`: (n,) int, the flat C-order cell of each sample; no cell twice.

    **Raises:** `UserError` if an index lies outside the table.
    """

    axes: Mapping[str, np.ndarray]
    index: np.ndarray

    def __post_init__(self):
        index = np.asarray(self.index)
        cells = int(np.prod(self.shape))
        if index.size and (index.min() < 0 or index.max() >= cells):
            raise UserError(
                f"`index = {index.min()}..{index.max()}` leaves the grid of {cells} cells. "
                "Pass flat C-order cell numbers that start at 0."
            )
        object.__setattr__(self, "index", _frozen(index))

    @property
    def shape(self) -> tuple[int, ...]:
        """The table's size along each axis."""
        return tuple(len(axis) for axis in self.axes.values())

    def scatter(self, values: np.ndarray) -> np.ndarray:
        """Puts one number or colour per sample back into the full table.

        **Arguments:**

        - `values`: (n,) or (n, 3), in the order of the samples.

        **Returns:** an array of the grid's shape (and a last axis of 3 for colours), NaN where the
        table has no sample.

        **Raises:** `UserError` if there are not as many values as samples.
        """
        values = np.asarray(values, np.float64)
        if len(values) != len(self.index):
            raise UserError(f"`values` has {len(values)} rows for {len(self.index)} samples. Pass one each.")
        full = np.full((int(np.prod(self.shape)), *values.shape[1:]), np.nan)
        full[self.index] = values
        return full.reshape(*self.shape, *values.shape[1:])


@dataclasses.dataclass(frozen=True, eq=False)
class Reflectance:
    """Measured reflectance: samples to fit, and where the format defines it, values in between.

    Validated once, here; what uses it need not check again. The arrays are read-only.

    **Arguments:**

    - `wi`: (n, 3) unit, to the light, `cos_i > 0`. Lengths within 1e-3 of one are accepted and
      normalised.
    - `wo`: (n, 3) unit, to the viewer, `cos_o > 0`.
    - `value`: (n, 3) in 1/sr without the cosine, linear Rec. 709, finite and not negative.
    - `source`: what a report prints: file name, format and what the reader assumed.
    - `weight`: (n,) not negative, not all zero, or (1,) for the same everywhere; 1 by default.
    - `format`: name of the format, such as `MERL`.
    - `dropped`: reason -> how many samples the reader left out for it.
    - `clamped`: how many channel values were negative by noise or by an out-of-gamut colour, in a
      format where this does not mark the sample as invalid; `value` holds 0 there and
      `evaluate` the exact negative number.
    - `grid`: the angular table behind the samples, if there is one.
    - `interpolant`: what `evaluate` calls, if the format defines values in between.
    - `sigma`: (n,) or (n, 3) positive, 1/sr: the standard error of `value`, if the file tells it.
      A loss on a compressed value must carry it through the compression; `weight` then counts
      besides.

    **Raises:** `UserError` on wrong shapes, non-finite or negative numbers, directions that are not
    unit or lie below the horizon, or no sample at all.
    """

    wi: np.ndarray
    wo: np.ndarray
    value: np.ndarray
    source: str
    weight: np.ndarray = dataclasses.field(default_factory=lambda: np.ones(1))
    format: str = ""
    dropped: Mapping[str, int] = dataclasses.field(default_factory=dict)
    clamped: int = 0
    grid: Grid | None = None
    interpolant: Interpolant | None = None
    sigma: np.ndarray | None = None

    def __post_init__(self):
        wi, wo = unit_directions(self.wi, "wi"), unit_directions(self.wo, "wo")
        count = len(wi)
        if count == 0:
            raise UserError(
                f"`{self.source}` holds no usable sample. {_tell(self.dropped)}"
                "Check that the file is whole and of this format, and keep more of it."
            )
        value = np.asarray(self.value, np.float64)
        if value.shape != (count, 3) or len(wo) != count:
            raise UserError(
                f"`wi`, `wo` and `value` have the shapes {wi.shape}, {wo.shape}, {value.shape}. "
                "Pass (n, 3) for each, with the same n."
            )
        for name, cosine in (("wi", wi[:, 2]), ("wo", wo[:, 2])):
            _refuse(cosine <= 0, cosine, f"`{name}` z", "lies below the horizon", "Leave it out.")
        _refuse(~np.isfinite(value), value, "`value`", "is not finite", "Leave the sample out.")
        _refuse(
            value < 0,
            value,
            "`value`",
            "is negative",
            "Leave the sample out, or clamp the channel to 0 and count it in `clamped`.",
        )
        weight = np.asarray(self.weight, np.float64)
        if weight.shape == (1,):
            weight = np.full(count, weight[0])
        if weight.shape != (count,):
            raise UserError(f"`weight` has the shape {weight.shape}. Pass ({count},).")
        _refuse(
            ~(np.isfinite(weight) & (weight >= 0)),
            weight,
            "`weight`",
            "is negative or not finite",
            "Pass 0 for a sample that is not to count.",
        )
        if not weight.any():
            raise UserError("Every `weight` is 0. Pass at least one that is positive.")
        if self.grid is not None and len(self.grid.index) != count:
            raise UserError(
                f"`grid.index` has {len(self.grid.index)} entries for {count} samples. Pass one cell per sample."
            )
        if self.sigma is not None:
            sigma = np.asarray(self.sigma, np.float64)
            if sigma.shape not in ((count,), (count, 3)):
                raise UserError(f"`sigma` has the shape {sigma.shape}. Pass ({count},) or ({count}, 3).")
            _refuse(
                ~(np.isfinite(sigma) & (sigma > 0)),
                sigma,
                "`sigma`",
                "is not positive and finite",
                "Leave out samples whose standard error is unknown, or pass `sigma=None`.",
            )
            object.__setattr__(self, "sigma", _frozen(sigma))
        for name, array in (("wi", wi), ("wo", wo), ("value", value), ("weight", weight)):
            object.__setattr__(self, name, _frozen(array))

    def __len__(self) -> int:
        return len(self.wi)

    def evaluate(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The measurement itself at any directions, interpolated as its format defines.

        **Arguments:**

        - `wi`: (n, 3) unit, to the light: the file's incident direction.
        - `wo`: (n, 3) unit, to the viewer.

        **Returns:** (n, 3) in 1/sr without the cosine. 0 where a direction is at or below the
        horizon; NaN where the file has no valid cell around the point; negative where the file's
        own numbers are.

        **Raises:** `UserError` if the format has no interpolation, or on directions that are not
        (n, 3) and unit.
        """
        if self.interpolant is None:
            raise UserError(
                f"`{self.source}` holds scattered samples, between which its format defines no "
                "value. Fit a model to it and evaluate that: `brdf fit ... -o material.json`, then "
                "`brdf evaluate material.json`."
            )
        wi, wo = unit_directions(wi, "wi"), unit_directions(wo, "wo")
        if len(wi) != len(wo):
            raise UserError(f"`wi` has {len(wi)} rows and `wo` {len(wo)}. Pass as many of one as of the other.")
        value = np.zeros((len(wi), 3))
        above = np.flatnonzero((wi[:, 2] > 0) & (wo[:, 2] > 0))
        for start in range(0, len(above), ROWS_AT_ONCE):
            rows = above[start : start + ROWS_AT_ONCE]
            value[rows] = self.interpolant(wi[rows], wo[rows])
        return value

    def select(self, keep: np.ndarray, reason: str) -> Reflectance:
        """The same measurement with fewer samples; the rest is counted under `reason`.

        **Arguments:**

        - `keep`: (n,) bool.
        - `reason`: the key under which `dropped` counts the others, such as `beyond 80 degrees`.

        **Returns:** a new `Reflectance`; `evaluate` still knows the whole file.

        **Raises:** `UserError` if none is left.
        """
        keep = np.asarray(keep, bool)
        dropped = dict(self.dropped)
        left_out = int(len(self) - np.count_nonzero(keep))
        if left_out:
            dropped[reason] = dropped.get(reason, 0) + left_out
        grid = self.grid and Grid(self.grid.axes, self.grid.index[keep])
        return dataclasses.replace(
            self,
            wi=self.wi[keep],
            wo=self.wo[keep],
            value=self.value[keep],
            weight=self.weight[keep],
            sigma=None if self.sigma is None else self.sigma[keep],
            dropped=dropped,
            grid=grid,
        )


def unit_directions(directions: np.ndarray, name: str) -> np.ndarray:
    """Checks that rows are unit vectors and normalises those that are nearly so.

    **Arguments:**

    - `directions`: (n, 3).
    - `name`: what an error calls it.

    **Returns:** (n, 3) float64; the same array if every length is one up to rounding.

    **Raises:** `UserError` on another shape, a number that is not finite, or a length more than
    1e-3 from one.
    """
    if np.iscomplexobj(directions):
        raise UserError(f"`{name}` is complex. Pass (n, 3) real floats.")
    try:
        directions = np.asarray(directions, np.float64)
    except (TypeError, ValueError) as error:
        raise UserError(f"`{name}` is not an array of numbers. Pass (n, 3) floats.") from error
    if directions.ndim != 2 or directions.shape[1] != 3:
        raise UserError(f"`{name}` has the shape {directions.shape}. Pass (n, 3), one row each.")
    length = np.sqrt(np.einsum("ij,ij->i", directions, directions))
    error = np.abs(length - 1)
    _refuse(
        ~(error <= UNIT_TOLERANCE),
        length,
        f"the length of `{name}`",
        "is not 1 to within 0.001",
        "Pass unit vectors.",
    )
    if error.max(initial=0) > UNIT_ROUNDING:
        return directions / length[:, None]
    return directions


def _refuse(bad: np.ndarray, values: np.ndarray, what: str, rule: str, remedy: str) -> None:
    """Raises on the first `True` of `bad`, showing the number and its row."""
    if bad.any():
        place = np.unravel_index(int(np.argmax(bad)), bad.shape)
        raise UserError(
            f"{what} {rule} in {np.count_nonzero(bad)} places, first `{values[place]:g}` in row {place[0]}. {remedy}"
        )


def _tell(dropped: Mapping[str, int]) -> str:
    """Why samples were dropped, as a sentence, or nothing."""
    if not dropped:
        return ""
    return "Left out: " + ", ".join(f"{count} {reason}" for reason, count in dropped.items()) + ". "


def _frozen(array: np.ndarray) -> np.ndarray:
    """A read-only view; the caller's own array stays writable."""
    view = array.view()
    view.flags.writeable = False
    return view
