"""Lambert's ideal diffuse reflector: the same radiance in every direction.

    f = albedo / pi

- Lambert 1760, "Photometria".
"""

from __future__ import annotations

import jax.numpy as jnp

from ..frame import Color, Geometry, Scalar
from ..model import AbstractBRDF
from ..parameter import color
from ..sampling import Proposals


class Lambert(AbstractBRDF):
    """Ideal diffuse reflection."""

    albedo: Color = color(0.0, 1.0, 0.5, "fraction of the light that is reflected")

    def reflect(self, g: Geometry) -> Color:
        return self.albedo / jnp.pi + 0 * g.cos_i

    def proposals(self, cos_o: Scalar) -> Proposals:
        return Proposals(jnp.mean(self.albedo), ())
