"""Half and difference angles."""

from __future__ import annotations

import numpy as np
import pytest

from fitter.rusinkiewicz import directions, half_difference


def random_pairs(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    pairs = np.random.default_rng(seed).normal(size=(2, count, 3))
    pairs[..., 2] = np.abs(pairs[..., 2])
    pairs /= np.linalg.norm(pairs, axis=-1, keepdims=True)
    return pairs[0], pairs[1]


def test_directions_come_back_through_the_angles():
    # Oracle: the round trip. 1e-14: some ten roundings of numbers up to 1.
    wi, wo = random_pairs(10_000, 0)
    angles = half_difference(wi, wo)
    back = directions(angles.theta_h, angles.theta_d, angles.phi_d, angles.phi_h)
    np.testing.assert_allclose(back[0], wi, atol=1e-14)
    np.testing.assert_allclose(back[1], wo, atol=1e-14)


def test_angles_come_back_through_the_directions_down_to_tiny_ones():
    # Oracle: the round trip, with half and difference angles down to 1e-7, where an arc cosine
    # would return 0 or 2e-8. A direction's rounding of 1e-16 is 1e-9 of such an angle.
    tiny = np.array([1e-7, 1e-5, 1e-3, 0.3, 1.0])
    theta_h, theta_d = (grid.ravel() for grid in np.meshgrid(tiny, tiny))
    phi_d, phi_h = np.full(theta_h.size, 2.0), np.full(theta_h.size, -1.0)
    angles = half_difference(*directions(theta_h, theta_d, phi_d, phi_h))
    np.testing.assert_allclose(angles.theta_h, theta_h, rtol=2e-9)
    np.testing.assert_allclose(angles.theta_d, theta_d, rtol=2e-9)
    # The azimuth about h needs both angles: it is as uncertain as the smaller one.
    np.testing.assert_allclose(angles.phi_h, phi_h, atol=4e-9)
    np.testing.assert_allclose(angles.phi_d, phi_d, atol=8e-9)


def test_angles_agree_with_fifty_digit_arithmetic():
    # Oracle: the definition of Rusinkiewicz 1998 by two rotations, in mpmath with 50 digits.
    mpmath = pytest.importorskip("mpmath")
    wi, wo = random_pairs(40, 1)
    angles = half_difference(wi, wo)
    with mpmath.workdps(50):
        for row in range(len(wi)):
            a, b = ([mpmath.mpf(float(x)) for x in v[row]] for v in (wi, wo))
            a, b = ([x / mpmath.norm(v) for x in v] for v in (a, b))
            h = [x + y for x, y in zip(a, b, strict=True)]
            h = [x / mpmath.norm(h) for x in h]
            theta_h, phi_h = mpmath.acos(h[2]), mpmath.atan2(h[1], h[0])
            x = a[0] * mpmath.cos(phi_h) + a[1] * mpmath.sin(phi_h)
            y = a[1] * mpmath.cos(phi_h) - a[0] * mpmath.sin(phi_h)
            across = x * mpmath.cos(theta_h) - a[2] * mpmath.sin(theta_h)
            along = x * mpmath.sin(theta_h) + a[2] * mpmath.cos(theta_h)
            expected = [theta_h, phi_h, mpmath.acos(along), mpmath.atan2(y, across)]
            found = [float(angle[row]) for angle in angles]
            np.testing.assert_allclose(found, [float(x) for x in expected], atol=4e-15)


def test_exchanging_the_directions_adds_pi_to_phi_d():
    # Oracle: a law (Rusinkiewicz 1998): reciprocity is phi_d -> phi_d + pi.
    wi, wo = random_pairs(1000, 2)
    forth, back = half_difference(wi, wo), half_difference(wo, wi)
    turn = (forth.phi_d - back.phi_d) / np.pi
    np.testing.assert_allclose(np.abs(turn), 1.0, atol=1e-12)
    np.testing.assert_array_equal(forth.theta_h, back.theta_h)
    np.testing.assert_array_equal(forth.theta_d, back.theta_d)


def test_poles_use_the_gauge_without_azimuth():
    # Oracle: the documented gauge; the signs of zeros must not turn it by pi.
    wi = np.array([[0.6, 0.0, 0.8], [-0.0, -0.0, 1.0], [0.0, 0.6, 0.8]])
    wo = np.array([[-0.6, -0.0, 0.8], [-0.0, -0.0, 1.0], [0.0, 0.6, 0.8]])
    angles = half_difference(wi, wo)
    np.testing.assert_array_equal(angles.theta_h[:2], 0.0)
    np.testing.assert_array_equal(angles.phi_h[:2], 0.0)
    np.testing.assert_array_equal(angles.phi_d, 0.0)
    np.testing.assert_array_equal(angles.theta_d[1:], 0.0)


def test_angles_of_a_single_grid_broadcast():
    # Oracle: unit length of what comes back.
    wi, wo = directions(0.3, np.array([0.1, 0.2]), np.array([1.0, 2.0]))
    assert wi.shape == wo.shape == (2, 3)
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1.0, rtol=1e-15)
