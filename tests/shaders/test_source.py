"""Shader assembly: includes, cycles and compile errors by file and line. Oracle: hand-made files."""

from __future__ import annotations

import pathlib

import pytest

from shaders import source
from shaders.source import ShaderError, assemble


@pytest.fixture
def glsl(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    monkeypatch.setattr(source, "GLSL", tmp_path)
    return tmp_path


def test_an_include_stands_in_its_place_once(glsl: pathlib.Path):
    (glsl / "a").write_text('#include "b"\n#include "c"\nint a;\n')
    (glsl / "b").write_text('#include "c"\nint b;\n')
    (glsl / "c").write_text("int c;\n")
    lines = assemble("a", {"Z": "2", "B": "1"}, {}).text.splitlines()
    assert lines == [source.VERSION, "#define B 1", "#define Z 2", "int c;", "int b;", "int a;"]


def test_a_generated_text_is_included_by_name(glsl: pathlib.Path):
    (glsl / "a").write_text('#include "made"\n')
    assert "int made;" in assemble("a", {}, {"made": "int made;\n"}).text


def test_a_cycle_is_an_error_that_names_its_chain(glsl: pathlib.Path):
    (glsl / "a").write_text('#include "b"\n')
    (glsl / "b").write_text('#include "c"\n')
    (glsl / "c").write_text('#include "b"\n')
    with pytest.raises(ShaderError, match="b -> c -> b"):
        assemble("a", {}, {})


def test_a_missing_include_is_an_error_that_names_who_wants_it(glsl: pathlib.Path):
    (glsl / "a").write_text('#include "b"\n')
    (glsl / "b").write_text('#include "gone"\n')
    with pytest.raises(ShaderError, match=r"`gone`, included by a -> b"):
        assemble("a", {}, {})


@pytest.mark.parametrize("log", ["0:4(12): error: no", "0(4) : error C1: no", "ERROR: 0:4: no"])
def test_a_log_of_every_driver_is_explained_by_file_and_line(glsl: pathlib.Path, log: str):
    (glsl / "a").write_text('int a;\n#include "b"\n')
    (glsl / "b").write_text("int b;\nint wrong;\n")
    assert assemble("a", {}, {}).explain(f"failed\n{log}") == f"failed\nb:2: {log}"


@pytest.mark.gpu
def test_a_compile_error_names_file_and_line_of_the_stage_that_failed(glsl: pathlib.Path):
    from shaders.context import device
    from shaders.program import Programs

    (glsl / "v").write_text("void main() { gl_Position = vec4(0.0); }\n")
    (glsl / "f").write_text('#include "helper"\nout vec4 c;\nvoid main() { c = vec4(helper()); }\n')
    (glsl / "helper").write_text("float helper() {\n    return undeclared;\n}\n")
    with pytest.raises(ShaderError, match=r"helper:2: .*undeclared"):
        Programs(device().ctx).graphics("v", "f", {}, {})


@pytest.mark.gpu
def test_a_program_is_compiled_once_per_defines_and_text(glsl: pathlib.Path):
    from shaders.context import device
    from shaders.program import Programs

    (glsl / "c").write_text('layout(local_size_x = 1) in;\n#include "made"\nvoid main() {}\n')
    programs = Programs(device().ctx)
    first = programs.compute("c", {"A": "1"}, {"made": "int x;"})
    assert programs.compute("c", {"A": "1"}, {"made": "int x;"}) is first
    assert programs.compute("c", {"A": "2"}, {"made": "int x;"}) is not first
    assert programs.compute("c", {"A": "1"}, {"made": "int y;"}) is not first
    assert programs.compiled == 3
