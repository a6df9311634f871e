"""Compiled programs, each built once per process and found again by everything that went into it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import moderngl

from .context import device
from .source import ShaderError, Source, assemble

# Everything that decides a program's text: stages, sorted defines, sorted generated texts. Never a hash of it: two
# programs with one hash would be one program.
Key = tuple[tuple[str, ...], tuple[tuple[str, str], ...], tuple[tuple[str, str], ...]]


class Programs:
    """The programs of one context, and how many were compiled so far (`compiled`)."""

    def __init__(self, ctx: moderngl.Context):
        self._ctx = ctx
        self._graphics: dict[Key, moderngl.Program] = {}
        self._compute: dict[Key, moderngl.ComputeShader] = {}
        self.compiled = 0

    def graphics(
        self, vertex: str, fragment: str, defines: Mapping[str, str], generated: Mapping[str, str]
    ) -> moderngl.Program:
        """The program of a vertex and a fragment shader; raises `ShaderError` naming file and line."""
        key = _key((vertex, fragment), defines, generated)
        if key not in self._graphics:
            sources = {name: assemble(name, defines, generated) for name in (vertex, fragment)}
            try:
                self._graphics[key] = self._ctx.program(
                    vertex_shader=sources[vertex].text, fragment_shader=sources[fragment].text
                )
            except moderngl.Error as error:
                raise _shader_error(error, sources[vertex], sources[fragment]) from None
            self.compiled += 1
        return self._graphics[key]

    def compute(self, name: str, defines: Mapping[str, str], generated: Mapping[str, str]) -> moderngl.ComputeShader:
        """The program of a compute shader; raises `ShaderError` naming file and line."""
        key = _key((name,), defines, generated)
        if key not in self._compute:
            source = assemble(name, defines, generated)
            try:
                self._compute[key] = self._ctx.compute_shader(source.text)
            except moderngl.Error as error:
                raise _shader_error(error, source, source) from None
            self.compiled += 1
        return self._compute[key]


@functools.cache
def programs() -> Programs:
    """The programs of this process's context."""
    return Programs(device().ctx)


def set_uniforms(program: moderngl.Program | moderngl.ComputeShader, values: Mapping[str, Any]) -> None:
    """Sets uniforms by name, except those that the driver has removed because they do not change the result.

    How much a driver removes differs: NVIDIA's takes the camera's position out of a model that ignores `wo`.

    **Arguments:**

    - `program`: a compiled program.
    - `values`: name -> number or tuple, as moderngl takes it; of an array a list, whose end a driver may have removed.
    """
    active = set(program)
    for name, value in values.items():
        if name not in active:
            continue
        if isinstance(value, list):
            count = getattr(program[name], "array_length", len(value))
            value = value[:count] if count > 1 else value[0]
        program[name] = value


def _key(stages: tuple[str, ...], defines: Mapping[str, str], generated: Mapping[str, str]) -> Key:
    return stages, tuple(sorted(defines.items())), tuple(sorted(generated.items()))


def _shader_error(error: moderngl.Error, vertex: Source, other: Source) -> ShaderError:
    """The driver's log by our files and lines; moderngl's log says which stage failed."""
    log = str(error)
    return ShaderError((vertex if "vertex_shader" in log else other).explain(log))
