"""How a picture is drawn: in tiles, within the device's limits, uniforms by name."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import numpy as np
import pytest

import brdf
from brdf.model import AbstractBRDF
from shaders import Environment, Image, Part, Renderer, Scene, frame, load_environment, render
from shaders.context import check, device
from shaders.program import set_uniforms
from shaders.scene import Sky

_SHADERS = pathlib.Path(frame.__file__).parent


def _smooth() -> Environment:
    """Light that is different everywhere."""
    across, down = np.linspace(0, np.pi, 128), np.linspace(0, np.pi, 64)[:, None]
    levels = [1.5 + np.sin(across) * np.cos(down), 1.5 + np.cos(across) * down, 2 + 0 * across + np.cos(3 * down)]
    return Environment(np.stack(levels, axis=-1).astype(np.float32), "smooth")


def _picture(material: AbstractBRDF, environment: Environment, **scene: Any) -> Image:
    return render(Scene((Part(material),), environment, **{"width": 48, "height": 48, "tone_map": "none"} | scene))


@pytest.mark.gpu
@pytest.mark.parametrize("sky", ["sharp", "none"])
def test_a_picture_drawn_in_tiles_is_the_same_to_the_last_bit(monkeypatch: pytest.MonkeyPatch, sky: Sky):
    settings: dict[str, Any] = {"width": 90, "height": 70, "samples": 56, "sky": sky, "tone_map": "neutral"}
    scene = Scene((Part(brdf.build("lambert+ggx")),), _smooth(), **settings)
    whole = Renderer().render(scene)
    monkeypatch.setattr(frame, "_TILE", 32)
    tiled = Renderer().render(scene)
    assert tiled.counts["draws"] == 9 * whole.counts["draws"]
    np.testing.assert_array_equal(tiled.pixels, whole.pixels)
    assert tiled.display is not None
    assert whole.display is not None
    np.testing.assert_array_equal(tiled.display, whole.display)


@pytest.mark.gpu
@pytest.mark.parametrize("limit", ["GL_MAX_TEXTURE_SIZE", "GL_MAX_RENDERBUFFER_SIZE"])
@pytest.mark.parametrize("size", [{"width": 65}, {"height": 65}])
def test_a_picture_larger_than_the_device_can_draw_is_refused(
    monkeypatch: pytest.MonkeyPatch, size: dict[str, int], limit: str
):
    monkeypatch.setitem(device().ctx.info, limit, 64)
    (name,) = size
    with pytest.raises(brdf.UserError, match=f"`{name} = 65` .* Set it to 64 at most"):
        _picture(brdf.build("ggx"), load_environment("furnace"), **({"width": 64, "height": 64} | size))


@pytest.mark.gpu
def test_an_environment_larger_than_the_textures_of_the_device_is_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(device().ctx.info, "GL_MAX_TEXTURE_SIZE", 100)
    with pytest.raises(brdf.UserError, match=r"`smooth` is larger than .* 100 texels"):
        _picture(brdf.build("ggx"), _smooth())


@pytest.mark.gpu
def test_a_uniform_that_the_driver_removed_is_skipped_and_the_others_are_set():
    # A driver may remove what a model ignores: lambert needs no camera position on NVIDIA. Mesa removes the unused too.
    ctx = device().ctx
    program = ctx.program(
        vertex_shader="#version 430 core\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, "
        "gl_VertexID == 2 ? 3 : -1, 0, 1); }",
        fragment_shader="#version 430 core\nuniform vec3 camera_position; uniform float level; out vec4 color;\n"
        "void main() { color = vec4(level); }",
    )
    assert "camera_position" not in list(program)
    set_uniforms(program, {"camera_position": (1.0, 2.0, 3.0), "level": 0.25})
    target = ctx.simple_framebuffer((1, 1), dtype="f4")
    target.use()
    ctx.vertex_array(program, []).render(vertices=3)
    check(ctx, "drawing a pixel")
    assert np.frombuffer(target.read(components=1, dtype="f4"), np.float32) == 0.25


def test_every_uniform_that_a_pass_sets_is_declared_in_a_shader():
    # A name that is skipped because it is misspelt would not be noticed otherwise.
    glsl = "\n".join(path.read_text(encoding="utf-8") for path in (_SHADERS / "glsl").rglob("*.*"))
    declared = set(re.findall(r"^uniform \w+ (\w+)(?:\[\w+\])?;", glsl, re.MULTILINE))
    files = [*(_SHADERS / "passes").glob("*.py"), *(_SHADERS / name for name in ("surface.py", "drawing.py"))]
    passes = "\n".join(path.read_text(encoding="utf-8") for path in files)
    # Lower case: those in capitals are macros. An included text is no uniform either.
    named = set(re.findall(r"\"([a-z_]+)\": ", passes)) - {"material"}
    assert len(named) > 10
    assert named <= declared
