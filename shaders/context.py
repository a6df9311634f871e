"""The headless OpenGL 4.3 context: which devices are tried, which is taken, and what `brdf doctor` prints about it.

EGL comes first, over all of its devices, hardware before software: on a machine with several GPUs device 0 is often
not the one that is meant. `GLCONTEXT_DEVICE_INDEX` names one. Then the wheel `lavavu-osmesa`. `BRDF_GL` set to `egl`
or `osmesa` forces one of the two. On Windows there is one way, WGL, the driver of the desktop.

There is one context per process, current in the thread that first asked for it; OpenGL allows no other thread.
"""

from __future__ import annotations

import dataclasses
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

import moderngl

from brdf.errors import UserError

from .osmesa import Loader

REQUIRED = 430
# EGL lists a device per GPU and one for software.
_DEVICES_MAX = 16
# How glcontext says that there are no more devices, or none at all for want of the library or a function in it. Any
# other refusal is that of one device, and the next one is tried.
_NO_MORE_DEVICES = ("requested device index", "not loaded", "not found")
# The names with versions: those without belong to development packages. Any: the stubs of moderngl call it a dict.
_EGL: dict[str, Any] = {"backend": "egl", "libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software")
_REMEDIES = {
    "linux": (
        "Install a driver (`apt-get install libegl1 libgl1`; in Docker with an NVIDIA GPU also "
        "`NVIDIA_DRIVER_CAPABILITIES=all`), or use the software renderer without root: "
        "`pip install brdf-fitter[software-gl]`."
    ),
    "win32": (
        "Install the driver of the graphics card's maker; a virtual machine or a remote desktop may need Mesa for "
        "Windows, a software renderer, instead (https://github.com/pal1000/mesa-dist-win)."
    ),
    "darwin": "macOS ends at OpenGL 4.1, so the preview does not run there. Use Linux or Windows.",
}
_REMEDY_ELSEWHERE = "Install a driver with EGL and OpenGL 4.3."
_LIMITS = (
    "GL_MAX_TEXTURE_SIZE",
    "GL_MAX_UNIFORM_BLOCK_SIZE",
    "GL_MAX_SHADER_STORAGE_BLOCK_SIZE",
    "GL_MAX_COMPUTE_WORK_GROUP_COUNT",
)


@dataclasses.dataclass(frozen=True)
class Device:
    """A context and how it was found.

    - `ctx`: the moderngl context; its objects are freed when Python forgets them.
    - `backend`: `"egl"`, `"osmesa"` or `"wgl"`.
    - `device_index`: the EGL device, `None` for the others.
    - `tried`: one sentence part per attempt, in order.
    """

    ctx: moderngl.Context
    backend: str
    device_index: int | None
    tried: tuple[str, ...]

    @property
    def renderer(self) -> str:
        return str(self.ctx.info["GL_RENDERER"])

    @property
    def is_software(self) -> bool:
        return any(word in self.renderer.lower() for word in _SOFTWARE)


_device: Device | None = None
_thread: int | None = None
_first_framebuffer: moderngl.Framebuffer | None = None


def device() -> Device:
    """The context of this process, created on the first call.

    Raises `UserError` when there is no OpenGL 4.3, naming what was tried, and `RuntimeError` in a second thread.
    """
    global _device, _thread, _first_framebuffer  # the one context per process: OpenGL itself is such a state
    if _device is None:
        _device, _thread = _open(), threading.get_ident()
        _device.ctx.gc_mode = "auto"
        # An EGL context has no framebuffer, and draws nothing, without an error in moderngl, until one is bound.
        _first_framebuffer = _device.ctx.simple_framebuffer((1, 1))
        _first_framebuffer.use()
        check(_device.ctx, "binding the first framebuffer")
    if threading.get_ident() != _thread:
        raise RuntimeError("The OpenGL context belongs to another thread. Render from the thread that rendered first.")
    return _device


def check(ctx: moderngl.Context, where: str) -> None:
    """Raises `RuntimeError` if OpenGL has recorded an error; `where` says what was being done."""
    error = ctx.error  # reading it clears it
    if error != "GL_NO_ERROR":
        raise RuntimeError(f"OpenGL reported `{error}` while {where}. `brdf doctor` describes the driver.")


