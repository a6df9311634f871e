"""Compiled programs that are kept. Oracle: what the function gives without any of it."""

import threading

import numpy as np
import pytest

from fitter import program

EXAMPLE = [np.arange(3.0)]


def double(x):
    return (2 * x, x.sum())


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty folder, and a process that has not compiled anything."""
    monkeypatch.setattr(program, "_folder", lambda: tmp_path / "programs")
    monkeypatch.setattr(program, "_programs", {})
    return tmp_path / "programs"


def forget(monkeypatch):
    monkeypatch.setattr(program, "_programs", {})


def check(found):
    twice, total = found(np.array([1.0, 2.0, 4.0]))
    np.testing.assert_array_equal(twice, [2, 4, 8])
    assert float(total) == 7


def test_a_kept_program_is_loaded_and_not_compiled_again(folder, monkeypatch):
    check(program.kept("double", double, EXAMPLE))
    assert len(list(folder.iterdir())) == 1
    forget(monkeypatch)
    monkeypatch.setattr(program, "_compile", lambda *_: pytest.fail("compiled"))
    check(program.kept("double", double, EXAMPLE))


@pytest.mark.parametrize("damage", [b"", b"no pickle", None])
def test_a_damaged_file_is_replaced(folder, monkeypatch, damage):
    program.kept("double", double, EXAMPLE)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    forget(monkeypatch)
    check(program.kept("double", double, EXAMPLE))
    assert len(file.read_bytes()) > len(whole) // 2
    forget(monkeypatch)
    monkeypatch.setattr(program, "_compile", lambda *_: pytest.fail("compiled"))
    check(program.kept("double", double, EXAMPLE))


def test_a_program_of_another_version_name_or_shape_is_another_file(folder, monkeypatch):
    program.kept("double", double, EXAMPLE)
    program.kept("another", double, EXAMPLE)
    program.kept("double", double, [np.arange(4.0)])
    program.kept("double", double, [np.arange(3)])
    assert len(list(folder.iterdir())) == 4
    monkeypatch.setattr(program, "_surroundings", lambda: "tomorrow's JAX")
    check(program.kept("double", double, EXAMPLE))
    assert len(list(folder.iterdir())) == 5


def test_our_own_source_decides_about_a_program(monkeypatch):
    # A changed model must not be fitted by yesterday's program.
    surroundings = program._surroundings.__wrapped__
    before = surroundings()
    assert surroundings() == before
    monkeypatch.setattr(program, "_SOURCES", program._SOURCES[1:])
    assert surroundings() != before


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file" / "programs", None):
        forget(monkeypatch)
        monkeypatch.setattr(program, "_folder", lambda folder=folder: folder)
        check(program.kept("double", double, EXAMPLE))


def test_a_damaged_file_that_cannot_be_removed_is_no_error(folder, monkeypatch):
    program.kept("double", double, EXAMPLE)
    (file,) = folder.iterdir()
    file.write_bytes(b"no pickle")
    forget(monkeypatch)

    def refuse(self, missing_ok=False):
        raise PermissionError(13, "read-only", str(self))

    monkeypatch.setattr(type(file), "unlink", refuse)
    check(program.kept("double", double, EXAMPLE))


def test_writers_at_the_same_time_leave_a_whole_file(folder, monkeypatch):
    threads = [threading.Thread(target=program._compile, args=("key", double, EXAMPLE)) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [file.name for file in folder.iterdir()] == ["key"]
    check(program._load("key"))
