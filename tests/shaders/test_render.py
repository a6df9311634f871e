"""Pictures: orientation, furnace, a lit sphere against float64 quadrature, and what a frame does and does not do."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from quadrature import reflected_radiance

import brdf
from brdf.model import AbstractBRDF
from brdf.parameter import parameters
from brdf.registry import combine, split
from shaders import Environment, Image, Part, Renderer, Scene, load_environment, render
from shaders.renderer import plan_of

pytestmark = pytest.mark.gpu

MIRROR = brdf.MODELS["ggx"](f0=1.0, alpha=1e-3)
# Ratios no other pair shares: front is what the camera faces, at -z.
MARKS = {
    "front": (1.0, 0.0, 0.0),
    "back": (0.0, 1.0, 0.0),
    "left": (0.0, 0.0, 1.0),
    "right": (1.0, 1.0, 0.0),
    "top": (0.0, 1.0, 1.0),
    "bottom": (1.0, 0.0, 1.0),
}


def _directions(height: int) -> NDArray[np.float64]:
    """The direction of every texel, by the documented orientation: its inverse, written out independently."""
    u, v = (np.arange(2 * height) + 0.5) / (2 * height), (np.arange(height)[:, None] + 0.5) / height
    azimuth, polar = 2 * np.pi * (u - 0.5), np.pi * v
    sine = np.sin(polar)
    return np.stack([sine * np.sin(azimuth), np.cos(polar) + 0 * azimuth, -sine * np.cos(azimuth)], axis=-1)


def _marked() -> Environment:
    """A sky of six faces in six colours."""
    axes = {"front": (0, 0, -1), "back": (0, 0, 1), "left": (-1, 0, 0), "right": (1, 0, 0), "top": (0, 1, 0)}
    axes["bottom"] = (0, -1, 0)
    nearest = np.argmax(_directions(128) @ np.array([axes[name] for name in MARKS]).T, axis=-1)
    return Environment(np.array([MARKS[name] for name in MARKS], np.float32)[nearest], "marked")


def _smooth() -> Environment:
    """Light that varies slowly and in every direction and channel differently."""
    w = _directions(64)
    powers = [np.exp(2 * w @ np.array(axis)) for axis in ((0.6, 0.64, 0.48), (-0.8, 0.6, 0.0), (0.0, -0.28, 0.96))]
    return Environment((0.2 + np.stack(powers, axis=-1)).astype(np.float32), "smooth")


def _picture(material: AbstractBRDF, environment: Environment, **scene: Any) -> Image:
    settings = {"width": 96, "height": 96, "tone_map": "none", "samples": 352} | scene
    return render(Scene((Part(material),), environment, **settings))


def _scene(material: AbstractBRDF, **settings: Any) -> Scene:
    return Scene((Part(material),), _smooth(), **{"width": 48, "height": 48} | settings)


def _mark_at(image: Image, x: float, y: float) -> str:
    """The mark seen at a place, in picture coordinates from -1 to 1, x to the right and y upwards."""
    height, width = image.pixels.shape[:2]
    color = image.pixels[int((1 - y) / 2 * height), int((1 + x) / 2 * width), :3]
    return min(MARKS, key=lambda name: float(np.abs(color / color.max() - MARKS[name]).sum()))


def test_the_sky_is_upright_and_not_mirrored():
    from shaders import Camera

    wide = Camera(position=(0.0, 0.0, 30.0), vertical_fov=math.radians(140))
    image = _picture(MIRROR, _marked(), camera=wide, samples=14)
    places = {"front": (0.2, 0.2), "left": (-0.9, 0.0), "right": (0.9, 0.0), "top": (0.0, 0.9), "bottom": (0.0, -0.9)}
    assert {name: _mark_at(image, *place) for name, place in places.items()} == {name: name for name in places}


def test_a_mirror_ball_shows_what_is_behind_the_viewer_and_around():
    # The ball's outline is at 0.8; at distance d from its middle it reflects by 2 asin(d / 0.8) away from the viewer.
    image = _picture(MIRROR, _marked(), samples=56)
    places = {
        "back": (0.0, 0.0),
        "left": (-0.56, 0.0),
        "right": (0.56, 0.0),
        "top": (0.0, 0.56),
        "bottom": (0.0, -0.56),
    }
    assert {name: _mark_at(image, *place) for name, place in places.items()} == {name: name for name in places}
    assert _mark_at(image, 0.79, 0.0) == "front"


def test_rotation_turns_the_environment_counter_clockwise_seen_from_above():
    # From -z (front) a quarter turn counter-clockwise seen from +y leads to -x (left).
    image = _picture(MIRROR, _marked(), rotation=math.pi / 2, samples=56)
    assert _mark_at(image, -0.56, 0.0) == "front"
    assert _mark_at(image, 0.0, 0.0) == "left"
    assert _mark_at(image, -0.95, 0.95) == "right"


def test_a_white_lambert_ball_disappears_in_a_furnace():
    # Samples from the environment miss the upper half space of a tilted surface half the time: noise, falling with N.
    image = _picture(brdf.MODELS["lambert"](albedo=1.0), load_environment("furnace"), samples=1600)
    np.testing.assert_allclose(image.pixels, 1, atol=0.01)


@pytest.mark.parametrize("alpha", [1e-4, 5e-3])
def test_a_sharp_white_metal_disappears_in_a_furnace(alpha: float):
    # Its single-scattering albedo is 1 up to alpha^2; at the outline, a pixel at most, visibility takes more.
    image = _picture(brdf.MODELS["ggx"](f0=1.0, alpha=alpha), load_environment("furnace"))
    assert np.quantile(np.abs(image.pixels - 1), 0.99) <= 0.01


def _with(expression: str, **values: Any) -> AbstractBRDF:
    lobes = split(brdf.build(expression))
    for key, value in values.items():
        lobe, _, name = key.partition("__")
        lobes[lobe] = dataclasses.replace(lobes[lobe], **{name: value})
    return combine(lobes)


UNEQUAL = np.array([0.9, 0.5, 0.2])
MATERIALS = {
    "lambert": _with("lambert", lambert__albedo=UNEQUAL),
    "oren_nayar": _with("oren_nayar", oren_nayar__albedo=UNEQUAL, oren_nayar__sigma=0.6),
    "ggx 1e-4": _with("ggx", ggx__f0=UNEQUAL, ggx__alpha=1e-4),
    "ggx 0.005": _with("ggx", ggx__f0=UNEQUAL, ggx__alpha=0.005),
    "ggx 0.3": _with("ggx", ggx__f0=UNEQUAL, ggx__alpha=0.3),
    "ggx 1": _with("ggx", ggx__f0=UNEQUAL, ggx__alpha=1.0),
    "beckmann 1e-3": _with("beckmann", beckmann__f0=UNEQUAL, beckmann__alpha=1e-3),
    "beckmann 0.2": _with("beckmann", beckmann__f0=UNEQUAL, beckmann__alpha=0.2),
    "sum": _with("lambert+ggx+ggx", lambert__albedo=UNEQUAL, ggx__alpha=0.05, ggx_2__alpha=0.5, ggx_2__f0=0.5),
}


def _radiance(environment: Environment, w: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear radiance by direction in float64, by the documented orientation."""
    height, width = environment.pixels.shape[:2]
    x = (0.5 + np.arctan2(w[:, 0], -w[:, 2]) / (2 * np.pi)) * width - 0.5
    y = np.arccos(np.clip(w[:, 1], -1, 1)) / np.pi * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros((len(w), 3))
    for column, across in ((left, 1 - (x - left)), (left + 1, x - left)):
        for row, down in ((top, 1 - (y - top)), (top + 1, y - top)):
            texel = environment.pixels[np.clip(row, 0, height - 1), column % width]
            total += texel.astype(np.float64) * (across * down)[:, None]
    return total


