"""The layered models as their specifications write them, in normalised vectors and plain NumPy, for tests to compare.

Directions are arrays of shape (n, 3): `wi`, `wo` and their normalised half vector `h`.
"""

import jax
import jax.numpy as jnp
import numpy as np

from brdf.layering import dielectric_albedo, mean_dielectric
from brdf.sheen import charlie_albedo


def tangents(rotation):
    return np.array([np.cos(rotation), np.sin(rotation), 0]), np.array([-np.sin(rotation), np.cos(rotation), 0])


def plain_ggx(wi, wo, h, alpha_x, alpha_y, rotation):
    """D G / (4 cos cos) as textbooks write it, with Heitz' height-correlated Smith masking."""
    x, y = tangents(rotation)
    d = 1 / (np.pi * alpha_x * alpha_y * ((h @ x / alpha_x) ** 2 + (h @ y / alpha_y) ** 2 + h[:, 2] ** 2) ** 2)
    smith = [
        0.5 * (np.sqrt(1 + ((alpha_x * (w @ x)) ** 2 + (alpha_y * (w @ y)) ** 2) / w[:, 2] ** 2) - 1) for w in (wi, wo)
    ]
    return d / (1 + smith[0] + smith[1]) / (4 * wi[:, 2] * wo[:, 2])


def plain_fresnel(ior, cosine):
    g = np.sqrt(ior**2 - 1 + cosine**2)
    s, p = (cosine - g) / (cosine + g), (ior**2 * cosine - g) / (ior**2 * cosine + g)
    return 0.5 * (s * s + p * p)


def plain_schlick(f0, cosine):
    return f0 + (1 - f0) * (1 - cosine)[:, None] ** 5


def plain_eon(wi, wo, rho, r):
    """Portsmouth 2025, listing 1, with the exact albedo."""
    s = np.sum(wi * wo, axis=1) - wi[:, 2] * wo[:, 2]
    t = np.where(s > 0, np.maximum(wi[:, 2], wo[:, 2]), 1)
    a = 1 / (1 + (0.5 - 2 / (3 * np.pi)) * r)
    mean = a * (1 + (2 / 3 - 28 / (15 * np.pi)) * r)

    def single(w):
        theta, sine = np.arccos(w[:, 2]), np.sqrt(1 - w[:, 2] ** 2)
        return a * (1 + r / np.pi * (sine * (theta - sine * w[:, 2]) + 2 / 3 * (sine / w[:, 2] * (1 - sine**3) - sine)))

    if r == 0:
        return rho / np.pi * np.ones_like(wi)
    ms = rho**2 * mean / (1 - rho * (1 - mean))
    lost = (1 - single(wi)) * (1 - single(wo)) / (1 - mean)
    return (rho * (a * (1 + r * s / t))[:, None] + ms * lost[:, None]) / np.pi


def plain_charlie(wi, wo, h, roughness):
    alpha = roughness**2
    d = (2 + 1 / alpha) * (1 - h[:, 2] ** 2) ** (0.5 / alpha) / (2 * np.pi)
    t = (1 - alpha) ** 2

    def mix(at_1, at_0):
        return at_1 * (1 - t) + at_0 * t

    def curve(x):
        a, b, c = mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801)
        return a / (1 + b * x**c) + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)

    def smith(x):
        return np.where(x < 0.5, np.exp(curve(np.minimum(x, 0.5))), np.exp(2 * curve(0.5) - curve(1 - x)))

    return d / ((1 + smith(wi[:, 2]) + smith(wo[:, 2])) * 4 * wi[:, 2] * wo[:, 2])


def plain_gltf(m, wi, wo, h):
    """The fragments of code in appendix B and in the extensions, in normalised vectors."""
    cos_d = np.sum(wi * h, axis=1)
    alpha = m.roughness**2
    at, ab = alpha * (1 - m.anisotropy_strength**2) + m.anisotropy_strength**2, alpha
    layer = plain_ggx(wi, wo, h, at, ab, m.anisotropy_rotation)[:, None]
    f0 = np.minimum(((1 - m.ior) / (1 + m.ior)) ** 2 * m.specular_color, 1) * m.specular
    fr = f0 + (m.specular - f0) * (1 - cos_d)[:, None] ** 5
    dielectric = (1 - fr.max(axis=1, keepdims=True)) * m.base_color / np.pi + fr * layer
    metal = plain_schlick(m.base_color, cos_d) * layer
    material = dielectric * (1 - m.metallic) + metal * m.metallic
    hidden = [np.asarray(jax.vmap(charlie_albedo, (0, None))(w[:, 2], m.sheen_roughness)) for w in (wi, wo)]
    scaling = np.minimum(1 - m.sheen_color.max() * hidden[0], 1 - m.sheen_color.max() * hidden[1])
    material = m.sheen_color * plain_charlie(wi, wo, h, m.sheen_roughness)[:, None] + material * scaling[:, None]
    coat = plain_ggx(wi, wo, h, m.clearcoat_roughness**2, m.clearcoat_roughness**2, 0)
    weight = m.clearcoat * (0.04 + (1 - 0.04) * (1 - wo[:, 2]) ** 5)
    return material * (1 - weight)[:, None] + (coat * weight)[:, None]


