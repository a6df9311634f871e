"""Shader text from files: includes, defines, and where each line of the result came from.

`#include "path"` names a file below `shaders/glsl` or a generated text. Every file enters a program once, however
often it is included; the includes must form a directed graph without cycles.
"""

from __future__ import annotations

import dataclasses
import pathlib
import re
from collections.abc import Mapping

GLSL = pathlib.Path(__file__).parent / "glsl"
VERSION = "#version 430 core"

_INCLUDE = re.compile(r'\s*#include\s+"([^"]+)"\s*$')
# How drivers name a line of a compile log: Mesa `0:12(5): error`, NVIDIA `0(12) : error`, AMD and Intel `ERROR: 0:12:`.
_LOG_LINE = re.compile(r"^(?:(?:ERROR|WARNING): )?\d+[:(](\d+)")


class ShaderError(Exception):
    """A mistake in shader text: ours, not the user's. The message names file and line."""


@dataclasses.dataclass(frozen=True)
class Source:
    """One assembled shader.

    - `text`: what the compiler gets.
    - `origins`: for each line of `text`, the file it came from and its line number there, counted from 1.
    """

    text: str
    origins: tuple[tuple[str, int], ...]

    def explain(self, log: str) -> str:
        """A compiler's log with every line that names a line of `text` preceded by `file:line`."""
        explained = []
        for entry in log.splitlines():
            found = _LOG_LINE.match(entry.strip())
            number = int(found.group(1)) if found else 0
            if 1 <= number <= len(self.origins):
                file, line = self.origins[number - 1]
                entry = f"{file}:{line}: {entry.strip()}"
            explained.append(entry)
        return "\n".join(explained)


def assemble(name: str, defines: Mapping[str, str], generated: Mapping[str, str]) -> Source:
    """The text of a shader with its includes in place.

    **Arguments:**

    - `name`: the main file, such as `"pass/sky.frag"`.
    - `defines`: macro -> value, written at the top in sorted order.
    - `generated`: texts that are included by name without being files, such as `"material"`.

    **Returns:** the `Source`.

    Raises `ShaderError` for a file that does not exist, naming who includes it, and for a cycle, naming its chain.
    """
    lines = [VERSION] + [f"#define {macro} {value}" for macro, value in sorted(defines.items())]
    origins = [("<defines>", number) for number in range(1, len(lines) + 1)]
    _include(name, (), generated, set(), lines, origins)
    return Source("\n".join(lines) + "\n", tuple(origins))


def _include(
    name: str,
    chain: tuple[str, ...],
    generated: Mapping[str, str],
    done: set[str],
    lines: list[str],
    origins: list[tuple[str, int]],
) -> None:
    """Appends a file's lines, its includes first in their places, unless it is there already."""
    if name in chain:
        raise ShaderError(f"The includes form a cycle: {' -> '.join((*chain[chain.index(name) :], name))}.")
    if name in done:
        return
    for number, line in enumerate(_read(name, chain, generated).splitlines(), 1):
        included = _INCLUDE.match(line)
        if included:
            _include(included.group(1), (*chain, name), generated, done, lines, origins)
        else:
            lines.append(line)
            origins.append((name, number))
    done.add(name)


def _read(name: str, chain: tuple[str, ...], generated: Mapping[str, str]) -> str:
    if name in generated:
        return generated[name]
    try:
        return (GLSL / name).read_text(encoding="utf-8")
    except FileNotFoundError:
        by = f", included by {' -> '.join(chain)}" if chain else ""
        raise ShaderError(f"There is no shader file `{name}`{by}.") from None
