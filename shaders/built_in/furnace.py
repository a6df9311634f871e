"""Light of radiance 1 from everywhere: what reflects all light disappears in it."""

from __future__ import annotations

import numpy as np

from .grid import Floats


def furnace(height: int = 16) -> Floats:
    """Ones: shape (height, 2 height, 3), float32. Small, since interpolation changes nothing."""
    return np.ones((height, 2 * height, 3), np.float32)