def _truth(material: AbstractBRDF, environment: Environment, x: float, y: float) -> NDArray[np.float64]:
    """What the default camera sees at a place in the picture: ray, sphere, frame and integral in float64."""
    eye = np.array([0.0, 0.0, 4.77])
    half = math.tan(math.radians(15))
    ray = np.array([x * half, y * half, -1.0])
    ray /= np.linalg.norm(ray)
    along = -(ray @ eye) - math.sqrt((ray @ eye) ** 2 - (eye @ eye - 1))
    normal = eye + along * ray
    tangent = np.cross(normal, [0.3, 0.9, 0.1])
    tangent /= np.linalg.norm(tangent)
    to_world = np.stack([tangent, np.cross(normal, tangent), normal], axis=-1)

    def incident(wi: Any) -> Any:
        return jnp.asarray(_radiance(environment, np.asarray(wi) @ to_world.T))

    return np.asarray(reflected_radiance(material, jnp.asarray(to_world.T @ -ray), incident, 128))


@pytest.mark.parametrize("name", list(MATERIALS))
def test_a_lit_ball_agrees_with_float64_quadrature(name: str):
    size = 49
    image = _picture(MATERIALS[name], _smooth(), width=size, height=size, samples=6000)
    for row, column in ((24, 24), (15, 28), (30, 12), (13, 15), (24, 41)):
        x, y = (2 * column + 1) / size - 1, 1 - (2 * row + 1) / size
        # 1 %: the noise of 6000 samples, the mean over a pixel of 1/20 of the ball, and the cut at the horizon.
        np.testing.assert_allclose(image.pixels[row, column], _truth(MATERIALS[name], _smooth(), x, y), rtol=0.01)


