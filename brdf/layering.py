"""A dielectric boundary above something else: what it reflects in all, and what it lets through.

Light that the boundary does not reflect reaches the layer below: "albedo scaling", `f = f_top + (1 - E_top) f_below`.
The reflectance is exact, not Schlick's, and is a function of its value at normal incidence `f0`, in which it is smooth
down to 0, where index and slope of its root are not.

- Cook, Torrance 1982, "A Reflectance Model for Computer Graphics": the dielectric.
- OpenPBR Surface 1.1, "Layering" and "Coat".

The fits of this file are rational least-squares fits to a quadrature over visible normals (200 x 200 nodes, float64),
for GGX with Smith's height-correlated masking, made for this project. The twin of this file is
`shaders/glsl/layering.glsl`.
"""

from __future__ import annotations

import jax.numpy as jnp

from .frame import Scalar

# Below it only the strength of a boundary falls on, not its shape, whose rise at grazing angles would grow without
# bounds: 1e-8 stands for an index of 1.0002.
_F0_SHAPE_MIN = 1e-8


def f0_of_ior(ior: Scalar) -> Scalar:
    """Reflectance of a boundary at normal incidence."""
    return jnp.square((ior - 1) / (ior + 1))


def f_dielectric_f0(f0: Scalar, cos_d: Scalar) -> Scalar:
    """Unpolarised reflectance of a smooth dielectric in a rarer medium; f0 in [0, 1)."""
    root = jnp.sqrt(jnp.maximum(f0, _F0_SHAPE_MIN))
    # ior^2 - 1 = 4 root / (1 - root)^2, and its square holds f0 itself.
    scale = 4 / ((1 - root) * (1 - root))
    excess = root * scale
    c2 = cos_d * cos_d
    refracted = jnp.sqrt(c2 + excess)
    s, p = cos_d + refracted, cos_d + excess * cos_d + refracted
    perpendicular = scale / (s * s)
    parallel = scale * ((2 + excess) * c2 - 1) / (p * p)
    return 0.5 * f0 * (perpendicular * perpendicular + parallel * parallel)


def t_dielectric_f0(f0: Scalar, cos_d: Scalar) -> Scalar:
    """`1 - f_dielectric_f0`, to all its digits where it vanishes."""
    f0_shape = jnp.maximum(f0, _F0_SHAPE_MIN)
    root = jnp.sqrt(f0_shape)
    excess = 4 * root / ((1 - root) * (1 - root))
    refracted = jnp.sqrt(cos_d * cos_d + excess)
    dense = cos_d + excess * cos_d
    s, p = cos_d + refracted, dense + refracted
    t = 2 * ((cos_d / s) * (refracted / s) + (dense / p) * (refracted / p))
    strength = f0 / f0_shape
    return (1 - strength) + strength * t


def mean_dielectric(ior: Scalar) -> Scalar:
    """The cosine-weighted mean of a dielectric's reflectance over the hemisphere: fit for ior in [1, 3], off by 3.5e-4
    at most."""
    x = ior - 1
    return jnp.divide(x * (0.33969125 + x * 1.44759214), 1 + x * (9.04827686 + x * 1.07453747))


def facet_loss(cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """What mirror facets of GGX lose by single scattering: fit for alpha in (0, 1], off by 0.016 at most."""
    x, y = cos_theta, alpha
    top = 0.186667 + y * (0.1372121 + y * 2.4538996) + x * (-0.1590233 + y * 0.7685502 + x * 0.0084945)
    bottom = y * y * (1 + y * -0.3120841)
    bottom = bottom + x * (y * (-0.3264945 + y * 4.9731301) + x * (0.9555886 + y * -2.0209391 + x * 0.5346649))
    return x * y * top / bottom


def _mean_cosine(cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """The cosine at which a smooth boundary reflects the share that a rough one does: fit for alpha in (0, 1]."""
    x, y = cos_theta, alpha
    top = 3.475141 + y * (18.3377032 + y * -10.1241678) + x * (-9.1174667 + y * -6.8121414 + x * 0.509954)
    bottom = y * (1 + y * 23.9834816) + x * (2.9893433 + y * 15.2565615 + x * 21.4730263)
    return jnp.minimum(x + y * (x + y) * top / bottom, 1)


def dielectric_albedo(f0: Scalar, cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """The share of light that a boundary of GGX facets reflects.

    The two fits together are off by 0.019 at most from cosines of 0.1 on, for indices up to 3; by 0.04 below, and by
    up to 0.2 where the index is below 1.1 as well.
    """
    return (1 - facet_loss(cos_theta, alpha)) * f_dielectric_f0(f0, _mean_cosine(cos_theta, alpha))


def dielectric_transmission(f0: Scalar, cos_theta: Scalar, alpha: Scalar) -> Scalar:
    """`1 - dielectric_albedo`, the share that reaches the layer below, to all its digits where it vanishes."""
    loss = facet_loss(cos_theta, alpha)
    reflected = f_dielectric_f0(f0, _mean_cosine(cos_theta, alpha))
    return loss * reflected + t_dielectric_f0(f0, _mean_cosine(cos_theta, alpha))
