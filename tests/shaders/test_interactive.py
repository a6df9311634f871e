"""The interactive tier in the renderer. Oracles: the truth tier, held to float64 elsewhere; laws; the counts."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF
from shaders import Environment, Image, Mesh, Part, Renderer, Scene, load_environment, render, sphere
from shaders.blurs import is_sampled
from shaders.round_lobes import round_lobes

pytestmark = [pytest.mark.gpu, pytest.mark.usefixtures("nothing_kept")]

GGX = brdf.MODELS["ggx"]
ROUGH = GGX(f0=(0.9, 0.6, 0.3), alpha=0.4)
BRUSHED = GGX(f0=(0.9, 0.8, 0.6), anisotropy="anisotropic", alpha_x=0.4, alpha_y=0.15)


def _directions(height: int) -> NDArray[np.float64]:
    u, v = (np.arange(2 * height) + 0.5) / (2 * height), (np.arange(height)[:, None] + 0.5) / height
    azimuth, polar = 2 * np.pi * (u - 0.5), np.pi * v
    sine = np.sin(polar)
    return np.stack([sine * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -sine * np.cos(azimuth)], axis=-1)


def _gradient() -> Environment:
    """Light that varies slowly and in every direction and channel differently."""
    w = _directions(64)
    powers = [np.exp(2 * w @ np.array(axis)) for axis in ((0.6, 0.64, 0.48), (-0.8, 0.6, 0.0), (0.0, -0.28, 0.96))]
    return Environment((0.2 + np.stack(powers, axis=-1)).astype(np.float32), "gradient")


def _scene(material: AbstractBRDF, environment: Environment | None = None, **settings: Any) -> Scene:
    base: dict[str, Any] = {"width": 48, "height": 48, "tier": "interactive", "tone_map": "none", "sky": "none"}
    return Scene((Part(material),), environment or _gradient(), **base | settings)


def _moved(x: float, y: float = 0.0, z: float = 0.0) -> Mesh:
    mesh = sphere()
    return dataclasses.replace(mesh, positions=mesh.positions + np.array([x, y, z], np.float32))


WHITE = {
    "lambert": brdf.MODELS["lambert"](albedo=1.0),
    "eon": brdf.MODELS["eon"](albedo=1.0),
    "ggx": GGX(f0=1.0, alpha=0.5, energy="multiple"),
    "ggx sharp": GGX(f0=1.0, alpha=0.01, energy="multiple"),
}


@pytest.mark.parametrize("name", list(WHITE))
def test_a_white_ball_that_keeps_all_light_disappears_in_a_furnace(name: str):
    found = render(_scene(WHITE[name], load_environment("furnace"), sky="sharp")).pixels
    # 1 % is what models with a table of their energy promise themselves; the outermost pixels are at cos_o of 0.1.
    np.testing.assert_allclose(found, 1, atol=0.015)


# The largest RMS error over the ball, of the RMS radiance, that is held: a little above what was measured.
LIKENESS = {
    "ggx": (ROUGH, 0.015),
    "sum": (brdf.build("lambert+ggx"), 0.018),
    "disney with clearcoat": (brdf.MODELS["disney"](base_color=(0.6, 0.1, 0.1), clearcoat=1.0), 0.02),
    "gltf with sheen": (brdf.MODELS["gltf"](base_color=(0.1, 0.1, 0.4), sheen_color=(0.8, 0.6, 0.6)), 0.04),
    "brushed": (BRUSHED, 0.07),
}


@pytest.mark.parametrize("name", list(LIKENESS))
def test_under_a_smooth_light_it_looks_like_the_truth(name: str):
    material, limit = LIKENESS[name]
    found = render(_scene(material)).pixels
    truth = render(_scene(material, tier="truth", samples=600)).pixels
    inside = truth[..., 3] > 0.999
    error = np.sqrt(np.square((found - truth)[inside]).mean() / np.square(truth[inside]).mean())
    assert error < limit


def test_a_brushed_ball_is_its_own_mirror_image_under_a_light_that_is():
    # Light, brushing and viewer are the same on the left and on the right: so must the picture be. It has no step in
    # the middle either, where the viewer changes sides.
    w = _directions(64)
    light = Environment((1 + 0.9 * w[..., 1:2] * np.ones(3) + np.abs(w[..., :1])).astype(np.float32), "symmetric")
    pixels = render(_scene(BRUSHED, light, width=64, height=64)).pixels[..., :3]
    inside = (slice(12, 52), slice(12, 52))
    np.testing.assert_allclose(pixels[inside], pixels[:, ::-1][inside], rtol=0.01)
    # The light from one side only.
    light = Environment((1.1 + w[..., :1] * np.ones(3)).astype(np.float32), "from the right")
    pixels = render(_scene(BRUSHED, light, width=64, height=64)).pixels[12:52, :, 0]
    steps = np.abs(np.diff(pixels, axis=1))[:, 24:39]
    assert steps[:, 7].max() < 1.5 * steps[:, [3, 4, 10, 11]].max()


def test_an_equal_scene_does_nothing_the_second_time():
    renderer = Renderer()
    scene = _scene(ROUGH, tone_map="neutral")
    first, second = renderer.render(scene), renderer.render(dataclasses.replace(scene))
    assert second.counts["passes"] == []
    assert [second.counts[name] for name in ("draws", "bytes_uploaded", "programs_compiled")] == [0, 0, 0]
    np.testing.assert_array_equal(first.pixels, second.pixels)


def test_another_camera_or_value_makes_no_blur_anew():
    renderer = Renderer()
    renderer.render(_scene(ROUGH))
    # Only the amplitudes change with the colour.
    for change in ({"rotation": 1.0}, {"parts": (Part(dataclasses.replace(ROUGH, f0=(0.3, 0.6, 0.9))),)}):
        scene = dataclasses.replace(_scene(ROUGH), **change)
        image = renderer.render(scene)
        assert not {"environment", "sky_cube", "blurs", "geometry"} & set(image.counts["passes"])
        np.testing.assert_array_equal(image.pixels, Renderer().render(scene).pixels)


def test_only_what_is_looked_up_is_made():
    assert not any(map(is_sampled, round_lobes(Part(ROUGH).twin).kernels))
    wide = Renderer().render(_scene(ROUGH))
    assert not {"environment", "light_table", "sky_cube", "sky", "surface_truth", "materials"} & set(
        wide.counts["passes"]
    )
    sharp = Renderer().render(_scene(GGX(f0=0.9, alpha=0.01)))
    assert {"environment", "dim_cube"} <= set(sharp.counts["passes"])
    assert not {"light_table", "materials"} & set(sharp.counts["passes"])
    truth = Renderer().render(_scene(ROUGH, tier="truth", samples=16))
    assert not {"sky_cube", "blurs", "round_lobes", "surface_interactive"} & set(truth.counts["passes"])


@pytest.mark.parametrize("wrong", [{"samples": 64}, {"error": 0.01}, {"seconds": 1.0}])
def test_it_refuses_what_only_sampling_has(wrong: dict[str, Any]):
    (name,) = wrong
    with pytest.raises(brdf.UserError, match=f"`{name} = {wrong[name]}` is for"):
        _scene(ROUGH, **wrong)


def test_several_parts_have_their_own_lobes_and_hide_each_other():
    # Oracle: each alone. Balls side by side, and one of another material behind the first.
    left = Part(brdf.MODELS["lambert"](albedo=(0.9, 0.2, 0.1)), _moved(-0.6))
    right = Part(GGX(f0=(0.2, 0.9, 0.4), alpha=0.3), _moved(0.6))
    hidden = Part(BRUSHED, _moved(-0.8, 0.0, -1.9))
    scene = dataclasses.replace(_scene(ROUGH), parts=(hidden, right, left))
    together = Renderer().render(scene)
    assert "depth" in together.counts["passes"]

    def alone(part: Part) -> Image:
        return Renderer().render(dataclasses.replace(scene, parts=(part,)))

    for part, columns in ((left, slice(4, 20)), (right, slice(30, 44))):
        np.testing.assert_allclose(
            together.pixels[18:30, columns], alone(part).pixels[18:30, columns], rtol=1e-5, atol=1e-6
        )


@pytest.mark.parametrize("material", [ROUGH, GGX(f0=0.9, alpha=0.01), BRUSHED], ids=["wide", "narrow", "brushed"])
def test_turning_the_environment_turns_its_picture(material: AbstractBRDF):
    # A quarter turn counter-clockwise seen from above moves what is at azimuth a to a - 90 degrees: to the left.
    turned = Environment(np.roll(_gradient().pixels, -32, axis=1), "turned")
    by_angle = render(_scene(material, rotation=math.pi / 2)).pixels
    by_pixels = render(_scene(material, turned)).pixels
    # Cubes have their texels elsewhere when the picture is turned by other than a quarter; here they have not.
    np.testing.assert_allclose(by_angle, by_pixels, rtol=5e-3, atol=1e-4)
    assert np.abs(by_angle - render(_scene(material)).pixels).max() > 0.1


def test_coverage_is_smooth_at_the_outline():
    pixels = render(_scene(brdf.MODELS["lambert"](albedo=0.5), load_environment("furnace"))).pixels
    coverage = pixels[..., 3]
    assert coverage[0, 0] == 0
    assert coverage[24, 24] == 1
    assert ((coverage > 0.01) & (coverage < 0.99)).sum() > 30
    assert coverage.mean() == pytest.approx(math.pi * 0.8**2 / 4, rel=0.02)
    # Premultiplied.
    np.testing.assert_allclose(pixels[..., :3], 0.5 * coverage[..., None] * np.ones(3), atol=2e-3)
