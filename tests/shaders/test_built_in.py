"""The built-in environments: their energy at any resolution, seams, poles, and the physics of the clear sky."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fitter.cli.preview import command
from shaders import load_environment
from shaders.built_in import BUILT_IN
from shaders.built_in.atmosphere import EXTINCTION, GROUND, SCATTERING, TOP, scattered, transmittance
from shaders.built_in.clear_sky import SUN_ELEVATION, SUN_HALF_ANGLE, clear_sky, sun_direction
from shaders.built_in.disc import add_disc
from shaders.built_in.night import night
from shaders.built_in.overcast import ZENITH, overcast

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _directions(height: int) -> NDArray[np.float64]:
    """The direction of every texel, by the documented orientation, written out independently."""
    u, v = (np.arange(2 * height) + 0.5) / (2 * height), (np.arange(height)[:, None] + 0.5) / height
    azimuth, polar = 2 * np.pi * (u - 0.5), np.pi * v
    return np.stack(
        [np.sin(polar) * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -np.sin(polar) * np.cos(azimuth)], -1
    )


def _solid_angles(height: int) -> NDArray[np.float64]:
    """The area on the unit sphere of the texels of each row, shape (height, 1): differences of cosines."""
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return ((edges[:-1] - edges[1:]) * np.pi / height)[:, None]


def _irradiance(pixels: NDArray[np.float32], normal: tuple[float, float, float]) -> NDArray[np.float64]:
    height = len(pixels)
    cosine = np.clip(_directions(height) @ (np.array(normal) / np.linalg.norm(normal)), 0, None)
    return np.einsum("rc,rck->k", cosine * _solid_angles(height), pixels.astype(np.float64))


@pytest.mark.parametrize("height", [128, 256, 1024])
@pytest.mark.parametrize("make", [clear_sky, night])
def test_irradiance_does_not_depend_on_the_resolution(make, height: int):
    # Oracle: the same environment at 512 rows. The tolerance is the midpoint rule's at the edge of a half space, which
    # at 128 rows moves a share of the sun or of a lamp.
    coarse, fine = make(height), make(512)
    for normal in ((0, 1, 0), (0, 0, 1), (-0.7, 0.6, 0.5), (0.3, -0.2, -0.9)):
        np.testing.assert_allclose(_irradiance(coarse, normal), _irradiance(fine, normal), rtol=0.01)


@pytest.mark.parametrize("height", [32, 128, 512])
@pytest.mark.parametrize("towards", [(0.3, 0.5, -0.4), (0.001, 0.1, 1.0), (-0.7, -0.6, 0.2)])
def test_a_disc_has_its_energy_and_direction_however_few_texels_it_covers(height: int, towards):
    # Oracle: a small disc's vector irradiance is E along its axis, less alpha^2 / 4. The midpoint rule differs by
    # step^2 / 24, the rows' curvature by step^2 / 6, from the interpolated picture, of which the energy is exact.
    picture, energy = np.zeros((height, 2 * height, 3), np.float32), np.array([3.0, 2.0, 1.0])
    add_disc(picture, towards, SUN_HALF_ANGLE, energy, (0.4, 0.5, 0.65))
    vector = np.einsum(
        "rcx,rck->kx", _directions(height) * _solid_angles(height)[..., None], picture.astype(np.float64)
    )
    expected = energy[:, None] * np.array(towards) / np.linalg.norm(towards)
    np.testing.assert_allclose(vector, expected, atol=3 * (np.pi / height) ** 2 + 1e-5)


def test_the_clear_sky_gives_a_white_card_on_the_ground_radiance_one_from_sun_and_sky():
    picture = clear_sky()
    np.testing.assert_allclose(_irradiance(picture, (0, 1, 0)), np.pi, rtol=2e-3)
    # Of what the ground receives, 0.16 is scattered by the air (its column is 0.11 in green, over the sine of 38
    # degrees), half of that downwards; aerosol and the ground add to it. The rest is the sun's, within 1.5 degrees.
    w, height = _directions(512), 512
    near = w @ np.array(sun_direction()) > math.cos(math.radians(1.5))
    sun = np.einsum("rc,rck->k", near * w[..., 1].clip(0) * _solid_angles(height), picture.astype(np.float64))
    assert 0.08 < 1 - (sun @ LUMINANCE) / np.pi < 0.25
    # White balanced on both together: the sun is warmer, the sky bluer.
    assert sun[0] > sun[1] > sun[2]


def test_the_sun_is_half_a_degree_wide():
    # Beyond its radius and two texels of 0.35 degrees, by which interpolation widens it, there is sky, with the glow
    # of the aerosol.
    picture = clear_sky()
    off = np.arccos(np.clip(_directions(512) @ np.array(sun_direction()), -1, 1))
    assert picture.max() > 1e4
    assert picture[off > SUN_HALF_ANGLE + math.radians(0.75)].max() < 5


def test_the_beam_of_the_sun_agrees_with_a_flat_atmosphere():
    # Oracle: columns in closed form over the sine of the elevation; the curvature is 0.2 % of them.
    columns = np.array([8 * math.exp(-0.5 / 8), 1.2 * math.exp(-0.5 / 1.2), 15.0])
    expected = np.exp(-columns @ EXTINCTION / math.sin(SUN_ELEVATION))
    np.testing.assert_allclose(transmittance(0.5, math.sin(SUN_ELEVATION)), expected, rtol=5e-3)


def _density(height: NDArray[np.float64]) -> NDArray[np.float64]:
    ozone = np.clip(1 - np.abs(height - 25) / 15, 0, None)
    return np.stack([np.exp(-height / 8), np.exp(-height / 1.2), ozone], axis=-1)


def _to_top(p: NDArray[np.float64], w: NDArray[np.float64]) -> NDArray[np.float64]:
    along = p @ w
    return -along + np.sqrt(along**2 + TOP**2 - (p * p).sum(axis=-1))


@pytest.mark.parametrize(("elevation", "around"), [(2, 0), (2, 180), (12, 90), (38, 20), (90, 0)])
def test_lightscattered_once_agrees_with_fine_steps_in_float64(elevation: float, around: float):
    # Oracle: the single-scattering integral in vectors, float64, 2000 steps by 300.
    sine, cosine = math.sin(math.radians(elevation)), math.cos(math.radians(elevation))
    view = np.array([cosine * math.cos(math.radians(around)), sine, cosine * math.sin(math.radians(around))])
    sun = np.array([math.cos(SUN_ELEVATION), math.sin(SUN_ELEVATION), 0.0])
    eye = np.array([0.0, GROUND + 0.5, 0.0])
    length = _to_top(eye[None], view)[0]
    step = length / 2000
    points = eye + ((np.arange(2000) + 0.5) * step)[:, None] * view
    density = _density(np.linalg.norm(points, axis=-1) - GROUND)
    to_sun = _to_top(points, sun)
    depth = np.zeros((2000, 3))
    for part in (np.arange(300) + 0.5) / 300:
        at = points + (part * to_sun)[:, None] * sun
        depth += _density(np.linalg.norm(at, axis=-1) - GROUND) * (to_sun / 300)[:, None]
    depth += (np.cumsum(density, axis=0) - density / 2) * step
    lit = np.exp(-depth @ EXTINCTION.astype(np.float64))
    nu = np.array([[view @ sun]], np.float32)
    found = scattered(0.5, np.array([[sine]], np.float32), nu, math.sin(SUN_ELEVATION), 0.2)
    for k in range(2):
        expected = (lit * density[:, k : k + 1]).sum(axis=0) * step * SCATTERING[k]
        np.testing.assert_allclose(found[k][0, 0], expected, rtol=0.02)


@pytest.mark.parametrize("height", [64, 512])
def test_the_overcast_sky_sends_seven_ninths_pi_of_its_zenith_onto_the_ground(height: int):
    # Oracle: the integral of (1 + 2 sin(elevation)) / 3 times the sine over the hemisphere.
    pixels = overcast(height)
    received = _irradiance(pixels, (0, 1, 0))
    tint = pixels[0].mean(axis=0) / pixels[0, :, 1].mean()
    np.testing.assert_allclose(received, 7 * np.pi / 9 * ZENITH * tint, rtol=1e-3)


@pytest.mark.parametrize("name", list(BUILT_IN))
def test_there_is_no_seam_behind_the_viewer_and_no_star_at_the_poles(name: str):
    # Oracle: continuity. The step from the last column to the first is like those beside it; across a pole, from a
    # texel to the opposite one 0.35 degrees away, radiance hardly changes.
    pixels = load_environment(name).pixels.astype(np.float64)
    seam = np.abs(pixels[:, 0] - pixels[:, -1])
    beside = np.maximum(np.abs(pixels[:, 1] - pixels[:, 0]), np.abs(pixels[:, -1] - pixels[:, -2]))
    assert (seam <= 1.5 * beside + 0.002 * pixels[:, 0]).all()
    for row in (pixels[0], pixels[-1]):
        opposite = np.roll(row, len(row) // 2, axis=0)
        assert (np.abs(row - opposite) <= 0.03 * (row + opposite)).all()


@pytest.mark.parametrize("name", list(BUILT_IN))
def test_a_built_in_environment_is_light(name: str):
    pixels = load_environment(name).pixels
    assert pixels.dtype == np.float32
    assert pixels.shape[1] == 2 * pixels.shape[0]
    assert np.isfinite(pixels).all()
    assert pixels.min() > 0


def test_a_built_in_environment_is_made_once_and_shared_by_all_who_cannot_change_it():
    environment = load_environment("overcast")
    assert load_environment("overcast") is environment
    with pytest.raises(ValueError, match="read-only"):
        environment.pixels[0, 0] = 0


def test_the_help_of_the_preview_names_every_built_in_environment():
    (option,) = (one for one in command.params if one.name == "environment")
    assert all(name in str(option.help) for name in BUILT_IN)
