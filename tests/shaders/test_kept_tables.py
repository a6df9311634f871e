"""What is dear to make is kept on disk, and every trouble with the disk is no trouble. Oracle: how often it is made."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from shaders import kept_tables
from shaders.kept_tables import Arrays, kept


class _Making:
    """Makes an array and counts."""

    def __init__(self, size: int = 100):
        self.count, self.size = 0, size

    def __call__(self) -> Arrays:
        self.count += 1
        return {"numbers": np.arange(self.size, dtype=np.float32), "one": np.array(3.0)}


@pytest.fixture
def folder(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    monkeypatch.setenv("BRDF_CACHE_DIR", str(tmp_path))
    return tmp_path / "tables"


def _check(found: Arrays) -> None:
    np.testing.assert_array_equal(found["numbers"], np.arange(100))
    assert found["one"] == 3


def test_the_second_time_it_is_read(folder: pathlib.Path):
    make = _Making()
    for _ in range(2):
        _check(kept("kind", (b"a", b"b"), make))
    assert make.count == 1
    assert len(list(folder.iterdir())) == 1


def test_other_ingredients_or_another_kind_are_another_table(folder: pathlib.Path):
    make = _Making()
    for kind, ingredients in (("kind", (b"ab", b"")), ("kind", (b"a", b"b")), ("kind", (b"ab",)), ("kind-2", (b"ab",))):
        kept(kind, ingredients, make)
    assert make.count == len(list(folder.iterdir())) == 4


def test_a_damaged_file_is_made_anew(folder: pathlib.Path):
    make = _Making()
    kept("kind", (), make)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    places = np.random.default_rng(6).integers(0, len(whole), 300)
    damaged = [bytes([*whole[:i], whole[i] ^ 0xFF, *whole[i + 1 :]]) for i in [*range(60), *places.tolist()]]
    for content in (b"", b"no archive", whole[: len(whole) // 2], whole[:-1], *damaged):
        path.write_bytes(content)
        _check(kept("kind", (), make))
        # Written anew, or what was damaged does not matter.
        _check(kept("kind", (), lambda: pytest.fail("it is made although it was written")))


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    file = tmp_path / "file"
    file.write_bytes(b"")
    make = _Making()
    for base in (file, file / "below", pathlib.Path("/dev/null/x")):
        monkeypatch.setenv("BRDF_CACHE_DIR", str(base))
        _check(kept("kind", (), make))
    assert make.count == 3


def test_a_full_disk_is_no_error(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    def full(self: pathlib.Path, content: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pathlib.Path, "write_bytes", full)
    make = _Making()
    _check(kept("kind", (), make))
    assert list(folder.iterdir()) == []


def test_beyond_the_limit_what_was_not_used_for_longest_goes(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    make = _Making(1000)
    kept("kind", (b"0",), make)
    size = next(folder.iterdir()).stat().st_size
    monkeypatch.setattr(kept_tables, "_BYTES_MAX", 6 * size + size // 2)
    for number in range(1, 6):
        kept("kind", (bytes([48 + number]),), make)
    for number, path in enumerate(sorted(folder.iterdir())):
        os.utime(path, (number, number))
    kept("kind", (b"0",), make)  # used now, whatever its place was
    kept("kind", (b"6",), make)
    left = sum(one.stat().st_size for one in folder.iterdir())
    assert left <= kept_tables._BYTES_MAX // 2
    made = make.count
    for number in (b"0", b"6"):
        kept("kind", (number,), make)
    assert make.count == made == 7


def test_two_processes_at_once_do_not_disturb_each_other(folder: pathlib.Path):
    program = (
        "import numpy as np\n"
        "from shaders.kept_tables import kept\n"
        "for i in range(60):\n"
        "    found = kept('kind', (bytes([i % 7]),), lambda: {'numbers': np.full(5000, i % 7)})\n"
        "    assert (found['numbers'] == i % 7).all() and len(found['numbers']) == 5000\n"
    )
    environment = {**os.environ, "BRDF_CACHE_DIR": str(folder.parent)}
    running = [subprocess.Popen([sys.executable, "-W", "error", "-c", program], env=environment) for _ in range(2)]
    assert [one.wait(timeout=60) for one in running] == [0, 0]
    assert sorted(one.suffix for one in folder.iterdir()) == [".table"] * 7
