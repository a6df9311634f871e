"""Directions in, values out: the `.npz` files of `brdf evaluate`."""

from __future__ import annotations

import pathlib
import zipfile

import numpy as np

from brdf.atomic import atomic_path
from brdf.errors import FileError

from .reflectance import unit_directions


def load_directions(path: str) -> tuple[np.ndarray, np.ndarray]:
    """Reads `wi` and `wo` from an `.npz`.

    **Returns:** two arrays (n, 3), float64, unit, local frame with normal +z, `wi` to the light.

    **Raises:** `FileError` if the file cannot be read or lacks `wi` or `wo`, or they are not (n, 3), finite and unit.
    """
    remedy = "Write it with numpy.savez(path, wi=wi, wo=wo), both (n, 3) and unit, local frame, normal +z."
    if not pathlib.Path(path).is_file():
        raise FileError(path, "is not a file.", remedy)
    try:
        with np.load(path, allow_pickle=False) as file:
            if not isinstance(file, np.lib.npyio.NpzFile):
                raise FileError(path, "is a single array, not an .npz.", remedy)
            missing = [name for name in ("wi", "wo") if name not in file.files]
            if missing:
                raise FileError(path, f"lacks `{missing[0]}`; it holds {', '.join(file.files) or 'nothing'}.", remedy)
            wi, wo = file["wi"], file["wo"]
    except (ValueError, EOFError, zipfile.BadZipFile, OSError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(path, "is not a readable .npz of plain arrays.", remedy) from None
    try:
        wi, wo = unit_directions(wi, "wi"), unit_directions(wo, "wo")
    except (ValueError, TypeError) as error:
        raise FileError(path, str(error), "") from None
    if len(wi) != len(wo):
        raise FileError(path, f"`wi` has {len(wi)} rows and `wo` {len(wo)}.", "Give as many of one as of the other.")
    return wi, wo


def save_values(path: str, wi: np.ndarray, wo: np.ndarray, value: np.ndarray, force: bool) -> None:
    """Writes `wi`, `wo` and `value`, (n, 3) each, `value` in 1/sr without the cosine, to an `.npz`."""
    with atomic_path(path, force) as temporary:
        np.savez(temporary, wi=wi, wo=wo, value=value)
