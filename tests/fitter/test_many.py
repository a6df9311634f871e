"""Many fits side by side. Oracles: single fits, and what a killed process leaves behind."""

import dataclasses
import os
import pathlib
import signal
import subprocess
import sys
import time

import jax
import numpy as np
import pytest
from synthetic import noisy_in_log, plastic

import fitter
import fitter.fitting
from brdf import load_material
from brdf.errors import UserError
from fitter import many
from fitter.formats import table_csv

ROOT = pathlib.Path(__file__).parent.parent.parent


class Deadly(str):
    """A name that ends the process which it is sent to."""

    __slots__ = ()

    def __reduce__(self):
        return os._exit, (9,)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two measurements and one file that is none."""
    found = tmp_path_factory.mktemp("many")
    for name, alpha in (("dull", 0.3), ("sharp", 0.1)):
        table_csv.write(noisy_in_log(plastic(alpha=alpha), 1, 600), found / f"{name}.csv", True)
    (found / "bad.csv").write_text("nonsense\n1,2\n")
    return found


def run(sources, output, **options):
    cache = jax.config.values["jax_compilation_cache_dir"]
    found = fitter.fit_many(sources, "lambert+ggx", output=output, cache=cache, **options)
    return {one.name: one for one in found}


def forbid(*_):
    pytest.fail("a process was started")


def test_a_failing_file_stops_no_other_and_a_second_run_continues(folder, tmp_path, monkeypatch):
    # Oracle: the single fit.
    sources = [folder / "dull.csv", folder / "bad.csv", folder / "sharp.csv"]
    first = run(sources, tmp_path, workers=2)
    assert {name: one.kind for name, one in first.items()} == {"dull": "fitted", "bad": "failed", "sharp": "fitted"}
    assert "line 1: `nonsense`" in first["bad"].sentence
    single = fitter.fit("lambert+ggx", folder / "sharp.csv")
    kept = load_material(first["sharp"].path)
    assert float(kept.brdf.lobes[1].alpha) == pytest.approx(float(single.brdf.lobes[1].alpha), rel=1e-12)
    assert first["sharp"].errors == pytest.approx(single.errors, rel=1e-9)
    # What is there is not fitted again, and what was made otherwise is not overwritten.
    monkeypatch.setattr(many, "_side_by_side", forbid)
    second = run(sources[::2], tmp_path)
    assert {one.kind for one in second.values()} == {"kept"}
    assert second["sharp"].errors == first["sharp"].errors
    other = run(sources[::2], tmp_path, loss="cosine")
    assert {one.kind for one in other.values()} == {"failed"}
    assert "made with other options. Use --force" in other["dull"].sentence
    # With force all is fitted again.
    begun = []
    monkeypatch.setattr(many, "_side_by_side", lambda jobs, *_: begun.extend(jobs) or iter(()))
    with pytest.raises(TypeError):
        run(sources[::2], tmp_path, force=True)
    assert len(begun) == 2


def test_a_process_that_dies_takes_only_its_own_measurement_with_it(folder, tmp_path):
    # The one before it is under way when it dies.
    found = run([folder / "dull.csv", Deadly(folder / "deadly.csv"), folder / "sharp.csv"], tmp_path, workers=2)
    assert {name: one.kind for name, one in found.items()} == {"dull": "fitted", "deadly": "failed", "sharp": "fitted"}
    assert "process died" in found["deadly"].sentence


def start(folder, output, *, pipe):
    """`brdf fit` in its own process, stuck in a measurement that never comes; once `dull` is done."""
    os.mkfifo(pipe)
    sources = [str(folder / "dull.csv"), str(pipe)]
    command = [sys.executable, "-c", "from fitter.cli.main import main; main()", "fit", *sources]
    process = subprocess.Popen(
        [*command, "-m", "lambert+ggx", "-o", str(output), "--workers", "2"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "BRDF_CACHE_DIR": str(ROOT / ".pytest_cache")},
    )
    wait_for(lambda: (output / "dull.json").exists(), 60)
    return process


def wait_for(happened, seconds):
    end = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.05)


def is_empty(session):
    """Whether no process of a session is left."""
    try:
        os.killpg(session, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_killed_run_leaves_what_is_finished_and_no_process_behind(folder, tmp_path, monkeypatch):
    process = start(folder, tmp_path / "out", pipe=tmp_path / "hang.csv")
    process.kill()
    process.communicate(timeout=20)
    wait_for(lambda: is_empty(process.pid), 20)
    assert [file.name for file in (tmp_path / "out").glob("*.json")] == ["dull.json"]
    assert load_material(tmp_path / "out" / "dull.json").provenance["converged"] is True


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_an_interrupt_ends_all_at_once_without_a_traceback(folder, tmp_path):
    process = start(folder, tmp_path / "out", pipe=tmp_path / "hang.csv")
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=20)
    assert process.returncode == 130
    assert told.strip() == "brdf: stopped."
    wait_for(lambda: is_empty(process.pid), 20)


def test_what_did_not_converge_is_not_called_good_the_second_time(folder, tmp_path, monkeypatch):
    fit = fitter.fitting.fit
    monkeypatch.setattr(
        fitter.fitting, "fit", lambda *a, **k: dataclasses.replace(fit(*a, **k), converged=False, status="Stopped.")
    )
    job = many._Job(str(folder / "dull.csv"), "dull", str(tmp_path / "dull.json"), "lambert+ggx", {}, {}, False)
    first, second = many._fit_one(job), many._kept(job)
    assert (first.kind, first.is_good) == ("not converged", False)
    assert (second.kind, second.is_good, second.sentence) == ("not converged", False, "Stopped.")


def test_trouble_that_nobody_foresaw_is_one_measurement_s_own(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(fitter.fitting, "fit", lambda *a, **k: 1 / 0)
    outcome = many._fit_one(many._Job(str(folder / "dull.csv"), "dull", str(tmp_path / "d.json"), "ggx", {}, {}, False))
    assert (outcome.kind, outcome.sentence) == ("failed", "ZeroDivisionError: division by zero")


def test_a_star_names_all_members_and_names_never_collide(tmp_path):
    np.savez(tmp_path / "slices.npz", gold=np.ones((4, 6, 3)), brass=np.ones((4, 6, 3)))
    path = str(tmp_path / "slices.npz")
    assert many._named([f"{path}:*"]) == [(f"{path}:gold", "gold"), (f"{path}:brass", "brass")]
    assert many._named([f"{path}:gold", "brass.binary"]) == [(f"{path}:gold", "gold"), ("brass.binary", "brass")]
    for sources in ([f"{path}:*", "gold.binary"], ["a/x.binary", "b/x.csv"], ["x.csv", "x.csv"]):
        with pytest.raises(UserError, match="would both write"):
            many._named(sources)
    with pytest.raises(UserError, match="no measurement to fit"):
        many._named([])


def test_a_file_in_the_way_that_is_no_material_is_kept(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(many, "_side_by_side", forbid)
    (tmp_path / "dull.json").write_text("precious")
    outcome = run([folder / "dull.csv"], tmp_path)["dull"]
    assert outcome.kind == "failed"
    assert "Use --force" in outcome.sentence
    assert (tmp_path / "dull.json").read_text() == "precious"