def plain_openpbr(m, wi, wo, h):
    """The equations of the specification in normalised vectors; the albedos, which it leaves open, are ours."""
    cos_d, cos_i, cos_o = np.sum(wi * h, axis=1), wi[:, 2], wo[:, 2]

    def passed(ior, alpha):
        f0 = ((ior - 1) / (ior + 1)) ** 2
        found = jax.vmap(dielectric_albedo, (None, 0, 0))(jnp.asarray(f0), cos_o, alpha * np.ones_like(cos_o))
        return 1 - np.asarray(found)

    ratio = m.specular_ior / m.coat_ior
    eta = m.specular_ior * (1 - m.coat_weight) + (ratio if ratio > 1 else 1 / ratio) * m.coat_weight
    f_s = ((eta - 1) / (eta + 1)) ** 2
    epsilon = np.sqrt(m.specular_weight * f_s)
    eta = (1 + epsilon) / (1 - epsilon)
    r, a = m.specular_roughness, m.specular_roughness_anisotropy
    r_below = r * (1 - m.coat_weight) + min(1, r**4 + 2 * m.coat_roughness**4) ** 0.25 * m.coat_weight
    alpha_t = r_below**2 * np.sqrt(2 / (1 + (1 - a) ** 2))
    alpha_b = (1 - a) * alpha_t
    lobe = plain_ggx(wi, wo, h, alpha_t, alpha_b, m.rotation)[:, None]

    rho = m.base_weight * m.base_color
    at_82 = plain_schlick(rho, np.array([1 / 7]))
    dip = (cos_d * (1 - cos_d) ** 6 / (1 / 7 * (6 / 7) ** 6))[:, None] * at_82 * (1 - m.specular_color)
    metal = m.specular_weight * np.maximum(plain_schlick(rho, cos_d) - dip, 0) * lobe
    x, y = tangents(m.rotation)
    viewed = (alpha_t * (wo @ x)) ** 2 + (alpha_b * (wo @ y)) ** 2 + r_below**4 * cos_o**2
    diffuse = plain_eon(wi, wo, rho, m.base_diffuse_roughness)
    diffuse = diffuse * passed(eta, np.sqrt(np.minimum(viewed, 1)))[:, None]
    dielectric = m.specular_color * plain_fresnel(eta, cos_d)[:, None] * lobe + diffuse
    base = dielectric * (1 - m.base_metalness) + metal * m.base_metalness

    coat = plain_ggx(wi, wo, h, m.coat_roughness**2, m.coat_roughness**2, 0) * plain_fresnel(m.coat_ior, cos_d)
    path = np.sum([1 / np.sqrt(1 - (1 - c**2) / m.coat_ior**2) for c in (cos_i, cos_o)], axis=0)
    transmitted = np.sqrt(m.coat_color) ** path[:, None]
    k_r = 1 - (1 - float(mean_dielectric(jnp.asarray(m.coat_ior)))) / m.coat_ior**2
    xi_f = m.specular_weight * f_s
    r_base = (1 * (1 - xi_f) + r * xi_f) * (1 - m.base_metalness) + r * m.base_metalness
    k = (plain_fresnel(m.coat_ior, cos_o) * (1 - r_base) + k_r * r_base)[:, None]
    e_dielectric = m.specular_color * xi_f + (1 - xi_f) * rho
    e_base = e_dielectric * (1 - m.base_metalness) + m.specular_weight * rho * m.base_metalness
    delta = (1 - k) / (1 - e_base * k)
    darkened = base * (1 + (delta - 1) * m.coat_weight * m.coat_darkening)
    below = 1 + (transmitted * passed(m.coat_ior, m.coat_roughness**2)[:, None] - 1) * m.coat_weight
    coated = m.coat_weight * coat[:, None] + below * darkened

    lobe, e_fuzz = plain_fuzz(wi, wo, m.fuzz_roughness)
    return m.fuzz_weight * m.fuzz_color * lobe[:, None] + (1 - m.fuzz_weight * e_fuzz)[:, None] * coated


def plain_fuzz(wi, wo, y):
    """Zeltner's lobe in the viewer's frame, and its albedo, by MaterialX's fits."""
    x = wo[:, 2]
    s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
    o = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
    e = np.maximum(np.exp(-0.5 * ((x - m) / s) ** 2) / (s * np.sqrt(2 * np.pi)) + o, 0)
    a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y)
    b = np.sqrt(1 - x) * (y - 1) * y**3 / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
    axis = wo[:, :2] / np.linalg.norm(wo[:, :2], axis=1, keepdims=True)
    along = np.sum(wi[:, :2] * axis, axis=1)
    across = wi[:, 1] * axis[:, 0] - wi[:, 0] * axis[:, 1]
    w = np.stack([a * along + b * wi[:, 2], a * across, wi[:, 2]], axis=-1)
    return e * a**2 / np.sum(w * w, axis=1) ** 2 / np.pi, e
