"""The command line through its real entry point: results, files, exit codes and messages."""

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

import brdf
from brdf.material import from_dict, save_material

ROOT = pathlib.Path(__file__).parent.parent
SAMPLE = ROOT / "fitter" / "samples" / "copper_paint.csv"
BRDF = pathlib.Path(sys.executable).parent / "brdf"


def run(*arguments, cwd=None, status=0):
    """Runs `brdf` and returns the finished process; a traceback is never right."""
    environment = os.environ | {"JAX_ENABLE_X64": "0"}
    done = subprocess.run(
        [str(BRDF), *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=300, env=environment
    )
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == status, done.stderr
    return done


@pytest.fixture(scope="module")
def material(tmp_path_factory):
    path = tmp_path_factory.mktemp("material") / "gold.json"
    lobes = {"lambert": {"albedo": [0.05, 0.04, 0.03]}, "ggx": {"f0": [0.9, 0.7, 0.4], "alpha": 0.2}}
    save_material(from_dict({"model": "lambert+ggx", "parameters": lobes}), path)
    return path


@pytest.fixture(scope="module")
def directions(tmp_path_factory):
    path = tmp_path_factory.mktemp("directions") / "dirs.npz"
    rng = np.random.default_rng(1)
    w = rng.normal(size=(2, 500, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    np.savez(path, wi=w[0], wo=w[1])
    return path


def test_help_names_every_command_and_ends_in_an_example():
    out = run("--help").stdout
    names = {file.stem for file in (ROOT / "fitter" / "cli").glob("[!_]*.py")} - {"__init__", "main", "options"}
    for name in names:
        assert name in out
        assert "Example:" in run(name, "--help").stdout


def test_fit_writes_material_plot_and_report(tmp_path):
    out = run("fit", SAMPLE, "--model", "lambert+ggx", "-o", "m.json", "--plot", "m.png", cwd=tmp_path)
    assert "ggx.alpha" in out.stdout
    assert "reading" in out.stderr
    assert "reading" not in out.stdout
    fitted = brdf.load_material(tmp_path / "m.json").to_dict()["parameters"]
    # Oracle: the truth at the head of the sample; 3 % noise on 916 samples.
    assert fitted["ggx"]["alpha"] == pytest.approx(0.18, rel=0.01)
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(os.listdir(tmp_path)) == ["m.json", "m.png"]


def test_fit_json_has_the_promised_keys_and_nothing_else_on_stdout():
    out = run("fit", SAMPLE, "--model", "lambert+beckmann", "--fix", "alpha=0.2", "--json")
    data = json.loads(out.stdout)
    assert {"material", "errors", "status", "seconds", "samples", "dropped"} <= set(data)
    assert data["errors"]["log_mae"] > 0
    assert data["material"]["parameters"]["beckmann"]["alpha"] == 0.2


def test_evaluate_gives_the_material_in_float64(material, directions, tmp_path):
    run("evaluate", material, "--directions", directions, "-o", tmp_path / "v.npz")
    given, found = np.load(directions), np.load(tmp_path / "v.npz")
    np.testing.assert_array_equal(found["wi"], given["wi"])
    np.testing.assert_array_equal(found["wo"], given["wo"])
    # Oracle: the model called from Python; (n, 3), below the horizon 0.
    expected = brdf.evaluate(brdf.load_material(material).brdf, given["wi"], given["wo"])
    np.testing.assert_allclose(found["value"], expected, rtol=1e-12)
    assert (found["value"][(given["wi"][:, 2] < 0) | (given["wo"][:, 2] < 0)] == 0).all()


@pytest.mark.gpu
def test_evaluate_on_the_gpu_agrees(material, directions, tmp_path):
    run("evaluate", material, "--directions", directions, "-o", tmp_path / "cpu.npz")
    run("evaluate", material, "--directions", directions, "-o", tmp_path / "gpu.npz", "--gpu")
    cpu, gpu = (np.load(tmp_path / name)["value"] for name in ("cpu.npz", "gpu.npz"))
    np.testing.assert_allclose(gpu, cpu, rtol=2e-4, atol=1e-7)


@pytest.mark.gpu
def test_preview_writes_png_and_linear_exr(material, tmp_path):
    for name in ("m.png", "m.exr"):
        out = run("preview", material, "-o", name, "--size", "48x32", cwd=tmp_path)
        assert "48x32" in out.stdout
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "m.exr").read_bytes().startswith(b"\x76\x2f\x31\x01")


@pytest.mark.gpu
def test_demo_fits_reports_and_renders(tmp_path):
    run("demo", "-o", "out", cwd=tmp_path)
    assert sorted(os.listdir(tmp_path / "out")) == ["copper.json", "fit.png", "preview.png", "report.txt"]
    assert "already" in run("demo", "-o", "out", cwd=tmp_path, status=1).stderr


def test_models_info_and_doctor_answer(material):
    assert "oren_nayar" in run("models").stdout
    page = run("models", "ggx").stdout
    assert "Walter" in page
    assert "masking" in page
    assert json.loads(run("models", "ggx", "--json").stdout)["ggx"]["parameters"]["alpha"]["upper"] == 1
    assert "lambert+ggx" in run("info", material).stdout
    assert json.loads(run("info", SAMPLE, "--json").stdout)["samples"] == 916
    done = subprocess.run([str(BRDF), "doctor"], capture_output=True, text=True, timeout=120)
    assert "previews" in done.stdout
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["fit"], 2, "Missing argument"),
        (["nonsense"], 2, "No such command"),
        (["fit", SAMPLE], 2, "--model"),
        (["fit", "none.binary", "-m", "ggx"], 1, "none.binary"),
        (["fit", SAMPLE, "-m", "gxg"], 2, "Did you mean `ggx`"),
        (["fit", SAMPLE, "-m", "ggx", "-o", "m.txt"], 2, "does not end in .json"),
        (["fit", SAMPLE, "-m", "ggx", "-o", "no/such/m.json"], 1, "does not exist"),
        (["fit", SAMPLE, "-m", "ggx", "--fix", "alpha"], 2, "name=value"),
        (["fit", SAMPLE, "-m", "ggx", "--fix", "alpha=wide"], 2, "not numeric"),
        (["fit", SAMPLE, "-m", "ggx", "--max-theta-deg", "100"], 2, "(0, 90]"),
        (["fit", SAMPLE, "-m", "ggx", "--max-theta-deg", "nan"], 2, "(0, 90]"),
        (["models", "disnee"], 2, "is not a model"),
        (["info", "none.csv"], 1, "none.csv"),
        (["evaluate", SAMPLE, "--directions", "none.npz", "-o", "v.npz"], 1, "none.npz"),
        (["preview", "none.json", "-o", "m.png"], 1, "none.json"),
        (["preview", "none.json", "-o", "m.jpg"], 2, "does not end in .png or .exr"),
        (["preview", "none.json", "-o", "m.png", "--size", "big"], 2, "512x512"),
    ],
)
def test_mistakes_get_one_message_and_the_right_exit_status(arguments, status, message, tmp_path):
    done = run(*arguments, cwd=tmp_path, status=status)
    assert message in done.stderr
    assert done.stdout == ""
    assert os.listdir(tmp_path) == []


