"""Compiled programs that are kept: in memory between calls, on disk between processes.

JAX's own compilation cache keeps what the compiler made, but a new process must trace the program again to find it,
which for a fit takes longer than the fit. A program is kept here under a name that its caller knows without tracing,
together with what it depends on: our own source, the versions of JAX, and the processor. On disk they lie in the folder
`programs` of JAX's compilation cache, if one is set.

A program that calls LAPACK cannot be kept (it crashes when it is loaded): the caller sees to it that it does not.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pathlib
import pickle
import platform
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jaxlib.version
from jax.experimental import serialize_executable

from brdf.atomic import atomic_path

# What may change a program: the models, and the modules that turn them into passes over samples.
_SOURCES = ("brdf/**/*.py", *(f"fitter/{name}.py" for name in ("levenberg", "loss", "normal", "samples", "unknowns")))
_programs: dict[str, Callable[..., Sequence[jax.Array]]] = {}


def kept(name: str, fn: Callable[..., tuple[Any, ...]], arguments: Sequence[Any]) -> Callable[..., Sequence[jax.Array]]:
    """The compiled program of a function of arrays, loaded if it is known.

    **Arguments:**

    - `name`: says everything that decides about the function but the shapes of its arguments.
    - `fn`: from arrays to a tuple of arrays.
    - `arguments`: an example; later calls pass arrays of the same shapes and types.
    """
    shapes = ",".join(f"{argument.dtype}{argument.shape}" for argument in arguments)
    key = hashlib.sha256(f"{_surroundings()}|{name}|{shapes}".encode()).hexdigest()
    if key not in _programs:
        _programs[key] = _load(key) or _compile(key, fn, arguments)
    return _programs[key]


@functools.cache
def _surroundings() -> str:
    """What a compiled program depends on besides its own definition."""
    root = pathlib.Path(__file__).parent.parent
    digest = hashlib.sha256()
    for pattern in _SOURCES:
        for path in sorted(root.glob(pattern)):
            digest.update(path.read_bytes())
    device = jax.devices()[0]
    return f"{digest.hexdigest()}|{jax.__version__}|{jaxlib.version.__version__}|{device.platform}|{_processor()}"


def _processor() -> str:
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.machine())


def _folder() -> pathlib.Path | None:
    base = jax.config.values["jax_compilation_cache_dir"]
    return pathlib.Path(base) / "programs" if base else None


def _load(key: str) -> Callable[..., Sequence[jax.Array]] | None:
    folder = _folder()
    if folder is None or not (folder / key).is_file():
        return None
    try:
        return serialize_executable.deserialize_and_load(*pickle.loads((folder / key).read_bytes()))
    except Exception:
        # Whatever is wrong with a kept program, compiling it anew is right.
        with contextlib.suppress(OSError):
            (folder / key).unlink()
        return None


def _compile(key: str, fn: Callable[..., tuple[Any, ...]], arguments: Sequence[Any]) -> Callable[..., Sequence[Any]]:
    fn.__name__ = f"brdf_{key[:16]}"
    compiled = jax.jit(fn).lower(*arguments).compile()
    folder = _folder()
    if folder is not None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with atomic_path(folder / key, force=True) as temporary:
                temporary.write_bytes(pickle.dumps(serialize_executable.serialize(compiled)))
        except Exception:
            # A backend that cannot serialise, or a full disk: the program serves this process all the same.
            return compiled
    return compiled
