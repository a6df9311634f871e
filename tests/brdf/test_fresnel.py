"""Fresnel reflectance against the complex formulas, and the named limits of its approximations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from brdf.fresnel import (
    f_conductor,
    f_dielectric,
    f_schlick,
    f_schlick_f82,
    f_schlick_f90,
    f_spherical_gaussian,
)


def exact(index, cosine):
    """Unpolarised reflectance of a smooth interface of complex index, by Snell's law in complex numbers."""
    inside = np.sqrt(1 - (1 - cosine**2) / index**2)
    senkrecht = (cosine - index * inside) / (cosine + index * inside)
    parallel = (index * cosine - inside) / (index * cosine + inside)
    return 0.5 * (np.abs(senkrecht) ** 2 + np.abs(parallel) ** 2)


def test_a_conductor_equals_the_complex_formula():
    rng = np.random.default_rng(41)
    eta, k = rng.uniform(0.05, 6, (2000, 3)), rng.uniform(0.01, 12, (2000, 3))
    cosine = np.concatenate([10 ** rng.uniform(-7, 0, 1000), rng.uniform(0, 1, 1000)])
    value = jax.jit(jax.vmap(f_conductor))(eta, k, cosine, 1 - cosine)
    np.testing.assert_allclose(value, exact(eta + 1j * k, cosine[:, None]), rtol=1e-12)


def test_a_dielectric_equals_the_complex_formula():
    rng = np.random.default_rng(42)
    ior, cosine = rng.uniform(1.01, 4, 2000), 10 ** rng.uniform(-7, 0, 2000)
    np.testing.assert_allclose(jax.jit(jax.vmap(f_dielectric))(ior, cosine), exact(ior, cosine), rtol=1e-11)


def test_an_index_of_one_reflects_nothing():
    assert float(f_dielectric(jnp.asarray(1.0), jnp.asarray(1e-7))) == 0


def test_named_points_of_the_approximations():
    # Oracle: the definitions at normal incidence, at 82 degrees and at grazing.
    f0, f90, f82 = np.array([0.04, 0.5, 0.9]), np.array([0.3, 0.8, 1.0]), np.array([0.2, 0.7, 1.0])
    zero, one = jnp.asarray(0.0), jnp.asarray(1.0)
    np.testing.assert_allclose(f_schlick(f0, zero), f0)
    np.testing.assert_allclose(f_schlick(f0, one), 1)
    np.testing.assert_allclose(f_schlick_f90(f0, f90, one, zero), f0)
    np.testing.assert_allclose(f_schlick_f90(f0, f90, zero, one), f90)
    at_82 = jnp.asarray(6 / 7)
    np.testing.assert_allclose(
        f_schlick_f82(f0, f82, jnp.asarray(1 / 7), at_82), f82 * f_schlick(f0, at_82), rtol=1e-14
    )
    np.testing.assert_allclose(
        f_schlick_f82(f0, np.ones(3), jnp.asarray(0.4), jnp.asarray(0.6)), f_schlick(f0, jnp.asarray(0.6))
    )


def test_the_spherical_gaussian_stays_near_schlick():
    # Oracle: Karis 2013 offers it as a replacement; at f0 = 0 the two differ by at most 0.0038.
    for cosine in np.linspace(0, 1, 21):
        difference = f_spherical_gaussian(np.zeros(3), jnp.asarray(cosine)) - f_schlick(
            np.zeros(3), jnp.asarray(1 - cosine)
        )
        assert np.max(np.abs(np.asarray(difference))) == pytest.approx(0, abs=3.8e-3)
