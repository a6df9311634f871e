"""UTIA `.bin`: a full anisotropic table over two polar angles and two azimuths.

Little-endian float64 without a header: the red, green and blue planes, each [theta_i][phi_i][theta_o][phi_o], with
theta = 0, 15, ... 75 degrees and phi = 0, 7.5, ... 352.5 degrees (the readers of Sztrajman, ALTA and dj_brdf, all
after the database's own code, agree on this). `i` is the light, `o` the viewer (the files' `v`). The cosine is not in:
no reader takes it out. Negative numbers are noise: they are clamped and counted.

What the numbers mean is disputed, and the option `values` says it. `stored`, the default, takes them as 1/sr and linear
Rec. 709, like ALTA and Sztrajman's reader: the file says nothing else. `encoded` is what dj_brdf came to in its later
versions, with a constant from the database's authors: the number divided by 140 is sRGB-encoded, and its decoded value
times 100 is in 1/sr; this makes small values 18 times darker. The report tells how much light the table reflects, so
that a wrong choice shows.

Filip and Vavra 2014: J. Filip, R. Vavra, "Template-Based Sampling of Anisotropic BRDFs", Computer Graphics Forum 33(7),
2014.
"""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError, UserError
from fitter.formats._angular_table import AngularTable
from fitter.formats._scattered import spherical
from fitter.reflectance import Grid, Reflectance

NAME = "UTIA"
DESCRIPTION = "anisotropic table, 15 degrees in theta and 7.5 in phi (Filip and Vavra 2014)"
SUFFIXES = (".bin",)
OPTIONS = {"values": ("stored", "encoded")}

THETAS, PHIS = 6, 48
SIZE = (THETAS, PHIS, THETAS, PHIS)
CELLS = THETAS * PHIS * THETAS * PHIS
BYTES = 3 * 8 * CELLS
THETA_STEP, PHI_STEP = np.pi / 12, 2 * np.pi / PHIS
# dj_brdf's constants, see above.
ENCODED_WHITE, DECODED_WHITE = 140.0, 100.0
# Numbers of a BRDF; text, read as float64, has other exponents.
PLAUSIBLE = (1e-12, 1e9)
# An albedo above one by this much is no rounding of the quadrature.
ALBEDO_MAX = 1.05


