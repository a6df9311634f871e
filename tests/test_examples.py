"""Every example runs, as its own head says, in an empty folder."""

import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
ARGUMENTS = {"synthesize.py": ["out.csv"]}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs(example, tmp_path):
    command = [sys.executable, str(example), *ARGUMENTS.get(example.name, [])]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert len(example.read_text().splitlines()) <= 60


def test_the_embedded_sample_is_what_the_example_writes(tmp_path):
    # Oracle: the seeded generator itself, to the digits written.
    subprocess.run([sys.executable, str(ROOT / "examples" / "synthesize.py"), "out.csv"], cwd=tmp_path, check=True)
    sample = (ROOT / "fitter" / "samples" / "copper_paint.csv").read_text().splitlines()
    again = (tmp_path / "out.csv").read_text().splitlines()
    assert again[:2] == sample[:2]
    assert len(again) == len(sample)
    for mine, theirs in zip(again[2:], sample[2:], strict=True):
        for a, b in zip(mine.split(","), theirs.split(","), strict=True):
            assert float(a) == pytest.approx(float(b), rel=1e-5)
