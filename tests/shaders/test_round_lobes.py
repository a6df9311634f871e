"""Materials as round lobes. Oracles: closed forms, directional albedos by another quadrature, the laws of energy."""

from __future__ import annotations

import functools
import importlib
import math
import pathlib

import numpy as np
import pytest
from numpy.polynomial import polynomial
from numpy.typing import NDArray

import brdf
from brdf.integrate import albedos
from brdf.quadrature import half_vector_rule
from shaders import Environment, Part, Scene, evaluate, load_environment, render
from shaders.kernel import COSINE
from shaders.material_block import twin
from shaders.round_lobes import RoundLobes, _monomials, round_lobes
from shaders.round_samples import _wide_direction
from shaders.twin import Twin

pytestmark = [pytest.mark.gpu, pytest.mark.usefixtures("nothing_kept")]

COS_O = np.array([0.03, 0.1, 0.22, 0.4, 0.6, 0.8, 0.97])
BRUSHED = brdf.MODELS["ggx"](f0=(0.9, 0.8, 0.6), anisotropy="anisotropic", alpha_x=0.1, alpha_y=0.35)


def _total(lobes: RoundLobes, cos_o: NDArray[np.float64], phi: float = 0.0) -> NDArray[np.float64]:
    """The amplitudes of all lobes together, shape (n, 3), `phi` from the wide direction."""
    share = (math.cos(phi) ** 2, math.sin(phi) ** 2) if lobes.is_anisotropic else (1.0,)
    at = polynomial.polyval(cos_o, np.moveaxis(lobes.amplitude, 2, 0))
    return np.einsum("nacv,a->vc", at, share)


@functools.cache
def _albedo(material: Twin, phi: float = 0.0) -> NDArray[np.float64]:
    """By the rule over half vectors with four times the nodes of the fit and one azimuth more."""
    found = []
    for c in COS_O:
        wi, weight = half_vector_rule(math.acos(c), 96, 129)
        turn = np.array([[math.cos(phi), math.sin(phi), 0], [-math.sin(phi), math.cos(phi), 0], [0, 0, 1]])
        wo = np.broadcast_to(np.array([math.sqrt(1 - c * c), 0, c]) @ turn, wi.shape)
        value = evaluate(material, wi @ turn, wo).astype(np.float64)
        found.append((value * (np.maximum(wi[:, 2:], 0) * weight[:, None])).sum(axis=0))
    return np.array(found)


def _picture(material: brdf.AbstractBRDF | Twin, environment: Environment, **settings: object) -> NDArray[np.float32]:
    scene = {"width": 48, "height": 48, "tier": "interactive", "tone_map": "none"} | settings
    return render(Scene((Part(material),), environment, **scene)).pixels


def test_a_diffuse_surface_is_one_cosine_lobe():
    lobes = round_lobes(twin(brdf.MODELS["lambert"](albedo=(0.8, 0.5, 0.2))))
    assert lobes.kernels == (COSINE,)
    np.testing.assert_allclose(_total(lobes, COS_O), np.tile([0.8, 0.5, 0.2], (len(COS_O), 1)), rtol=2e-3)


def test_a_rough_diffuse_surface_has_a_lobe_that_leans_to_the_viewer():
    # Moon-like: it reflects most to where light comes from (Oren and Nayar 1994). The cosine alone misses by 0.27.
    lobes = round_lobes(twin(brdf.MODELS["oren_nayar"](albedo=(0.8, 0.3, 0.2), sigma=1.0)))
    (leaning,) = (i for i, kernel in enumerate(lobes.kernels) if kernel.power)
    assert (lobes.tilt[leaning] @ 0.5 ** np.arange(3)) < -0.3
    assert lobes.misfit < 0.1


def test_a_brushed_highlight_has_no_gaps():
    lobes = round_lobes(twin(BRUSHED))
    side_by_side = [i for i, kernel in enumerate(lobes.kernels) if kernel.power]
    (width,) = {lobes.kernels[i].width for i in side_by_side}
    # The width of a kernel is the slope that mirrors so far; of two so far apart, the sum is even in between.
    assert np.diff(lobes.lean[side_by_side]).max() < 1.5 * width
    assert len(lobes.cubes) == len(set(lobes.kernels)) <= 3


def test_a_black_material_is_one_lobe_of_nothing():
    lobes = round_lobes(twin(brdf.MODELS["lambert"](albedo=0.0)))
    assert len(lobes.kernels) == 1
    np.testing.assert_array_equal(lobes.amplitude, 0)
    assert _picture(brdf.MODELS["lambert"](albedo=0.0), load_environment("furnace"), sky="none")[..., :3].max() == 0


@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_lobes_together_reflect_what_the_material_does(name: str):
    material = twin(brdf.MODELS[name]())
    expected, found = _albedo(material), _total(round_lobes(material), COS_O)
    np.testing.assert_allclose(found[1:], expected[1:], rtol=0.01, atol=0.002 * expected.max())
    # At the rim, a thousandth of a ball's picture, a polynomial does not follow the steepest.
    np.testing.assert_allclose(found[0], expected[0], rtol=0.1)


def test_the_albedo_of_a_brushed_metal_is_right_all_around():
    material = twin(BRUSHED)
    lobes = round_lobes(material)
    for phi in (0.3, 0.8, 1.3, 2.5, 4.0):
        expected, found = _albedo(material, phi), _total(lobes, COS_O, phi - lobes.azimuth)
        # 2 %: its amplitudes have two numbers for the azimuth; the rim as above.
        np.testing.assert_allclose(found[1:], expected[1:], rtol=0.02)
        np.testing.assert_allclose(found[0], expected[0], rtol=0.1)


