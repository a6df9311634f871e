"""`.npz` slices: colours over difference and half angle at phi_d = 90 degrees.

Each member of the file is one material, [theta_d][theta_h][3] in 1/sr, linear Rec. 709, without the
cosine. Row i of n stands for theta_d = i / n x 90 degrees, column j of m for theta_h =
(j / m)^2 x 90 degrees: the lower edges of MERL's cells. `file.npz:name` selects the member.

A slice at phi_d = 90 degrees has both directions at the same height, so that no cell lies below the
horizon. It says nothing about how the reflectance depends on phi_d: `evaluate` takes it to be the
same everywhere (a bivariate BRDF, in theta_h and theta_d).
"""

from __future__ import annotations

import contextlib
import difflib
import os
import zipfile
from collections.abc import Iterator

import numpy as np

from brdf.errors import FileError
from fitter.formats._angular_table import AngularTable
from fitter.reflectance import HORIZON_COSINE, Grid, Reflectance
from fitter.rusinkiewicz import directions, half_difference

NAME = "npz slices"
DESCRIPTION = "phi_d = 90 degree slices [theta_d][theta_h][RGB], one member per material"
SUFFIXES = (".npz",)
OPTIONS: dict[str, tuple[str, ...]] = {"member": ()}

SHOWN_MEMBERS = 8


def sniff(head: bytes) -> bool:
    """Whether the file is a zip archive."""
    return head.startswith(b"PK\x03\x04")


def members(path: str | os.PathLike[str]) -> list[str]:
    """The names of the materials in a file.

    **Raises:** `FileError` if it is no npz.
    """
    with _open(path) as archive:
        return list(archive.files)


def read(path: str | os.PathLike[str], member: str | None = None) -> Reflectance:
    """Reads one slice.

    **Arguments:**

    - `path`: the file.
    - `member`: the material; may be left out if the file holds only one.

    **Returns:** one sample per cell that is finite and has no negative channel, with `grid` over
    `theta_d`, `theta_h`. `evaluate` is bilinear in the cells' coordinates (the square root of
    theta_h), constant beyond the first and last cell, and does not depend on phi_d; invalid cells
    are left out and the other weights scaled up.

    **Raises:** `FileError` if the file is no npz, the member is missing or not of that shape, or no
    cell is valid.
    """
    with _open(path) as archive:
        member = _choose(path, archive.files, member)
        try:
            values = archive[member]
        except (ValueError, OSError, EOFError, zipfile.BadZipFile, MemoryError) as error:
            raise FileError(
                path,
                f"member `{member}` cannot be read ({_first_line(error)}).",
                "Save it as a plain array of floats: numpy.savez(path, name=array).",
            ) from error
    number = isinstance(values, np.ndarray) and values.dtype.kind in "fiu"
    if not number or values.ndim != 3 or values.shape[2] != 3 or values.size == 0:
        raise FileError(
            path,
            f"member `{member}` is {getattr(values, 'dtype', 'not an array')} of the shape "
            f"{getattr(values, 'shape', ())}.",
            "A slice is [theta_d][theta_h][3], floats in 1/sr.",
        )
    return _slice(path, member, values.astype(np.float64))


def _slice(path: str | os.PathLike[str], member: str, values: np.ndarray) -> Reflectance:
    rows, columns = values.shape[:2]
    theta_d = np.arange(rows) / rows * (np.pi / 2)
    theta_h = (np.arange(columns) / columns) ** 2 * (np.pi / 2)
    finite = np.isfinite(values).all(2)
    valid = (values >= 0).all(2)
    above = np.cos(theta_d)[:, None] * np.cos(theta_h) > HORIZON_COSINE
    dropped = {
        "below horizon": int(np.count_nonzero(~above)),
        "not finite": int(np.count_nonzero(above & ~finite)),
        "marked invalid": int(np.count_nonzero(above & finite & ~valid)),
    }
    i, j = np.nonzero(above & finite & valid)
    if not len(i):
        raise FileError(
            path,
            f"member `{member}` has no valid cell: of {values[..., 0].size} {dropped['not finite']} "
            f"are not finite and {dropped['marked invalid']} negative.",
            "Export it again.",
        )
    wi, wo = directions(theta_h[j], theta_d[i], np.full(len(i), np.pi / 2))
    value = values[i, j]
    values[~(finite & valid)] = np.nan
    return Reflectance(
        wi=wi,
        wo=wo,
        value=value,
        source=f"{os.path.basename(path)}:{member} ({NAME}, phi_d = 90 degrees)",
        format=NAME,
        dropped={reason: count for reason, count in dropped.items() if count},
        grid=Grid({"theta_d": theta_d, "theta_h": theta_h}, i * columns + j),
        interpolant=_Interpolant(
            AngularTable(np.moveaxis(values, 2, 0), (False, False)),
        ),
    )


class _Interpolant:
    """(wi, wo) to the slice's value; see `read`."""

    def __init__(self, table: AngularTable):
        self.table = table

    def __call__(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        angles = half_difference(wi, wo)
        rows, columns = self.table.size
        return self.table.interpolate(
            angles.theta_d / (np.pi / 2) * rows, np.sqrt(angles.theta_h / (np.pi / 2)) * columns
        )


@contextlib.contextmanager
def _open(path: str | os.PathLike[str]) -> Iterator[np.lib.npyio.NpzFile]:
    """The archive, closed afterwards: numpy itself leaves a damaged file open."""
    with open(path, "rb") as file:
        try:
            archive = np.load(file, allow_pickle=False)
        except (ValueError, EOFError, zipfile.BadZipFile) as error:
            raise FileError(
                path,
                f"is no npz archive ({_first_line(error)}).",
                "It is damaged or truncated: export it again.",
            ) from error
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise FileError(
                path,
                "holds one bare array, not an npz archive.",
                "Save it with numpy.savez(path, name=array).",
            )
        with archive:
            yield archive


def _choose(path: str | os.PathLike[str], names: list[str], member: str | None) -> str:
    if not names:
        raise FileError(path, "holds no member.", "Save at least one array in it.")
    if member is None:
        if len(names) == 1:
            return names[0]
        more = f" and {len(names) - SHOWN_MEMBERS} more" if len(names) > SHOWN_MEMBERS else ""
        raise FileError(
            path,
            f"holds {len(names)} materials: {', '.join(names[:SHOWN_MEMBERS])}{more}.",
            f"Name one: `{os.path.basename(path)}:{names[0]}`.",
        )
    if member not in names:
        near = difflib.get_close_matches(member, names, n=3, cutoff=0.5) or names[:SHOWN_MEMBERS]
        raise FileError(
            path,
            f"has no member `{member}`.",
            f"The nearest of its {len(names)} are {', '.join(f'`{name}`' for name in near)}.",
        )
    return member


def _first_line(error: BaseException) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
