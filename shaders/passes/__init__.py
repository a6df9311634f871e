"""The passes of a picture, one file each, in the order in which they run.

Each file has `declare(scene) -> Pass` and `prepare(frame) -> Draw`, where `Draw` is called with the number of the
jittered frame. A new pass is a file here, its shader in `glsl/pass/`, and its place in `PASSES`.
"""

from __future__ import annotations

from . import accumulate, points, resolve, sky, surface, tone_map

PASSES = (points, surface, sky, accumulate, resolve, tone_map)