def describe() -> dict[str, Any]:
    """What `brdf doctor` prints: the chosen device with its limits, and everything that was tried.

    **Returns:**

    A dictionary with `available`, `tried`, and either `problem` or `backend`, `device_index`, `vendor`, `renderer`,
    `version`, `software`, `limits`.
    """
    try:
        chosen = device()
    except UserError as error:
        return {"available": False, "tried": list(getattr(error, "tried", ())), "problem": str(error)}
    info = chosen.ctx.info
    return {
        "available": True,
        "tried": list(chosen.tried),
        "backend": chosen.backend,
        "device_index": chosen.device_index,
        "vendor": str(info["GL_VENDOR"]),
        "renderer": chosen.renderer,
        "version": str(info["GL_VERSION"]),
        "software": chosen.is_software,
        "limits": {name: info[name] for name in _LIMITS},
    }


class ContextError(UserError):
    """No OpenGL 4.3 context; `tried` lists the attempts."""

    exit_status = 1

    def __init__(self, tried: list[str]):
        self.tried = tuple(tried)
        remedy = _REMEDIES.get(sys.platform, _REMEDY_ELSEWHERE)
        super().__init__(f"There is no OpenGL 4.3 here. Tried: {'; '.join(tried)}. {remedy}")


def _open() -> Device:
    ways = _ways()
    forced = os.environ.get("BRDF_GL", "")
    if forced not in ("", *ways):
        raise UserError(
            f"`BRDF_GL={forced}` is not a way to OpenGL here. Set it to `{'` or `'.join(ways)}`, or unset it."
        )
    tried: list[str] = []
    for name in [forced] if forced else ways:
        found = ways[name](tried)
        if found is not None:
            return dataclasses.replace(found, tried=tuple(tried))
    raise ContextError(tried)


def _ways() -> dict[str, Callable[[list[str]], Device | None]]:
    """The ways to OpenGL on this system, in the order in which they are tried; each adds to what was tried."""
    if sys.platform == "win32":
        return {"wgl": _open_wgl}
    return {"egl": _open_egl, "osmesa": _open_osmesa}


def _open_egl(tried: list[str]) -> Device | None:
    """The first hardware device of EGL, else its first software device, else `None`."""
    named = os.environ.get("GLCONTEXT_DEVICE_INDEX")
    if named and not named.isdecimal():
        raise UserError(f"`GLCONTEXT_DEVICE_INDEX={named}` is not a device number. Set it to 0, 1, ... or unset it.")
    software: Device | None = None
    for index in [int(named)] if named else range(_DEVICES_MAX):
        settings: dict[str, Any] = {**_EGL, "device_index": index}
        try:
            ctx = moderngl.create_context(require=REQUIRED, standalone=True, **settings)
        except Exception as error:  # glcontext raises bare `Exception`, moderngl ValueError for a low version
            tried.append(f"EGL device {index}: {_one_line(error)}")
            if any(words in str(error) for words in _NO_MORE_DEVICES):
                break
            continue
        found = Device(ctx, "egl", index, ())
        tried.append(f"EGL device {index}: {found.renderer}")
        if not found.is_software:
            return found
        software = software or found
    if software is None:
        return None
    # A later, refused device may have been made current meanwhile.
    software.ctx.__enter__()
    return software


def _open_wgl(tried: list[str]) -> Device | None:
    """What Windows gives: glcontext makes a hidden window there."""
    try:
        ctx = moderngl.create_context(require=REQUIRED, standalone=True)
    except Exception as error:  # as for EGL
        tried.append(f"WGL: {_one_line(error)}")
        return None
    found = Device(ctx, "wgl", None, ())
    tried.append(f"WGL: {found.renderer}")
    return found


def _open_osmesa(tried: list[str]) -> Device | None:
    try:
        settings: dict[str, Any] = {"context": Loader(REQUIRED // 100, REQUIRED // 10 % 10)}
        ctx = moderngl.create_context(require=REQUIRED, standalone=True, **settings)
    except (LookupError, OSError, ValueError) as error:
        tried.append(f"OSMesa: {_one_line(error)}")
        return None
    found = Device(ctx, "osmesa", None, ())
    tried.append(f"OSMesa: {found.renderer}")
    return found


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
