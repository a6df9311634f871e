"""What a renderer keeps between frames, what a scene's features cost, and the counts that say so.

Oracles: the definition of each count, and the picture of a renderer that keeps nothing.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import moderngl
import numpy as np
import pytest

import brdf
from shaders import Camera, Environment, Mesh, Part, Renderer, Scene, load_environment, render, sphere
from shaders.buffers import KeptBuffer, KeptPixels
from shaders.context import device
from shaders.culling import visible_parts

pytestmark = pytest.mark.gpu

SKY = Environment(np.random.default_rng(3).random((16, 32, 3), np.float32), "noise")
OTHER_SKY = Environment(np.random.default_rng(4).random((16, 32, 3), np.float32), "other noise")


def _scene(alpha: float = 0.3, **settings: Any) -> Scene:
    part = Part(brdf.MODELS["ggx"](f0=0.8, alpha=alpha))
    return Scene((part,), **{"environment": SKY, "width": 32, "height": 32, "samples": 32} | settings)


def _moved(x: float, y: float = 0.0, z: float = 0.0) -> Mesh:
    mesh = sphere()
    return dataclasses.replace(mesh, positions=mesh.positions + np.array([x, y, z], np.float32))


def test_an_equal_scene_does_nothing_the_second_time_and_gives_the_same_picture():
    renderer = Renderer()
    first, second = renderer.render(_scene()), renderer.render(_scene())
    assert second.counts["passes"] == []
    assert second.counts["milliseconds"] == {}
    assert [second.counts[name] for name in ("draws", "bytes_uploaded", "programs_compiled")] == [0, 0, 0]
    assert second.counts["samples"] == first.counts["samples"] > 0
    np.testing.assert_array_equal(first.pixels, second.pixels)
    np.testing.assert_array_equal(np.asarray(first.display), np.asarray(second.display))


@pytest.mark.parametrize(
    ("change", "passes", "uploads"),
    [
        ({"exposure": 1.0}, ["resolve", "tone_map"], False),
        ({"alpha": 0.4}, ["materials", "points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"], True),
        ({"rotation": 1.0}, ["points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"], False),
        ({"camera": Camera((0, 0, 6))}, ["points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"], False),
        ({"samples": 64}, ["points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"], False),
        (
            {"environment": OTHER_SKY},
            ["environment", "light_table", "points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"],
            True,
        ),
        ({"tone_map": "none"}, [], False),
        ({"sky": "none"}, ["points", "surface_truth", "accumulate", "resolve", "tone_map"], False),
        ({"width": 64, "height": 80}, ["points", "surface_truth", "sky", "accumulate", "resolve", "tone_map"], False),
    ],
)
def test_a_change_runs_what_depends_on_it_and_the_picture_is_that_of_a_new_renderer(
    change: dict[str, Any], passes: list[str], uploads: bool
):
    renderer = Renderer()
    renderer.render(_scene())
    image = renderer.render(_scene(**change))
    assert image.counts["passes"] == passes
    assert (image.counts["bytes_uploaded"] > 0) == uploads
    np.testing.assert_array_equal(image.pixels, Renderer().render(_scene(**change)).pixels)


def test_a_new_value_of_a_material_uploads_its_bytes_and_no_others():
    renderer = Renderer()
    renderer.render(_scene(alpha=0.3))
    image = renderer.render(_scene(alpha=0.4))
    # One float32 of which some bytes may be the same.
    assert 0 < image.counts["bytes_uploaded"] <= 4


def test_a_buffer_that_was_updated_holds_the_new_content():
    kept, rng = KeptBuffer(device().ctx), np.random.default_rng(5)
    content = rng.integers(0, 256, 64, np.uint8)
    assert kept.update(content.tobytes()) == 64
    assert kept.update(content.tobytes()) == 0
    content[[20, 29]] ^= 255
    assert kept.update(content.tobytes()) == 10
    assert kept.buffer.read() == content.tobytes()
    assert kept.update(content[:8].tobytes()) == 8
    assert kept.buffer.read() == content[:8].tobytes()


def test_pixels_that_were_updated_hold_the_new_content():
    kept, rng = KeptPixels(device().ctx), np.random.default_rng(5)
    content = rng.random((7, 5, 4), np.float32)
    assert kept.update(content) == content.nbytes
    assert kept.update(content.copy()) == 0
    changed = content.copy()
    changed[[2, 4]] += 1
    assert kept.update(changed) == 3 * changed[0].nbytes
    assert kept.texture.read() == changed.tobytes()
    assert kept.update(content[:3]) == content[:3].nbytes
    assert kept.texture.read() == content[:3].tobytes()


def test_a_mesh_of_the_same_content_is_uploaded_once():
    renderer = Renderer()
    renderer.render(_scene())
    mesh = dataclasses.replace(sphere(), positions=sphere().positions.copy())
    copied = Part(brdf.MODELS["ggx"](f0=0.8, alpha=0.3), mesh)
    assert renderer.render(dataclasses.replace(_scene(), parts=(copied,))).counts["passes"] == []


def test_a_renderer_keeps_what_the_last_scene_has_and_no_more():
    renderer = Renderer()
    renderer.render(_scene(sky="blurred"))
    assert {"blurred_sky", "display"} <= renderer._store.keys()
    before = len(renderer._store)
    for seed in range(3):
        pixels = np.random.default_rng(seed).random((8, 16, 3), np.float32)
        renderer.render(_scene(environment=Environment(pixels, "x"), sky="blurred", tone_map="none"))
        assert len(renderer._store) == before - 1  # the display picture
    renderer.render(_scene(sky="none", tone_map="none", tier="still"))
    assert not {"blurred_sky", "display", "sum_odd"} & renderer._store.keys()


def test_an_interrupted_picture_is_not_taken_for_a_whole_one(monkeypatch: pytest.MonkeyPatch):
    from shaders.accumulation import Progress

    renderer = Renderer()
    renderer.render(_scene(alpha=0.3))

    def interrupt(self: Progress, accumulation: Any) -> bool:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Progress, "add", interrupt)
        with pytest.raises(KeyboardInterrupt):
            renderer.render(_scene(alpha=0.5))
    image = renderer.render(_scene(alpha=0.5))
    np.testing.assert_array_equal(image.pixels, Renderer().render(_scene(alpha=0.5)).pixels)


@pytest.mark.parametrize(
    ("off", "on", "passes", "resources"),
    [
        ({"sky": "none"}, {"sky": "sharp"}, {"sky"}, set()),
        ({"sky": "sharp"}, {"sky": "blurred"}, {"blurred_sky"}, {"blurred_sky"}),
        ({"tone_map": "none"}, {"tone_map": "neutral"}, {"tone_map"}, {"display"}),
        (
            {"tier": "still"},
            {"tier": "truth", "error": 0.01},
            {"surface_truth", "light_table"},
            {"sum_odd", "light_table"},
        ),
        (
            {"tier": "interactive", "samples": None, "sky": "none"},
            {"tier": "still", "sky": "none"},
            {"points", "surface_still", "accumulate"},
            {"points", "sum_even"},
        ),
        (
            {"tier": "interactive", "samples": None, "sky": "none"},
            {"tier": "truth", "error": 0.01, "sky": "none"},
            {"points", "surface_truth", "light_table", "accumulate"},
            {"points", "light_table", "sum_even", "sum_odd"},
        ),
        ({"tier": "truth", "sky": "none"}, {"tier": "still", "sky": "none"}, {"sky_cube", "environment"}, {"sky_cube"}),
    ],
)
def test_a_feature_that_is_off_has_no_pass_and_no_resource(
    off: dict[str, Any], on: dict[str, Any], passes: set[str], resources: set[str]
):
    without, with_it = Renderer(), Renderer()
    ran_without = set(without.render(_scene(**off)).counts["passes"])
    ran_with = set(with_it.render(_scene(**on)).counts["passes"])
    assert passes <= ran_with
    assert not passes & ran_without
    assert resources <= with_it._store.keys()
    assert not resources & without._store.keys()


def test_a_light_table_is_made_only_if_a_surface_is_drawn_from_it(monkeypatch: pytest.MonkeyPatch):
    from shaders.passes import light_table, sky
    from shaders.plan import plan

    made = plan(
        [light_table.declare(_scene()), dataclasses.replace(sky.declare(_scene()), reads=frozenset())], ["frame"], {}
    )
    assert made.dropped == {"light_table": "not read"}


def test_parts_outside_the_view_cost_nothing():
    ball = Part(brdf.MODELS["ggx"](f0=0.8, alpha=0.3))
    outside = [Part(brdf.build("lambert"), _moved(*place)) for place in ((9, 0, 0), (0, -9, 0), (0, 0, 9))]
    both = Renderer().render(dataclasses.replace(_scene(), parts=(ball, *outside)))
    alone = Renderer().render(_scene())
    assert both.counts["culled_parts"] == 3
    assert both.counts["bytes_uploaded"] == alone.counts["bytes_uploaded"]
    assert both.counts["draws"] == alone.counts["draws"]
    np.testing.assert_array_equal(both.pixels, alone.pixels)


def test_a_part_is_culled_only_if_none_of_its_points_is_in_view():
    # Oracle: the clip coordinates of all vertices, with the widest offset of a frame.
    from shaders.view import view_projection

    rng, size = np.random.default_rng(8), 12
    culled = 0
    for _ in range(200):
        mesh = _moved(*rng.uniform(-6, 6, 3))
        scene = Scene((Part(brdf.build("lambert"), mesh),), SKY, width=size, height=size)
        matrix = np.array(view_projection(scene)).reshape(4, 4).T
        clip = np.pad(mesh.positions.astype(float), ((0, 0), (0, 1)), constant_values=1) @ matrix.T
        limit = (1 + 1 / size) * clip[:, 3]
        inside = (np.abs(clip[:, 0]) <= limit) & (np.abs(clip[:, 1]) <= limit) & (np.abs(clip[:, 2]) <= clip[:, 3])
        is_visible = bool(visible_parts(scene))
        assert is_visible or not inside.any()
        culled += not is_visible
    # Culling does happen: the frustum takes up a small part of the box.
    assert culled > 100


def test_a_scene_of_which_nothing_is_in_view_is_the_sky():
    away = Part(brdf.build("lambert"), _moved(50.0))
    image = render(dataclasses.replace(_scene(environment=load_environment("furnace")), parts=(away,)))
    np.testing.assert_allclose(image.pixels, 1, rtol=1e-6)


def test_depth_is_drawn_first_where_parts_may_hide_each_other_and_changes_nothing(monkeypatch: pytest.MonkeyPatch):
    from shaders.passes import depth

    parts = tuple(Part(brdf.build("lambert"), _moved(0.3 * i, 0.0, -0.5 * i)) for i in range(3))
    scene = dataclasses.replace(_scene(tier="interactive", samples=None), parts=parts)
    with_depth = Renderer().render(scene)
    assert "depth" in with_depth.counts["passes"]
    alone = dataclasses.replace(scene, parts=parts[:1])
    for without_need in (alone, dataclasses.replace(scene, tier="truth", samples=16)):
        assert Renderer().render(without_need).counts["dropped"]["depth"] == "disabled"
    declare = depth.declare
    monkeypatch.setattr(depth, "declare", lambda scene: dataclasses.replace(declare(scene), enabled=False))
    without = Renderer().render(scene)
    assert "depth" not in without.counts["passes"]
    np.testing.assert_array_equal(with_depth.pixels, without.pixels)


def test_every_upload_is_counted():
    image = Renderer().render(_scene(sky="none"))
    mesh, part = sphere(), _scene().parts[0]
    from shaders.light_table import light_table

    table = light_table(SKY.pixels)
    arrays = (mesh.positions, mesh.normals, mesh.triangles, SKY.pixels, table.density, table.cells, table.slots)
    expected = sum(array.nbytes for array in arrays)
    assert image.counts["bytes_uploaded"] == expected + len(part.twin.block)


def test_the_counts_are_plain_values():
    import json

    counts = render(_scene()).counts
    assert json.loads(json.dumps(counts)) == counts
    assert counts["milliseconds"].keys() == set(counts["passes"])


def test_a_renderer_needs_no_state_that_others_leave():
    ctx = device().ctx
    first = Renderer().render(_scene()).pixels
    ctx.enable_only(moderngl.BLEND)
    ctx.depth_func = ">"
    np.testing.assert_array_equal(Renderer().render(_scene()).pixels, first)