def sniff(head: bytes) -> bool:
    """Whether the first bytes are float64 numbers that a BRDF may have."""
    numbers = np.abs(np.frombuffer(head[: len(head) // 8 * 8], "<f8"))
    with np.errstate(invalid="ignore"):
        plausible = ((numbers > PLAUSIBLE[0]) & (numbers < PLAUSIBLE[1])) | (numbers == 0)
    return bool(numbers.any() and plausible.all())


def axes() -> dict[str, np.ndarray]:
    """The angles of the table: `theta_i`, `phi_i`, `theta_o`, `phi_o`, each one-dimensional, radians."""
    theta, phi = np.arange(THETAS) * THETA_STEP, np.arange(PHIS) * PHI_STEP
    return {"theta_i": theta, "phi_i": phi, "theta_o": theta, "phi_o": phi}


def read(path: str | os.PathLike[str], values: str = "stored") -> Reflectance:
    """Reads a UTIA table.

    **Arguments:**

    - `path`: the file.
    - `values`: whether the numbers are taken as they are `stored` or are `encoded`; see the module.

    **Returns:** one sample per cell that is finite, with `grid`. The 48 azimuths of a direction along the normal are
    one direction: they share its weight. `evaluate` is linear in the four angles (in the stored numbers), periodic in
    the azimuths, constant beyond 75 degrees; cells that are not finite are left out and the other weights scaled up.
    Along the normal, where an azimuth means nothing, the cell of azimuth 0 counts.

    **Raises:** `FileError` if the length is another or no cell is finite.
    """
    length = pathlib.Path(path).stat().st_size
    if length != BYTES:
        raise FileError(
            path,
            f"is {length} bytes long, but a UTIA table of 3 x {' x '.join(map(str, SIZE))} float64 takes {BYTES}.",
            "It is truncated: download it again." if length < BYTES else "It is another format: check its source.",
        )
    stored = np.fromfile(path, "<f8").astype(np.float64, copy=False).reshape(3, -1)
    finite = np.isfinite(stored).all(0)
    index = np.flatnonzero(finite)
    if not index.size:
        raise FileError(path, f"has no valid cell: none of {CELLS} is finite.", "Download it again.")
    stored[:, ~finite] = np.nan
    decode = _decode if values == "encoded" else _as_stored
    value = decode(stored[:, index]).T
    wi, wo, weight = _samples()
    return Reflectance(
        wi=wi[index],
        wo=wo[index],
        value=np.maximum(value, 0.0),
        weight=weight[index],
        source=f"{os.path.basename(path)} ({NAME}, values {values}, {_light(decode(stored), values)})",
        format=NAME,
        dropped={"not finite": CELLS - len(index)} if len(index) < CELLS else {},
        clamped=int(np.count_nonzero(value < 0)),
        grid=Grid(axes(), index),
        interpolant=_Interpolant(AngularTable(stored.reshape(3, *SIZE), (False, True, False, True)), decode),
    )


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes a measurement whose grid is a whole UTIA table, as `values = stored`.

    **Arguments:**

    - `reflectance`: with a grid over `theta_i`, `phi_i`, `theta_o`, `phi_o` as in `axes`.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `UserError` if the grid is another or lacks cells; `FileError` if the file cannot be written.
    """
    grid = reflectance.grid
    expected = axes()
    if grid is None or tuple(grid.axes) != tuple(expected) or grid.shape != SIZE:
        raise UserError(
            f"`{reflectance.source}` is not laid out as a UTIA table. Resample it: "
            "`fitter.formats.utia.write_function(data.evaluate, path)`, or write a `.csv`."
        )
    if not all(np.allclose(grid.axes[name], axis) for name, axis in expected.items()):
        raise UserError(f"`{reflectance.source}` has other angles than a UTIA table. Write a `.csv`.")
    if len(reflectance) < CELLS:
        raise UserError(
            f"`{reflectance.source}` lacks {CELLS - len(reflectance)} of {CELLS} cells, and UTIA files have no mark "
            "for that. Write a `.csv`."
        )
    _store(grid.scatter(reflectance.value).reshape(-1, 3), path, force)


def write_function(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray], path: str | os.PathLike[str], force: bool = False
) -> None:
    """Tabulates any BRDF as a UTIA file, as `values = stored`.

    **Arguments:**

    - `function`: (wi, wo), each (n, 3), to (n, 3) in 1/sr without the cosine.
    - `path`: where to.
    - `force`: whether an existing file may be replaced.

    **Raises:** `FileError` if the file cannot be written.
    """
    wi, wo, _ = _samples()
    _store(np.asarray(function(wi, wo), np.float64), path, force)


def _store(values: np.ndarray, path: str | os.PathLike[str], force: bool) -> None:
    with atomic_path(path, force) as temporary:
        temporary.write_bytes(np.ascontiguousarray(values.T).astype("<f8", copy=False).tobytes())


def _samples() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """wi, wo and weight of every cell, in the order of the file."""
    table_axes = axes()
    ends = [
        spherical(*np.meshgrid(table_axes[f"theta_{end}"], table_axes[f"phi_{end}"], indexing="ij")).reshape(-1, 3)
        for end in "io"
    ]
    share = np.ones((THETAS, PHIS))
    share[0] = 1 / PHIS
    count = THETAS * PHIS
    weight = np.outer(share.ravel(), share.ravel()).ravel()
    return np.repeat(ends[0], count, axis=0), np.tile(ends[1], (count, 1)), weight


def _light(values: np.ndarray, how: str) -> str:
    """How much light the table reflects at most, as a phrase: over directions of the light, and over channels."""
    table = np.nan_to_num(np.maximum(values, 0)).reshape(3, *SIZE)
    fine = np.linspace(0, np.pi / 2, 2001)
    hats = np.stack([np.interp(fine, axes()["theta_o"], hat) for hat in np.eye(THETAS)])
    by_theta = np.trapezoid(hats * np.sin(fine) * np.cos(fine), fine, axis=1) * PHI_STEP
    most = float(np.einsum("cijkl,k->cij", table, by_theta).max())
    told = f"reflecting at most {most:.3g} of the light"
    if most <= ALBEDO_MAX:
        return told
    return f"{told}: more than there is" + (", perhaps `values=encoded` is meant" if how == "stored" else "")


def _as_stored(numbers: np.ndarray) -> np.ndarray:
    return numbers


def _decode(numbers: np.ndarray) -> np.ndarray:
    """dj_brdf's reading: sRGB decoded (IEC 61966-2-1), whose linear foot is continued to negative numbers."""
    encoded = numbers / ENCODED_WHITE
    upper = ((np.maximum(encoded, 0.04045) + 0.055) / 1.055) ** 2.4
    return DECODED_WHITE * np.where(encoded > 0.04045, upper, encoded / 12.92)


class _Interpolant:
    """(wi, wo) to the table's value; see `read`."""

    def __init__(self, table: AngularTable, decode: Callable[[np.ndarray], np.ndarray]):
        self.table, self.decode = table, decode

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        coordinates = []
        for direction in (wi, wo):
            x, y, z = direction.T
            coordinates += [np.arctan2(np.hypot(x, y), z) / THETA_STEP, np.arctan2(y, x) / PHI_STEP]
        return self.decode(self.table.interpolate(*coordinates))
