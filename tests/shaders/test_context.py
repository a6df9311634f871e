"""The context: what is said when there is none, and that OpenGL's own errors are heard."""

from __future__ import annotations

import threading

import moderngl
import pytest

import brdf
from shaders import context, osmesa


def test_without_opengl_the_error_names_what_was_tried_and_the_remedy(monkeypatch: pytest.MonkeyPatch):
    def refuse(**_: object) -> None:
        raise ValueError("no such device")

    def absent() -> None:
        raise LookupError("the package lavavu-osmesa is not installed")

    monkeypatch.setattr(moderngl, "create_context", refuse)
    monkeypatch.setattr(osmesa, "library", absent)
    monkeypatch.setattr(context, "_device", None)
    monkeypatch.delenv("BRDF_GL", raising=False)
    monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
    with pytest.raises(brdf.UserError, match="apt-get install libegl1 libgl1") as raised:
        context.device()
    assert "EGL device 0: no such device" in str(raised.value)
    assert "lavavu-osmesa is not installed" in str(raised.value)
    found = context.describe()
    assert not found["available"]
    assert len(found["tried"]) == 2


@pytest.mark.parametrize(("name", "value"), [("BRDF_GL", "vulkan"), ("GLCONTEXT_DEVICE_INDEX", "first")])
def test_a_mistyped_environment_variable_is_named(monkeypatch: pytest.MonkeyPatch, name: str, value: str):
    monkeypatch.setattr(context, "_device", None)
    monkeypatch.delenv("BRDF_GL", raising=False)
    monkeypatch.setenv(name, value)
    with pytest.raises(brdf.UserError, match=f"`{name}={value}`"):
        context.device()


@pytest.mark.gpu
def test_the_description_names_the_device_and_its_limits():
    found = context.describe()
    assert found["renderer"] in found["tried"][0] or len(found["tried"]) > 1
    assert found["limits"]["GL_MAX_TEXTURE_SIZE"] >= 16384
    assert isinstance(found["software"], bool)


@pytest.mark.gpu
def test_an_opengl_error_is_raised_with_its_place():
    ctx = context.device().ctx
    ctx.error  # noqa: B018  reading the error clears it
    with pytest.raises(moderngl.Error):
        ctx.texture((4, 4), 4, samples=3)
    context.check(ctx, "doing nothing")


@pytest.mark.gpu
def test_another_thread_is_told_that_it_has_no_context():
    context.device()
    raised: list[Exception] = []

    def ask() -> None:
        try:
            context.device()
        except RuntimeError as error:
            raised.append(error)

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    assert "another thread" in str(raised[0])
