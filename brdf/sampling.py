"""Directions by chance: what a model proposes, and how directions are drawn from it with their densities in 1/sr.

Every model is imitated by a mixture of the cosine and of visible GGX normals, whose tails are heavier than those of the
other distributions: the ratio of value to density stays bounded. The weights are the model's own estimate of how much
light each part reflects.

- Eto, Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", SIGGRAPH Asia technical communications.
- Dupuy, Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".

The twins of this file are `shaders/glsl/proposals.glsl` and `shaders/glsl/sampling.glsl`.
"""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .distributions import alpha_sin2, d_ggx
from .frame import Direction, Geometry, Scalar, turned

# The slopes that the spherical cap's bound allows.
_ALPHA_MIN, _ALPHA_MAX = 1e-4, 1.0


class SpecularLobe(eqx.Module):
    """Visible normals of GGX.

    - `weight`: at least 0, in any unit that the whole mixture shares.
    - `alpha_x`, `alpha_y`: slopes along the axes of a tangent frame, brought into [1e-4, 1] when used.
    - `rotation`: of that frame about the normal, in radians.
    """

    weight: Scalar
    alpha_x: Scalar
    alpha_y: Scalar
    rotation: Scalar


class Proposals(eqx.Module):
    """A mixture of densities.

    - `diffuse`: the weight of the cosine.
    - `specular`: the specular lobes.
    """

    diffuse: Scalar
    specular: tuple[SpecularLobe, ...]


def _total(p: Proposals) -> Scalar:
    total = p.diffuse
    for lobe in p.specular:
        total = total + lobe.weight
    return total


def _slopes(lobe: SpecularLobe) -> tuple[Scalar, Scalar]:
    return jnp.clip(lobe.alpha_x, _ALPHA_MIN, _ALPHA_MAX), jnp.clip(lobe.alpha_y, _ALPHA_MIN, _ALPHA_MAX)


def density(p: Proposals, g: Geometry) -> Scalar:
    """The density of `draw` in 1/sr; that of the cosine where all weights are zero."""
    total = _total(p)
    is_black = total <= 0
    value = jnp.where(is_black, jnp.ones_like(total), p.diffuse) * g.cos_i / jnp.pi
    for lobe in p.specular:
        value = value + lobe.weight * pdf_ggx(turned(g, lobe.rotation), *_slopes(lobe))
    return value / jnp.where(is_black, jnp.ones_like(total), total)


def draw(p: Proposals, wo: Direction, u: Float[Array | np.ndarray, "3"]) -> Direction:
    """A direction to the light from the mixture: `u[0]` chooses the part, `u[1]` and `u[2]` the direction."""
    wi = sample_cosine(u[1:])
    total = _total(p)
    # Nothing is chosen but the cosine where all weights are zero.
    chosen = jnp.where(total > 0, u[0] * total - p.diffuse, -jnp.ones_like(total))
    for lobe in p.specular:
        c, s = jnp.cos(lobe.rotation), jnp.sin(lobe.rotation)
        local = jnp.stack([c * wo[0] + s * wo[1], c * wo[1] - s * wo[0], wo[2]])
        w = sample_ggx(local, *_slopes(lobe), u[1:])
        w = jnp.stack([c * w[0] - s * w[1], c * w[1] + s * w[0], w[2]])
        # The part is this one or a later one.
        wi = jnp.where(chosen >= 0, w, wi)
        chosen = chosen - lobe.weight
    return wi


def sample_cosine(u: Float[Array | np.ndarray, "2"]) -> Direction:
    """Density cos(theta) / pi."""
    radius, phi = jnp.sqrt(u[0]), 2 * jnp.pi * u[1]
    return jnp.stack([radius * jnp.cos(phi), radius * jnp.sin(phi), jnp.sqrt(1 - u[0])])


def cap_bound(wo: Direction, alpha: Scalar) -> Scalar:
    """The scale of the spherical cap's bound (Eto and Tokuyoshi 2023, eq. 5); `alpha` is the smaller slope."""
    a2 = alpha * alpha
    s = 1 + jnp.sqrt(wo[0] * wo[0] + wo[1] * wo[1])
    s2 = s * s
    return (1 - a2) * s2 / (s2 + a2 * wo[2] * wo[2])


def sample_ggx(wo: Direction, alpha_x: Scalar, alpha_y: Scalar, u: Float[Array | np.ndarray, "2"]) -> Direction:
    """A direction that mirrors `wo`, above the horizon, about a visible normal of GGX; it may end below the horizon
    (Eto and Tokuyoshi 2023)."""
    wo_standard = _unit(jnp.stack([alpha_x * wo[0], alpha_y * wo[1], wo[2]]))
    phi = 2 * jnp.pi * u[0]
    bound = cap_bound(wo, jnp.minimum(alpha_x, alpha_y)) * wo_standard[2]
    # In (-bound, 1]: the cap of directions that the standard hemisphere can reflect to.
    z = (1 - u[1]) * (1 + bound) - bound
    sine = jnp.sqrt(jnp.maximum(1 - z * z, 0))
    m_standard = wo_standard + jnp.stack([sine * jnp.cos(phi), sine * jnp.sin(phi), z])
    m = _unit(jnp.stack([alpha_x * m_standard[0], alpha_y * m_standard[1], m_standard[2]]))
    return _unit(2 * (wo @ m) * m - wo)


def pdf_ggx(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """The density of `sample_ggx` (Eto and Tokuyoshi 2023, eq. 8)."""
    t = jnp.sqrt(alpha_sin2(g.wo, alpha_x, alpha_y) + g.cos_o * g.cos_o)
    bound = cap_bound(g.wo, jnp.minimum(alpha_x, alpha_y))
    return d_ggx(g, alpha_x, alpha_y) / (2 * (bound * g.cos_o + t))


def _unit(w: Direction) -> Direction:
    return w / jnp.sqrt(w @ w)
