"""`brdf data`, `brdf synthesize` and the findings of `brdf info`, through the real entry point."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from data_server import DataServer

import brdf
import fitter
from brdf.material import from_dict, save_material
from fitter.datasets.catalogue import find

BRDF = pathlib.Path(sys.executable).parent / "brdf"
# The catalogue knows the length of a MERL table and of no RGL file: a small one passes for that.
MINT = find("chm_light_blue").magic + bytes(5000)


@pytest.fixture
def server():
    running = DataServer()
    running.files["chm_light_blue_rgb.bsdf"] = MINT
    yield running
    running.close()


def environment(folder, server):
    clean = {name: value for name, value in os.environ.items() if not name.lower().endswith("_proxy")}
    address = {"BRDF_DATA_URL": server.url} if server else {}
    return clean | {"BRDF_DATA": str(folder), "JAX_ENABLE_X64": "0"} | address


def run(*arguments, folder, server=None, status=0):
    done = subprocess.run(
        [str(BRDF), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=folder,
        env=environment(folder / "data", server),
    )
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == status, done.stderr
    return done


def test_get_prints_nothing_but_the_path_and_the_licence_first(server, tmp_path):
    done = run("data", "get", "chm_light_blue", folder=tmp_path, server=server)
    path = tmp_path / "data" / "rgl" / "chm_light_blue_rgb.bsdf"
    assert done.stdout == f"{path}\n"
    assert path.read_bytes() == MINT
    assert done.stderr.index("CC0") < done.stderr.index("downloading")
    again = run("data", "get", "chm_light_blue", folder=tmp_path, server=server)
    assert (again.stdout, again.stderr) == (done.stdout, "")
    assert len(server.requests) == 1


def test_quiet_leaves_the_licence_alone_and_folder_and_address_can_be_named(server, tmp_path):
    arguments = ["data", "get", "chm_light_blue_rgb", "-q", "-o", "here", "--base-url", server.url]
    done = run(*arguments, folder=tmp_path)
    assert "CC0" in done.stderr
    assert "downloading" not in done.stderr
    assert (tmp_path / "here" / "rgl" / "chm_light_blue_rgb.bsdf").exists()
    assert done.stdout == "here/rgl/chm_light_blue_rgb.bsdf\n"


def test_list_tells_what_is_here(server, tmp_path):
    run("data", "get", "chm_light_blue", folder=tmp_path, server=server)
    facts = json.loads(run("data", "list", "light_blue", "--json", folder=tmp_path).stdout)
    assert [(fact["name"], fact["here"], fact["bytes"]) for fact in facts] == [
        ("chm_light_blue_rgb", True, len(MINT)),
        ("chm_light_blue_spec", False, None),
    ]
    rows = run("data", "list", "*light_blue*", folder=tmp_path).stdout.splitlines()
    assert [row.split()[-1] for row in rows] == ["here", "yes", "1.0"]
    assert len(run("data", "list", folder=tmp_path).stdout.splitlines()) == 1 + 225


def test_a_server_that_lacks_the_file_is_one_sentence(server, tmp_path):
    done = run("data", "get", "chrome", folder=tmp_path, server=server, status=1)
    assert "HTTP 404" in done.stderr
    assert "brdf data get merl" in done.stderr
    assert done.stdout == ""
    assert [path for path in (tmp_path / "data").rglob("*") if path.is_file()] == []


def test_offline_is_said(server, tmp_path):
    server.close()
    done = run("data", "get", "chrome", folder=tmp_path, server=server, status=1)
    assert "may be offline" in done.stderr
    assert "Connection refused" in done.stderr


def test_ctrl_c_leaves_nothing_behind(server, tmp_path):
    server.faults["chm_light_blue_rgb.bsdf"] = ["stall"]
    process = subprocess.Popen(
        [str(BRDF), "data", "get", "chm_light_blue"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(tmp_path, server),
    )
    for _ in range(600):
        if server.requests:
            break
        time.sleep(0.05)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert out == ""
    assert err.rstrip().endswith("brdf: stopped.")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_synthesize_writes_the_measurement_and_the_truth(tmp_path):
    # Oracle: the parameters asked for, and the model itself at the directions written.
    settings = ["--set", "alpha=0.2", "--set", "ggx.f0=.9,.7,.4", "--set", "albedo=0.1", "--set", "masking=v_cavity"]
    arguments = ["synthesize", "lambert+ggx", *settings, "--samples", "200"]
    done = run(*arguments, "-o", "s.csv", "--truth", "t.json", folder=tmp_path)
    assert "200 samples of lambert+ggx" in done.stdout
    assert sorted(os.listdir(tmp_path)) == ["s.csv", "t.json"]
    truth = brdf.load_material(tmp_path / "t.json")
    ggx = truth.to_dict()["parameters"]["ggx"]
    assert (ggx["alpha"], ggx["f0"], ggx["masking"]) == (0.2, [0.9, 0.7, 0.4], "v_cavity")
    data = fitter.read(tmp_path / "s.csv")
    np.testing.assert_allclose(data.value, brdf.evaluate(truth.brdf, data.wi, data.wo), rtol=1e-12)


def test_synthesize_from_a_material_says_so_in_json(tmp_path):
    material = from_dict({"model": "lambert+ggx", "parameters": {"ggx": {"alpha": 0.3}}})
    save_material(material, tmp_path / "m.json")
    arguments = ["synthesize", "m.json", "--layout", "goniometer", "-o", "s.tsv", "--seed", "3", "--noise", "0.5", "-q"]
    facts = json.loads(run(*arguments, "--json", folder=tmp_path).stdout)
    assert facts["samples"] == 916
    assert facts["truth"]["parameters"]["ggx"]["alpha"] == 0.3
    # Oracle: the same from Python.
    data = fitter.synthesize(material, layout="goniometer", seed=3, noise=0.5)
    np.testing.assert_allclose(fitter.read(tmp_path / "s.tsv").value, data.value, rtol=1e-6)
    assert facts["clamped"] == data.clamped > 0


def test_a_binary_is_a_merl_table(tmp_path):
    run("synthesize", "lambert", "--samples", "500", "-o", "t.binary", folder=tmp_path)
    data = fitter.read(tmp_path / "t.binary")
    assert len(data) == 500
    np.testing.assert_allclose(data.value, 0.5 / np.pi, rtol=1e-6)


def test_info_ends_in_what_was_found(tmp_path):
    data = fitter.synthesize("lambert+ggx", layout="goniometer", samples=600, noise=0.02)
    lines = (f"{i[0]},{i[1]},{i[2]},{o[0]},{o[1]},{o[2]},{100 * v[0]},{v[1]},{v[2]}" for i, o, v in rows(data))
    text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,r,g,b\n" + "\n".join(lines)
    (tmp_path / "percent.csv").write_text(text)
    last = run("info", "percent.csv", folder=tmp_path).stdout.splitlines()[-2:]
    assert any(line.startswith("scale: ") and "1/sr" in line for line in last)
    facts = json.loads(run("info", "percent.csv", "--json", "--channels", "bgr", folder=tmp_path).stdout)
    assert "scale" in [finding["name"] for finding in facts["findings"]]
    assert facts["value"]["b"]["100%"] == pytest.approx(100 * data.value[:, 0].max())


def rows(data):
    return zip(data.wi.tolist(), data.wo.tolist(), data.value.tolist(), strict=True)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["data", "get"], 2, "Missing argument 'NAME...'"),
        (["data", "get", "crome"], 2, "Did you mean `chrome`"),
        (["data", "fetch", "chrome"], 2, "No such command"),
        (["data", "list", "unobtainium"], 2, "No data set matches"),
        (["data", "get", "chrome", "--base-url", "mirror", "-q"], 1, "not a web address"),
        (["synthesize", "lambert"], 2, "--output"),
        (["synthesize", "lambert", "-o", "s.txt"], 2, "does not end in"),
        (["synthesize", "lambert", "-o", "no/s.csv"], 1, "does not exist"),
        (["synthesize", "lamber", "-o", "s.csv"], 2, "Did you mean `lambert`"),
        (["synthesize", "none.json", "-o", "s.csv"], 1, "none.json"),
        (["synthesize", "lambert", "-o", "t.binary", "--layout", "plane"], 2, "can only hold the layout merl"),
        (["synthesize", "lambert", "-o", "s.csv", "--layout", "plan"], 2, "Did you mean `plane`"),
        (["synthesize", "lambert", "-o", "s.csv", "--set", "albedo"], 2, "name=value"),
        (["synthesize", "lambert", "-o", "s.csv", "--set", "albedo=2"], 2, "outside [0, 1]"),
        (["synthesize", "lambert", "-o", "s.csv", "--noise", "-1"], 2, "standard deviation"),
        (["synthesize", "lambert", "-o", "s.csv", "--samples", "0"], 2, "samples = 0"),
        (["synthesize", "lambert", "-o", "s.csv", "--truth", "t.txt"], 2, "does not end in .json"),
    ],
)
def test_mistakes_get_one_message_and_leave_nothing(arguments, status, message, tmp_path, brdf_here, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BRDF_DATA", str(tmp_path / "data"))
    done = brdf_here(*arguments)
    assert done.status == status
    assert message in done.stderr
    assert done.stdout == ""
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_synthesize_does_not_overwrite_without_force(tmp_path):
    (tmp_path / "s.csv").write_text("mine")
    assert "--force" in run("synthesize", "lambert", "-o", "s.csv", folder=tmp_path, status=1).stderr
    assert (tmp_path / "s.csv").read_text() == "mine"
    run("synthesize", "lambert", "-o", "s.csv", "--samples", "5", "--force", folder=tmp_path)
    assert len(fitter.read(tmp_path / "s.csv")) == 5


def test_what_was_downloaded_can_be_checked_with_sha256sum(server, tmp_path):
    # Oracle: the form that `sha256sum -c` reads: digest, two spaces, name.
    path = pathlib.Path(run("data", "get", "chm_light_blue", folder=tmp_path, server=server).stdout.strip())
    record = path.with_name(path.name + ".sha256").read_text()
    assert record == f"{hashlib.sha256(MINT).hexdigest()}  {path.name}\n"
