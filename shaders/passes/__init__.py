"""The passes of a picture, one file each, in the order in which they run.

Each file has `declare(scene) -> Pass` and `prepare(frame) -> Draw`. `prepare` is called when what the pass reads has
been made, and `Draw` with the number of the jittered frame: once for each, or with 0 if the pass runs once. Resources
are found by `frame.resource` and `frame.picture`, made known by `frame.keep`. A new pass is a file here, its shader in
`glsl/pass/`, and its place in `PASSES`.
"""

from __future__ import annotations

from . import (
    accumulate,
    albedos,
    blurred_sky,
    blurs,
    cool_cube,
    depth,
    dim_cube,
    environment,
    geometry,
    hot_lights,
    light_table,
    materials,
    points,
    resolve,
    round_lobes,
    sky,
    sky_cube,
    sunless,
    sunless_cube,
    surface_interactive,
    surface_still,
    surface_truth,
    tone_map,
)

PASSES = (
    environment,
    blurred_sky,
    light_table,
    sky_cube,
    sunless,
    sunless_cube,
    hot_lights,
    cool_cube,
    dim_cube,
    blurs,
    geometry,
    materials,
    albedos,
    round_lobes,
    depth,
    points,
    surface_interactive,
    surface_still,
    surface_truth,
    sky,
    accumulate,
    resolve,
    tone_map,
)
