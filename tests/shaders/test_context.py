"""The context: what is said when there is none, and that OpenGL's own errors are heard."""

from __future__ import annotations

import threading
import types
from typing import Any

import moderngl
import pytest

import brdf
from shaders import context, osmesa

# glcontext's words (egl.cpp).
REFUSED = "eglInitialize failed (0x3001)"


class _Context(moderngl.Context):
    """A context that only has a name."""

    def __init__(self, renderer: str):
        self._info = {"GL_RENDERER": renderer}

    def __enter__(self) -> _Context:
        return self

    def __del__(self) -> None:
        pass


@pytest.fixture
def pretend(monkeypatch: pytest.MonkeyPatch):
    """A machine: its `sys.platform` and its devices, each the name of a renderer or why it is refused."""

    def machine(platform: str, *devices: str) -> list[dict[str, Any]]:
        asked: list[dict[str, Any]] = []

        def create(device_index: int = 0, **settings: Any) -> Any:
            asked.append({"device_index": device_index, **settings})
            if device_index >= len(devices):
                raise Exception(f"requested device index {device_index}, but found {len(devices)} devices")
            if "failed" in devices[device_index] or "not loaded" in devices[device_index]:
                raise Exception(devices[device_index])
            return _Context(devices[device_index])

        def absent() -> None:
            raise LookupError("the package lavavu-osmesa is not installed")

        monkeypatch.setattr(moderngl, "create_context", create)
        monkeypatch.setattr(osmesa, "library", absent)
        monkeypatch.setattr(context, "_device", None)
        monkeypatch.setattr(context, "sys", types.SimpleNamespace(platform=platform))
        monkeypatch.delenv("BRDF_GL", raising=False)
        monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
        return asked

    return machine


@pytest.mark.parametrize(
    ("platform", "tried", "remedy"),
    [
        ("linux", ["EGL device 0: requested device", "lavavu-osmesa is not"], "apt-get install libegl1 libgl1"),
        ("freebsd14", ["EGL device 0: requested device", "lavavu-osmesa is not"], "Install a driver with EGL"),
        ("darwin", ["EGL device 0: requested device", "lavavu-osmesa is not"], "macOS ends at OpenGL 4.1"),
        ("win32", ["WGL: requested device"], "Mesa for Windows"),
    ],
)
def test_without_opengl_the_error_names_what_was_tried_and_the_remedy(
    pretend: Any, platform: str, tried: list[str], remedy: str
):
    pretend(platform)
    with pytest.raises(brdf.UserError, match=remedy) as raised:
        context.device()
    assert ("apt-get" in str(raised.value)) == (platform == "linux")
    found = context.describe()
    assert not found["available"]
    assert len(found["tried"]) == len(tried)
    for said, words in zip(found["tried"], tried, strict=True):
        assert words in said
        assert said in str(raised.value)


@pytest.mark.parametrize(
    ("devices", "chosen"),
    [
        ((REFUSED, "A card"), 1),
        ((REFUSED, "llvmpipe", REFUSED, "A card"), 3),
        (("llvmpipe", REFUSED, "softpipe"), 0),
        (("A card", "Another card"), 0),
    ],
)
def test_a_refused_device_does_not_end_the_search(pretend: Any, devices: tuple[str, ...], chosen: int):
    asked = pretend("linux", *devices)
    found = context._open()
    assert (found.backend, found.device_index, found.renderer) == ("egl", chosen, devices[chosen])
    # Up to the first hardware, else past the end of the list.
    assert len(asked) == (len(devices) + 1 if found.is_software else chosen + 1)
    assert [said.split(": ")[1] for said in found.tried[: chosen + 1]] == list(devices[: chosen + 1])


def test_a_missing_library_is_reported_once(pretend: Any):
    pretend("linux", *["libEGL.so.1 not loaded"] * 20)
    with pytest.raises(brdf.UserError) as raised:
        context._open()
    assert str(raised.value).count("libEGL.so.1 not loaded") == 1


def test_windows_is_asked_for_its_own_context(pretend: Any):
    asked = pretend("win32", "A card")
    assert context._open().backend == "wgl"
    assert asked == [{"device_index": 0, "require": 430, "standalone": True}]


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
    assert sum(said.endswith(f": {found['renderer']}") for said in found["tried"]) >= 1
    # What OpenGL 4.3 promises at least (its tables of implementation-dependent values).
    assert found["limits"]["GL_MAX_TEXTURE_SIZE"] >= 1024
    assert found["limits"]["GL_MAX_UNIFORM_BLOCK_SIZE"] >= 16384
    assert found["limits"]["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] >= 2**24
    assert min(found["limits"]["GL_MAX_COMPUTE_WORK_GROUP_COUNT"]) >= 65535
    assert isinstance(found["software"], bool)


@pytest.mark.gpu
def test_an_opengl_error_is_raised_with_its_place():
    ctx = context.device().ctx
    context.check(ctx, "doing nothing")
    ctx.line_width = -1.0  # refused by OpenGL, and nothing is changed
    with pytest.raises(RuntimeError, match="`GL_INVALID_VALUE` while drawing a thin line"):
        context.check(ctx, "drawing a thin line")
    context.check(ctx, "doing nothing: the error was read")


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
