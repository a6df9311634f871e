"""What is printed inside is not seen, and what is printed after is. Oracle: the pipes themselves."""

from __future__ import annotations

import concurrent.futures
import os
import subprocess
import sys

import pytest

from brdf.silence import silence

_CLOSED = "import os, sys; os.close(1); sys.stdout = None\nfrom brdf.silence import silence\nwith silence(): pass"


def test_neither_python_nor_the_process_is_heard_inside(capfd: pytest.CaptureFixture[str]):
    with silence():
        print("inside")
        os.write(1, b"inside")
        os.write(2, b"inside")
    print("after", flush=True)
    os.write(2, b"after")
    assert capfd.readouterr() == ("after\n", "after")


def test_threads_do_not_keep_each_others_silence(capfd: pytest.CaptureFixture[str]):
    def be_silent(_: int) -> None:
        with silence():
            print("inside")

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        list(pool.map(be_silent, range(200)))
    print("after", flush=True)
    assert capfd.readouterr() == ("after\n", "")


def test_a_process_without_stdout_has_nothing_to_silence():
    done = subprocess.run([sys.executable, "-c", _CLOSED], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