def test_amplitudes_agree_with_the_albedo_of_python():
    model = brdf.MODELS["ggx"](f0=(0.9, 0.6, 0.3), alpha=0.25)
    expected = albedos(model, np.arccos(COS_O), np.zeros(len(COS_O)))
    np.testing.assert_allclose(_total(round_lobes(twin(model)), COS_O), expected, rtol=0.01)


def test_powers_are_the_polynomials_of_bernstein():
    rng, x = np.random.default_rng(4), np.linspace(0, 1, 11)
    coefficients = rng.random((2, 1, 7, 3))
    expected = sum(
        math.comb(6, b) * x[:, None, None, None] ** b * (1 - x[:, None, None, None]) ** (6 - b) * coefficients[:, :, b]
        for b in range(7)
    )
    found = polynomial.polyval(x, np.moveaxis(_monomials(coefficients), 2, 0))
    np.testing.assert_allclose(np.moveaxis(found, -1, 0), expected, rtol=1e-9)


def test_amplitudes_are_never_negative():
    # Coefficients of Bernstein's polynomials are not; their powers lose digits, and the table has none below 0.
    x = np.linspace(0, 1, 101)
    for material in (twin(BRUSHED), twin(brdf.MODELS["gltf"]())):
        at = polynomial.polyval(x, np.moveaxis(round_lobes(material).amplitude, 2, 0))
        assert at.min() > -1e-6
        assert round_lobes(material).table()[..., :3].min() >= 0


def test_the_table_steps_by_less_than_eight_bits_show():
    # Oracle: 1/255 of the brightest, between neighbouring cosines of the viewer.
    for material in (twin(BRUSHED), twin(brdf.MODELS["ggx"](f0=0.04, alpha=0.3)), twin(brdf.MODELS["gltf"]())):
        amplitude = round_lobes(material).table()[..., :3]
        assert np.abs(np.diff(amplitude, axis=1)).max() < amplitude.sum(axis=0).max() / 255


@pytest.mark.parametrize("model", [brdf.build("lambert+ggx"), BRUSHED], ids=["isotropic", "brushed"])
def test_in_a_furnace_a_pixel_is_the_sum_of_the_amplitudes(model: brdf.AbstractBRDF):
    # Oracle of the table's layout: the sum in Python, at the pixels' own viewers.
    size = 49
    found = _picture(model, load_environment("furnace"), width=size, height=size)
    lobes, half = round_lobes(twin(model)), math.tan(math.radians(15))
    for row, column in ((24, 24), (15, 28), (30, 12), (13, 15), (24, 41)):
        ray = np.array([((2 * column + 1) / size - 1) * half, (1 - (2 * row + 1) / size) * half, -1.0])
        ray /= np.linalg.norm(ray)
        eye = np.array([0.0, 0.0, 4.77])
        n = eye + (-(ray @ eye) - math.sqrt((ray @ eye) ** 2 - (eye @ eye - 1))) * ray
        across = np.array([n[2], 0.0, -n[0]]) / math.hypot(n[2], n[0])
        phi = math.atan2(-ray @ np.cross(n, across), -ray @ across) - lobes.azimuth
        expected = _total(lobes, np.array([-ray @ n]), phi)[0]
        # The flat triangles of the mesh are seen a little beside the sphere.
        np.testing.assert_allclose(found[row, column], expected, rtol=3e-3)


def test_a_clearcoat_shows_the_sun_once():
    # Lobes lie where the mirror direction is, or beside it by less than one and a half of their half widths, which are
    # twice `width`: farther away a second sun would stand beside the first.
    lobes = round_lobes(twin(brdf.MODELS["disney"](clearcoat=1.0, clearcoat_gloss=0.8)))
    for kernel, tilt in zip(lobes.kernels, lobes.tilt, strict=True):
        if kernel.power:
            cos_o = np.linspace(0.8, 1, 6)
            beside = np.abs(polynomial.polyval(cos_o, tilt) - 1) * np.arccos(cos_o)
            assert beside.max() < 3 * kernel.width


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, 2.4])
def test_the_wide_direction_of_a_brushed_metal_is_found(angle: float):
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    material = twin(BRUSHED)
    found = _wide_direction(lambda wi, wo: evaluate(material, wi @ turn, wo @ turn))
    # Of a metal that is wide along y, turned by the angle.
    assert math.cos(2 * (found - angle - math.pi / 2)) == pytest.approx(1, abs=1e-3)


def test_other_shaders_are_another_material(monkeypatch: pytest.MonkeyPatch):
    # The material's own text only names the files that it includes.
    module = importlib.import_module("shaders.round_lobes")

    seen: list[bytes] = []
    keep = module.kept

    def watch(kind, ingredients, make):
        seen.append(ingredients[0])
        return keep(kind, ingredients, make)

    monkeypatch.setattr(module, "kept", watch)
    round_lobes.cache_clear()
    round_lobes(twin(brdf.MODELS["lambert"]()))
    glsl = pathlib.Path(module.__file__).parent / "glsl" / "brdf" / "lambert.glsl"
    assert glsl.read_text(encoding="utf-8").splitlines()[-1].encode() in seen[0]
    assert b"#include" not in seen[0]
