"""What is rendered: a sphere of a metal or a dielectric of some roughness under an environment."""

from __future__ import annotations

import dataclasses

from brdf.model import AbstractBRDF
from brdf.registry import MODELS, combine

from ..environment import Environment
from ..scene import Part, Scene, Tier, Vector

MATERIALS = ("metal", "dielectric")
ROUGHNESS = (0.1, 0.3, 0.6, 1.0)
# Gold-like, and a red paint under a coat of index 1.5.
_GOLD: Vector = (1.0, 0.78, 0.34)
_RED: Vector = (0.5, 0.15, 0.08)
_COAT: Vector = (0.04, 0.04, 0.04)


@dataclasses.dataclass(frozen=True)
class Case:
    """A material under a light.

    - `material`: one of `MATERIALS`: GGX alone, or the plain sum of Lambert and GGX.
    - `roughness`: of GGX; alpha is its square.
    - `environment`: the light.
    """

    material: str
    roughness: float
    environment: Environment

    @property
    def albedo(self) -> Vector:
        """Of the Lambertian lobe; black for the metal."""
        return (0.0, 0.0, 0.0) if self.material == "metal" else _RED

    @property
    def f0(self) -> Vector:
        return _GOLD if self.material == "metal" else _COAT

    @property
    def model(self) -> AbstractBRDF:
        lobes: dict[str, AbstractBRDF] = {} if self.material == "metal" else {"lambert": MODELS["lambert"](self.albedo)}
        return combine(lobes | {"ggx": MODELS["ggx"](f0=self.f0, alpha=self.roughness**2)})

    def scene(self, tier: Tier, size: int) -> Scene:
        """A square picture of `size` pixels a side with the sky behind, tone-mapped."""
        return Scene((Part(self.model),), self.environment, width=size, height=size, tier=tier)