def test_no_pixel_is_nan_infinite_or_negative_whatever_the_material():
    rng = np.random.default_rng(11)
    harsh = _marked().pixels.copy()
    harsh[20, 40], harsh[90, 200] = 60000, 65504
    environment = Environment(harsh, "harsh")
    for expression in ("ggx", "beckmann", "oren_nayar", "lambert+ggx", "beckmann+ggx"):
        for corner in range(6):
            lobes = split(brdf.build(expression))
            for lobe_name, lobe in lobes.items():
                values: dict[str, Any] = {}
                for one in parameters(lobe):
                    part = np.array(corner % 2) if corner < 2 else rng.random(one.size) ** 3
                    drawn = one.lower + (one.upper - one.lower) * part
                    values[one.name] = (
                        np.broadcast_to(drawn, (one.size,)) if one.kind == "color" else float(drawn.flat[0])
                    )
                lobes[lobe_name] = dataclasses.replace(lobe, **values)
            image = _picture(combine(lobes), environment, width=48, height=48, samples=28, tone_map="neutral")
            for pixels in (image.pixels, image.display):
                assert pixels is not None
                assert np.isfinite(pixels).all()
                assert pixels.min() >= 0


def test_exposure_multiplies_the_linear_picture_by_powers_of_two():
    material = brdf.build("lambert+ggx")
    plain, brighter = (_picture(material, _smooth(), samples=14, exposure=stops).pixels for stops in (0.0, 2.0))
    np.testing.assert_allclose(brighter, 4 * plain, rtol=1e-6)


def test_a_picture_is_not_cut_to_the_size_of_the_last_one():
    # A clear is limited by the scissor, which the last picture's tiles have left.
    large, small = ({"width": size, "height": size, "samples": 16} for size in (96, 48))
    first = _picture(brdf.build("lambert"), _smooth(), **large).pixels
    _picture(brdf.build("lambert"), _smooth(), **small)
    np.testing.assert_array_equal(_picture(brdf.build("lambert"), _smooth(), **large).pixels, first)


def test_the_same_scene_gives_the_same_picture_and_compiles_nothing_twice():
    material = brdf.build("oren_nayar+ggx")
    first, second = (Renderer().render(_scene(material, samples=28)) for _ in range(2))
    np.testing.assert_array_equal(first.pixels, second.pixels)
    assert second.counts["programs_compiled"] == 0


def test_without_a_sky_the_picture_has_coverage_and_no_sky_pass():
    image = _picture(brdf.build("lambert"), load_environment("furnace"), sky="none", tone_map="neutral", samples=400)
    assert image.counts["dropped"].keys() >= {"sky", "blurred_sky"}
    assert image.pixels.shape == (96, 96, 4)
    coverage = image.pixels[..., 3]
    assert coverage[0, 0] == 0
    assert coverage[48, 48] == pytest.approx(1)
    # The outline is antialiased, and the whole area is a disc of radius 0.8 of the half height.
    assert ((coverage > 0.01) & (coverage < 0.99)).sum() > 100
    assert coverage.mean() == pytest.approx(math.pi * 0.8**2 / 4, rel=0.01)
    # Premultiplied in linear light, straight for displays.
    assert image.display is not None
    inside, edge = image.display[48, 48, :3], (coverage > 0.3) & (coverage < 0.7)
    np.testing.assert_allclose(image.display[edge][:, :3], np.broadcast_to(inside, (edge.sum(), 3)), atol=0.03)


def test_a_linear_picture_runs_no_tone_map():
    linear = plan_of(Scene((Part(brdf.build("ggx")),), _smooth(), tone_map="none"), {})
    assert not linear.runs("tone_map")
    assert linear.dropped["tone_map"] == "disabled"
    assert plan_of(Scene((Part(brdf.build("ggx")),), _smooth()), {}).runs("tone_map")


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"width": 0}, "`width = 0`"),
        ({"height": 10**6}, "`height = 1000000`"),
        ({"samples": 0}, "`samples = 0`"),
        ({"error": 0.0}, "`error = 0.0`"),
        ({"seconds": -1.0}, "`seconds = -1.0`"),
        ({"error": 0.01, "tier": "still"}, "`error = 0.01` is for `tier = 'truth'`"),
        ({"exposure": math.nan}, "`exposure = nan`"),
        ({"rotation": math.inf}, "`rotation = inf`"),
    ],
)
def test_a_scene_outside_its_limits_is_refused(wrong: dict[str, Any], complaint: str):
    with pytest.raises(brdf.UserError, match=complaint):
        Scene((Part(brdf.build("ggx")),), _smooth(), **wrong)


def test_a_camera_without_a_view_is_refused():
    from shaders import Camera

    with pytest.raises(brdf.UserError, match="is no view"):
        _picture(brdf.build("ggx"), _smooth(), camera=Camera(target=(0.0, 0.0, 4.77)))
