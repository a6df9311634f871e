"""The GLSL twin of a model on a batch of directions: for parity tests, `brdf evaluate --gpu` and `brdf stress`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from brdf.errors import UserError

from .context import check, device
from .program import programs
from .twin import BLOCK, FIRST_BUFFER, Twin, twin_of

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF

_GROUP = 64  # local_size_x in pass/evaluate.comp
# Pairs per dispatch: 12 MB per buffer, and far below the 65535 groups that OpenGL guarantees.
_CHUNK = 1 << 20


# What pass/evaluate.comp includes as "result".
_VALUE = """#include "material"
vec3 result(vec3 wi, vec3 wo) { return brdf(wi, wo); }
"""
_SAMPLE = """#include "mixture.glsl"
vec3 result(vec3 u, vec3 wo) { return sample_brdf(wo, u); }
"""
_PDF = """#include "mixture.glsl"
vec3 result(vec3 wi, vec3 wo) { return vec3(above_horizon(wi, wo) ? pdf_brdf(geometry(wi, wo)) : 0.0); }
"""


def evaluate(model: AbstractBRDF | Twin, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
    """The values of a model as the preview computes them, in float32 on the GPU.

    **Arguments:**

    - `model`: any registered model or sum, or a `Twin`.
    - `wi`, `wo`: shape (n, 3), unit, to the light and to the viewer, in the local frame with normal +z; n may be 0.

    **Returns:**

    Shape (n, 3), 1/sr, without the cosine, linear Rec. 709; zero below the horizon.

    Raises `UserError` when the shapes are not (n, 3) twice, or when there is no OpenGL 4.3.
    """
    return _run(_VALUE, model, wi, wo)


def sample(model: AbstractBRDF | Twin, wo: ArrayLike, u: ArrayLike) -> NDArray[np.float32]:
    """Directions to the light drawn for a model, see `brdf.AbstractBRDF.sample`; in float32 on the GPU.

    **Arguments:**

    - `wo`: shape (n, 3), unit, to the viewer, above the horizon.
    - `u`: shape (n, 3), uniform in [0, 1).

    **Returns:** shape (n, 3), unit. Raises `UserError` as `evaluate` does.
    """
    return _run(_SAMPLE, model, u, wo)


def pdf(model: AbstractBRDF | Twin, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
    """The density of `sample` in 1/sr, shape (n,); arguments and errors as `evaluate`."""
    return _run(_PDF, model, wi, wo)[:, 0]


def _run(result: str, model: AbstractBRDF | Twin, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
    incident = np.ascontiguousarray(wi, np.float32)
    outgoing = np.ascontiguousarray(wo, np.float32)
    if incident.ndim != 2 or incident.shape[1] != 3 or incident.shape != outgoing.shape:
        raise UserError(f"`wi {incident.shape}, wo {outgoing.shape}` must both be (n, 3). Pass one row per pair.")
    values = np.empty_like(incident)
    if len(incident) == 0:
        return values
    ctx = device().ctx
    material = twin_of(model)
    program = programs().compute("pass/evaluate.comp", {}, {"material": material.text, "result": result})
    chunk = min(len(incident), _CHUNK)
    block = ctx.buffer(material.block)
    own = [ctx.buffer(data) for data in material.buffers]
    buffers = [ctx.buffer(reserve=12 * chunk) for _ in range(3)]
    block.bind_to_uniform_block(BLOCK)
    for binding, buffer in enumerate(buffers):
        buffer.bind_to_storage_buffer(binding)
    for binding, buffer in enumerate(own, FIRST_BUFFER):
        buffer.bind_to_storage_buffer(binding)
    for start in range(0, len(incident), chunk):
        pairs = min(chunk, len(incident) - start)
        buffers[0].write(incident[start : start + pairs])
        buffers[1].write(outgoing[start : start + pairs])
        program["pairs"] = pairs
        program.run(-(-pairs // _GROUP))
        # What a shader writes to a buffer is not seen by a later read without it (OpenGL 4.3, glMemoryBarrier).
        ctx.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)
        check(ctx, "evaluating a model")
        values[start : start + pairs] = np.frombuffer(buffers[2].read(12 * pairs), np.float32).reshape(-1, 3)
    return values
