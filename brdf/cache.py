"""Where programs and tables are kept between runs."""

from __future__ import annotations

import os
import pathlib


def cache_folder(kind: str) -> pathlib.Path | None:
    """A folder below `BRDF_CACHE_DIR`, or else below the user's cache folder; made if it is not there.

    **Arguments:** `kind`: the folder's name. **Returns:** None if it cannot be written, which is no error: what would
    be kept there is made anew.
    """
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = pathlib.Path(os.environ.get("BRDF_CACHE_DIR") or pathlib.Path(base) / "brdf-fitter") / kind
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
