"""Twins of material files from what is kept of their models. Oracle: `material_block.twin` of the loaded material."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import brdf
from brdf.errors import UserError
from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters
from brdf.registry import combine, split
from shaders import kept_models
from shaders.kept_models import twin_of_file
from shaders.material_block import twin

EXPRESSIONS = [*brdf.MODELS, "lambert+ggx", "ggx+ggx+lambert+oren_nayar+ggx", "disney+openpbr"]


@pytest.fixture(autouse=True)
def folder(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    monkeypatch.setenv("BRDF_CACHE_DIR", str(tmp_path / "kept"))
    return tmp_path / "kept" / kept_models.FOLDER


def _random(expression: str, number: int, rng: np.random.Generator) -> AbstractBRDF:
    """A model with the options of this number, and parameters at their bounds, which may be 0, or between them."""
    lobes = {}
    for name, lobe in split(brdf.build(expression)).items():
        chosen: dict[str, Any] = {one.name: one.options[number % len(one.options)] for one in choices(lobe)}
        for one in parameters(dataclasses.replace(lobe, **chosen)):
            at_bound = rng.random() < 0.4
            value = rng.choice([one.lower, one.upper]) if at_bound else rng.uniform(one.lower, one.upper, one.size)
            chosen[one.name] = np.full(3, value) if one.size == 3 else float(np.mean(value))
        lobes[name] = dataclasses.replace(lobe, **chosen)
    return combine(lobes)


def _only_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on no model may be asked."""
    for name in ("declared", "trace"):
        monkeypatch.setattr(kept_models, name, lambda *_: pytest.fail("a model is asked although it was seen"))


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_a_file_has_the_twin_of_its_material_the_first_time_and_the_next(
    expression: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    rng = np.random.default_rng(8)
    rounds = max(
        (len(one.options) for lobe in split(brdf.build(expression)).values() for one in choices(lobe)), default=1
    )
    paths = [tmp_path / f"{number}.json" for number in range(rounds + 6)]
    for number, path in enumerate(paths):
        brdf.save_material(brdf.Material(_random(expression, number, rng)), path)
        assert twin_of_file(path) == twin(brdf.load_material(path).brdf)
    _only_kept(monkeypatch)
    for path in paths:
        assert twin_of_file(path) == twin(brdf.load_material(path).brdf)


def test_other_numbers_of_a_seen_model_need_nothing_but_what_is_kept(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    rng = np.random.default_rng(9)
    path = tmp_path / "m.json"
    path.write_text('{"model": "lambert+ggx"}')
    seen = twin_of_file(path).text
    _only_kept(monkeypatch)
    for _ in range(20):
        values = {"f0": rng.random(3).tolist(), "alpha": rng.uniform(0.01, 1), "masking": "smith"}
        path.write_text(json.dumps({"model": "lambert+ggx", "parameters": {"ggx": values, "lambert": {"albedo": 0}}}))
        found = twin_of_file(path)
        assert found.text == seen
        assert found == twin(brdf.load_material(path).brdf)


def test_lobes_of_a_sum_are_known_when_each_was_seen_somewhere(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "m.json"
    for expression in ("lambert", "disney+ggx"):
        path.write_text(json.dumps({"model": expression}))
        twin_of_file(path)
    _only_kept(monkeypatch)
    path.write_text(json.dumps({"model": "lambert+ggx+ggx"}))
    assert twin_of_file(path) == twin(brdf.build("lambert+ggx+ggx"))


def test_a_weight_of_0_is_another_structure(tmp_path: pathlib.Path):
    path = tmp_path / "m.json"
    texts = []
    for weight in (0, 0.5, 0.7, 0.0):
        path.write_text(json.dumps({"model": "openpbr", "parameters": {"openpbr": {"coat_weight": weight}}}))
        texts.append(twin_of_file(path).text)
    assert texts[0] == texts[3] != texts[1] == texts[2]
    assert "#define PROPOSALS 1\n" in texts[0]
    assert "#define PROPOSALS 2\n" in texts[1]


def test_a_strength_of_0_makes_an_anisotropic_model_isotropic(tmp_path: pathlib.Path):
    path = tmp_path / "m.json"
    for strength in (0, 0.5, 0):
        path.write_text(json.dumps({"model": "disney", "parameters": {"disney": {"anisotropic": strength}}}))
        assert twin_of_file(path).is_anisotropic == bool(strength)


def test_another_program_makes_everything_anew(tmp_path: pathlib.Path, folder: pathlib.Path, monkeypatch):
    path = tmp_path / "m.json"
    path.write_text('{"model": "lambert"}')
    twin_of_file(path)
    monkeypatch.setattr(kept_models, "_program", lambda: b"another")
    twin_of_file(path)
    assert len(list(folder.iterdir())) == 2 * 2


WRONG = [
    b"",
    b"no JSON",
    b"\xff\xfe\x00\x01",
    b"[]",
    b'{"model": 3}',
    b'{"model": "lambrt"}',
    b'{"model": "ggx", "model": "ggx"}',
    b'{"model": "ggx", "parameter": {}}',
    b'{"model": "ggx", "parameters": []}',
    b'{"model": "ggx", "parameters": {"gxg": {}}}',
    b'{"model": "ggx", "parameters": {"ggx": 3}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alhpa": 0.1}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alpha": 1.7}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alpha": NaN}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alpha": "0.1"}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alpha": true}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"alpha": 0.1, "alpha": 0.1}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"f0": [0.1, 0.2]}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"eta": 1.5}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"masking": "smth"}}}',
    b'{"model": "ggx", "parameters": {"ggx": {"masking": 1}}}',
    b'{"model": "ggx", "provenance": 3}',
    b'{"model": "ggx+ggx+ggx+ggx+ggx+ggx+ggx"}',
]


@pytest.mark.parametrize("content", WRONG)
def test_what_is_wrong_with_a_file_is_said_as_ever(content: bytes, tmp_path: pathlib.Path):
    # Oracle: what `load_material` says.
    path = tmp_path / "m.json"
    path.write_bytes(content)
    with pytest.raises(UserError) as expected:
        brdf.load_material(path)
    for seen in (False, True):
        if seen:
            (tmp_path / "seen.json").write_text('{"model": "ggx"}')
            twin_of_file(tmp_path / "seen.json")
        with pytest.raises(type(expected.value)) as found:
            twin_of_file(path)
        assert str(found.value) == str(expected.value)


def test_a_missing_file_is_named(tmp_path: pathlib.Path):
    for path in (tmp_path / "none.json", tmp_path):
        with pytest.raises(UserError, match="cannot be read"):
            twin_of_file(path)


@pytest.mark.gpu
def test_a_new_material_of_a_seen_model_under_a_new_light_is_drawn_without_jax(tmp_path: pathlib.Path):
    # Oracle: the modules of the process; the first one loads JAX. Neither needs what reads other pictures.
    program = (
        "import sys\n"
        "from fitter.cli.main import main\n"
        "try: main()\n"
        "finally: print('JAX', sorted({'jax', 'equinox', 'OpenEXR'} & sys.modules.keys()))\n"
    )
    for alpha, light, loaded in ((0.3, "studio", "['equinox', 'jax']"), (0.2, "overcast", "[]")):
        path = tmp_path / "m.json"
        path.write_text(json.dumps({"model": "lambert+ggx", "parameters": {"ggx": {"alpha": alpha}}}))
        arguments = ["preview", str(path), "-e", light, "-o", str(tmp_path / "x.png"), "--size", "32", "--force"]
        done = subprocess.run(
            [sys.executable, "-c", program, *arguments], capture_output=True, text=True, env=os.environ, timeout=120
        )
        assert done.returncode == 0, done.stderr
        assert f"JAX {loaded}\n" in done.stdout
