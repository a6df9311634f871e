"""Quadrature over half vectors, and the picture of a lit sphere."""

from __future__ import annotations

import numpy as np
import pytest

from brdf.integrate import albedo, albedos, evaluate_in_chunks, sphere
from brdf.material import from_dict
from brdf.model import evaluate
from brdf.quadrature import half_vector_rule

THETA = np.radians([0.0, 30.0, 60.0, 80.0, 88.0])
PHI = np.radians([0.0, 20.0, 45.0, 100.0, 300.0])


def material(model: str, **parameters):
    return from_dict({"model": model, "parameters": {model: parameters}}).brdf


@pytest.mark.parametrize("theta", THETA)
@pytest.mark.parametrize("cos_min", [0.0, 0.03])
def test_directions_are_unit_and_fill_the_cap_with_its_solid_angle(theta, cos_min):
    # Oracle: the solid angle and the projected solid angle of a cap.
    other, weight = half_vector_rule(float(theta), cos_min=cos_min)
    np.testing.assert_allclose(np.linalg.norm(other, axis=1), 1, rtol=1e-14)
    assert (other[:, 2] > cos_min).all()
    np.testing.assert_allclose((weight * other[:, 2]).sum(), np.pi * (1 - cos_min**2), rtol=1e-4)
    # Without the cosine the edge counts fully; at grazing incidence the nodes crowd less there.
    np.testing.assert_allclose(weight.sum(), 2 * np.pi * (1 - cos_min), rtol=2e-3)


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 1e-2])
def test_the_albedo_of_a_polished_white_metal_is_one_however_narrow_its_highlight(alpha):
    # Oracle: a mirror reflects all light; up to 60 degrees masking takes a share of the order of alpha squared.
    found = albedos(material("ggx", alpha=alpha, f0=1.0), THETA[:3], PHI[:3])
    np.testing.assert_allclose(found, 1, atol=2e-4 + 6 * alpha**2)


@pytest.mark.parametrize("model", ["ggx", "disney", "oren_nayar", "burley"])
def test_both_rules_give_the_same_albedo_of_a_smooth_lobe(model):
    # Oracle: Gauss-Legendre over the cosine, an independent rule; its error is below 1e-4 at the default slopes.
    brdf = material(model)
    expected = [albedo(brdf, float(theta)) for theta in THETA[:4]]
    np.testing.assert_allclose(albedos(brdf, THETA[:4], np.zeros(4)), expected, rtol=3e-4)


@pytest.mark.parametrize("alpha", [0.003, 0.03, 0.3, 1.0])
def test_the_albedo_has_converged_to_two_in_ten_thousand(alpha):
    # Oracle: three times as many nodes.
    brdf = material("ggx", alpha=alpha, f0=0.5)
    fine = albedos(brdf, THETA, PHI, polar=150, around=200)
    np.testing.assert_allclose(albedos(brdf, THETA, PHI), fine, rtol=2e-4)


def test_the_azimuth_of_the_light_turns_an_anisotropic_lobe():
    # Oracle: turning the lobe instead of the light.
    lobe = {"alpha_x": 0.05, "alpha_y": 0.4, "anisotropy": "anisotropic"}
    straight, turned = material("ggx", **lobe), material("ggx", **lobe, rotation=-0.7)
    there = albedos(straight, THETA[1:4], np.full(3, 0.7))
    np.testing.assert_allclose(there, albedos(turned, THETA[1:4], np.zeros(3)), rtol=1e-9)
    assert abs(there / albedos(straight, THETA[1:4], np.zeros(3)) - 1).max() > 0.01


@pytest.mark.parametrize("count", [1, 5000, 16384, 20000])
def test_chunks_change_no_value(count):
    # Oracle: all pairs at once.
    rng = np.random.default_rng(count)
    w = rng.normal(size=(2, count, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    model = material("ggx", alpha=0.2)
    np.testing.assert_allclose(evaluate_in_chunks(model, w[0], w[1]), evaluate(model, w[0], w[1]), rtol=1e-12)


def test_a_white_matte_sphere_under_uniform_light_shows_that_light_everywhere():
    # Oracle: the white furnace, less the light beyond the limit.
    limit = np.radians(75)
    scene = sphere([((0.0, 1.0, 0.0), np.ones_like)], limit)
    picture = scene.picture(np.full((len(scene.wi), 2), 1 / np.pi))
    assert picture.shape == (32, 64, 2)
    np.testing.assert_allclose(picture, np.sin(limit) ** 2, rtol=1e-4)


@pytest.mark.parametrize("azimuth_deg", [30.0, 200.0])
def test_highlight_and_shading_lie_where_the_light_comes_from(azimuth_deg):
    # Oracle: a mirror shows a light where the normal halves the angle to it; Lambert's cosine law.
    polar, azimuth = np.radians(60), np.radians(azimuth_deg)
    axis = (np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar))
    scene = sphere([(axis, lambda cosine: np.exp(100 * (cosine - 1)))], np.radians(80))
    x, y = scene.radius[:, None] * np.cos(scene.azimuth), scene.radius[:, None] * np.sin(scene.azimuth)
    picture = scene.picture(evaluate_in_chunks(material("ggx", alpha=0.05, f0=1.0), scene.wi, scene.wo))[..., 0]
    weight = np.where(picture > 0.5 * picture.max(), picture, 0)
    expected = np.sin(polar / 2) * np.exp(1j * azimuth)
    # To within a ring or sector.
    assert abs((weight * (x + 1j * y)).sum() / weight.sum() - expected) < 0.03
    matte = scene.picture(np.ones((len(scene.wi), 1)))[..., 0]
    cosine = x * axis[0] + y * axis[1] + np.sqrt(1 - scene.radius[:, None] ** 2) * axis[2]
    # Where the whole light is above the horizon; a light of 6 degrees is near the limit of the quadrature.
    lit = (cosine > 0.5) & (x**2 + y**2 < 0.8)
    ratio = matte[lit] / cosine[lit]
    np.testing.assert_allclose(ratio, ratio.mean(), rtol=0.03)


def test_pixels_have_equal_areas_and_the_viewer_goes_once_around():
    # Oracle: the areas of rings, and the spiral as documented.
    limit = np.radians(80)
    scene = sphere([((0.0, 1.0, 0.0), np.ones_like)], limit, rings=8, sectors=4, polar=6, around=10)
    area = (scene.radius / np.sin(limit)) ** 2
    np.testing.assert_allclose(np.diff(area), 1 / 8, rtol=1e-12)
    wo = scene.wo.reshape(8, 60, 3)[:, 0]
    np.testing.assert_allclose(np.hypot(wo[:, 0], wo[:, 1]), scene.radius, rtol=1e-12)
    azimuth = np.arctan2(wo[:, 1], wo[:, 0]) % (2 * np.pi)
    np.testing.assert_allclose(azimuth, 2 * np.pi * area, rtol=1e-12)


def test_left_and_right_are_not_exchanged_on_the_surface():
    # Oracle: on the sphere's right side, seen from outside, light from below comes from the left of the viewer.
    scene = sphere([((0.0, -1.0, 0.0), lambda cosine: np.maximum(cosine, 0))], np.radians(80))
    from_the_left = scene.wo[:, 0] * scene.wi[:, 1] - scene.wo[:, 1] * scene.wi[:, 0] > 0
    right, left = scene.picture(from_the_left[:, None].astype(float))[-4:, [0, 32], 0].T
    assert (right > 5 * left).all()
