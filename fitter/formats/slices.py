"""`.npz` slices: colours over difference and half angle at phi_d = 90 degrees.

Each member of the file is one material, [theta_d][theta_h][3] in 1/sr, linear Rec. 709, without the
cosine. Row i of n stands for theta_d = i / n x 90 degrees, column j of m for theta_h =
(j / m)^2 x 90 degrees: the lower edges of MERL's cells. `file.npz:name` selects the member.
"""

from __future__ import annotations

import contextlib
import difflib
import os
import zipfile
from collections.abc import Iterator

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError, UserError
from fitter.formats._slice import slice_measurement
from fitter.reflectance import Grid, Reflectance

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

    **Returns:** as `_slice.slice_measurement` says.

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
    return slice_measurement(
        path,
        values.astype(np.float64),
        what=f"member `{member}` ",
        source=f"{os.path.basename(path)}:{member} ({NAME}, phi_d = 90 degrees)",
        format=NAME,
    )


def write(reflectance: Reflectance, path: str | os.PathLike[str], force: bool = False) -> None:
    """Writes a slice at phi_d = 90 degrees as the member `slice`; cells without a sample become NaN.

    **Raises:** `UserError` if the measurement is no such slice; `FileError` if the file cannot be written.
    """
    grid = reflectance.grid
    if grid is None or not _is_slice(grid):
        raise UserError(f"`{reflectance.source}` is not a slice at phi_d = 90 degrees. Write a `.csv`.")
    with atomic_path(path, force) as temporary, open(temporary, "wb") as file:
        np.savez(file, slice=grid.scatter(reflectance.value))


def _is_slice(grid: Grid) -> bool:
    if tuple(grid.axes) != ("theta_d", "theta_h"):
        return False
    return all(
        np.allclose(axis, (np.arange(len(axis)) / len(axis)) ** power * (np.pi / 2))
        for axis, power in zip(grid.axes.values(), (1, 2), strict=True)
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
