"""OpenGL without a driver or root: Mesa's off-screen library, as the PyPI wheel `lavavu-osmesa` carries it.

`Loader` speaks the protocol that `moderngl.create_context(context=...)` expects of a context: it looks OpenGL
functions up by name, and is entered, left and released.

- Mesa documentation, "Off-screen Rendering" (OSMesa), and the header `GL/osmesa.h`.
"""

from __future__ import annotations

import ctypes
import pathlib
from typing import Any

_WHEEL = "lavavu-osmesa"
# Names and values from GL/osmesa.h and GL/gl.h.
_OSMESA_FORMAT = 0x22
_GL_RGBA = 0x1908
_OSMESA_PROFILE = 0x33
_OSMESA_CORE_PROFILE = 0x34
_OSMESA_CONTEXT_MAJOR_VERSION = 0x36
_OSMESA_CONTEXT_MINOR_VERSION = 0x37
_GL_UNSIGNED_BYTE = 0x1401


def library() -> ctypes.CDLL:
    """The loaded library of the installed wheel. Raises `LookupError` when the wheel is not installed."""
    import importlib.metadata  # not where EGL serves: it takes as long as all of this package

    try:
        files = importlib.metadata.distribution(_WHEEL).files or []
    except importlib.metadata.PackageNotFoundError:
        raise LookupError(f"the package {_WHEEL} is not installed") from None
    bundled = [pathlib.Path(str(file.locate())) for file in files if file.parts[0].endswith(".libs")]
    return _load(next((path for path in bundled if path.name.startswith("libOSMesa")), None), bundled)


def _load(wanted: pathlib.Path | None, bundled: list[pathlib.Path]) -> ctypes.CDLL:
    """Loads a library after those beside it, which it needs but, for want of a run path, does not find by itself."""
    if wanted is None:
        raise LookupError(f"the package {_WHEEL} holds no libOSMesa")
    waiting = [path for path in bundled if path != wanted]
    for _ in range(len(waiting)):
        waiting = [path for path in waiting if not _loads(path)]
    return ctypes.CDLL(str(wanted))


def _loads(path: pathlib.Path) -> bool:
    try:
        ctypes.CDLL(str(path))
    except OSError:
        return False
    return True


class Loader:
    """An OSMesa context, current in the thread that creates it.

    Raises `LookupError` when the wheel is missing and `OSError` when its library does not load or gives no context.
    """

    def __init__(self, major: int, minor: int):
        self._library = library()
        create = self._library.OSMesaCreateContextAttribs
        create.restype = ctypes.c_void_p
        create.argtypes = [ctypes.POINTER(ctypes.c_int), ctypes.c_void_p]
        self._make_current = self._library.OSMesaMakeCurrent
        self._make_current.restype = ctypes.c_ubyte
        self._make_current.argtypes = [ctypes.c_void_p, ctypes.c_void_p] + [ctypes.c_uint] + [ctypes.c_int] * 2
        self._find = self._library.OSMesaGetProcAddress
        self._find.restype = ctypes.c_void_p
        self._find.argtypes = [ctypes.c_char_p]
        attributes = [_OSMESA_FORMAT, _GL_RGBA, _OSMESA_PROFILE, _OSMESA_CORE_PROFILE]
        attributes += [_OSMESA_CONTEXT_MAJOR_VERSION, major, _OSMESA_CONTEXT_MINOR_VERSION, minor, 0]
        self._context = create((ctypes.c_int * len(attributes))(*attributes), None)
        if not self._context:
            raise OSError(f"OSMesa gave no OpenGL {major}.{minor} context")
        # One RGBA pixel: everything is drawn into framebuffer objects, but OSMesa wants a surface to be current on.
        self._pixel = (ctypes.c_ubyte * 4)()
        self.__enter__()

    def load_opengl_function(self, name: str) -> int:
        """The address of an OpenGL function, 0 when there is none."""
        return self._find(name.encode()) or 0

    def __enter__(self) -> Loader:
        if not self._make_current(self._context, self._pixel, _GL_UNSIGNED_BYTE, 1, 1):
            raise OSError("OSMesa could not make its context current")
        return self

    def __exit__(self, *exception: Any) -> None:
        """The context stays current: there is one per process."""

    def release(self) -> None:
        if self._context:
            self._library.OSMesaDestroyContext.argtypes = [ctypes.c_void_p]
            self._library.OSMesaDestroyContext(self._context)
            self._context = None
