"""What the renderer needs to know of a material: its GLSL text and the bytes that the text reads."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from brdf.model import AbstractBRDF


@dataclasses.dataclass(frozen=True)
class Twin:
    """A material as shaders see it; a model's is made by `material_block.twin`.

    - `text`: what a shader includes as `"material"`: the uniform block, `vec3 lobes(Geometry g)`, `vec3 brdf(vec3 wi,
      vec3 wo)` and the proposals, see `material_block.glsl`.
    - `block`: the uniform block's bytes, std140.
    - `proposals`: the number of specular lobes that it proposes to sample.
    - `buffers`: storage buffers that the text reads, from binding `FIRST_BUFFER` on.
    - `is_anisotropic`: whether its value changes when both directions are turned about the normal.
    """

    text: str
    block: bytes
    proposals: int
    buffers: tuple[bytes, ...] = ()
    is_anisotropic: bool = False


# Bindings of the uniform block and of the first storage buffer; those below that one are for the light. OpenGL 4.3
# promises no more than eight.
BLOCK = 0
FIRST_BUFFER = 4


def twin_of(material: AbstractBRDF | Twin) -> Twin:
    """The twin of a model, or the twin itself."""
    if isinstance(material, Twin):
        return material
    from .material_block import twin  # loads JAX, which takes most of a second

    return twin(material)
