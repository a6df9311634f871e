"""The environments that need no file, each made by a function of one file: `NAME() -> pixels`.

Radiances are chosen so that a grey ball looks right without a change of exposure: a white surface that lies on the
ground under `clear_sky`, `overcast` and `furnace` has the radiance 1.
"""

from __future__ import annotations

from .clear_sky import clear_sky
from .furnace import furnace
from .night import night
from .overcast import overcast
from .studio import studio

BUILT_IN = {"studio": studio, "clear_sky": clear_sky, "overcast": overcast, "night": night, "furnace": furnace}