def test_nothing_is_overwritten_without_force(tmp_path):
    (tmp_path / "m.json").write_text("mine")
    done = run("fit", SAMPLE, "-m", "lambert+ggx", "-o", "m.json", cwd=tmp_path, status=1)
    assert "--force" in done.stderr
    assert (tmp_path / "m.json").read_text() == "mine"
    run("fit", SAMPLE, "-m", "lambert+ggx", "-o", "m.json", "--force", cwd=tmp_path)
    assert brdf.load_material(tmp_path / "m.json").model == "lambert+ggx"


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"wi": np.eye(3)}, "lacks `wo`"),
        ({"wi": np.eye(3), "wo": np.eye(3)[:2]}, "rows"),
        ({"wi": np.eye(3), "wo": np.eye(3) * 2}, "length"),
        ({"wi": np.eye(3), "wo": np.full((3, 3), np.nan)}, "length"),
        ({"wi": np.eye(4), "wo": np.eye(4)}, "shape"),
        ({"wi": np.array([None]), "wo": np.eye(3)}, "plain arrays"),
    ],
)
def test_wrong_directions_are_named(arrays, message, material, tmp_path):
    np.savez(tmp_path / "dirs.npz", **arrays)
    done = run("evaluate", material, "-d", tmp_path / "dirs.npz", "-o", tmp_path / "v.npz", status=1)
    assert message in done.stderr
    assert "dirs.npz" in done.stderr


def test_a_measurement_is_evaluated_by_its_own_interpolation(shared, tmp_path):
    table = np.load(shared / "oracle" / "rgl_paper_white_rgb.npz")
    np.savez(tmp_path / "dirs.npz", wi=table["wi"], wo=table["wo"])
    source = shared / "data" / "rgl_bsdf" / "paper_white_rgb.bsdf"
    run("evaluate", source, "-d", tmp_path / "dirs.npz", "-o", tmp_path / "v.npz")
    truth = table["si_wi_is_wi"]
    difference = np.abs(np.load(tmp_path / "v.npz")["value"] - truth) / np.maximum(np.abs(truth), 1e-3)
    assert np.median(difference) < 1e-4


@pytest.mark.gpu
def test_preview_prints_its_counts_and_draws_its_plan(material, tmp_path):
    out = run(
        "preview",
        material,
        "-o",
        "m.png",
        "--size",
        "16",
        "--tier",
        "still",
        "--stats",
        "--graph",
        "m.svg",
        cwd=tmp_path,
    )
    assert re.search(r"surface_still +run +[\d.]+ ms", out.stdout)
    assert re.search(r"blurred_sky +dropped +disabled", out.stdout)
    assert re.search(r"bytes uploaded +[\d,]+", out.stdout)
    # Oracle: the SVG parses, and has a box for each pass that was declared.
    texts = [node.text for node in ElementTree.parse(tmp_path / "m.svg").iter() if node.tag.endswith("text")]
    assert {"surface_still", "surface_truth", "tone_map"} <= set(texts)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--tier", "still", "--error", "0.01"], "--error 0.01 needs --tier truth"),
        (["--tier", "still", "--seconds", "3"], "--seconds 3 needs --tier truth"),
        (["--stats", "--json"], "--json holds the statistics already"),
        (["--tier", "truth", "--error", "0"], "`error = 0.0` is outside"),
        (["--graph", "m.png"], "does not end in .svg"),
        (["--sky", "off"], "'sharp', 'blurred', 'none'"),
    ],
)
def test_preview_refuses_options_that_do_not_go_together(material, tmp_path, arguments, complaint):
    out = run("preview", material, "-o", "m.png", "--size", "16", *arguments, cwd=tmp_path, status=2)
    assert complaint in out.stderr
    assert os.listdir(tmp_path) == []


@pytest.mark.gpu
@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT for one process")
def test_a_preview_that_is_interrupted_leaves_nothing(material, tmp_path):
    arguments = ["preview", str(material), "-o", "m.png", "--size", "64", "--tier", "truth", "--error", "0.00001"]
    command = [sys.executable, "-c", "from fitter.cli.main import main; main()", *arguments]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert process.stderr.readline().startswith("rendering")
    process.send_signal(signal.SIGINT)
    assert "brdf: stopped." in process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert os.listdir(tmp_path) == []
