"""Material files: round trips, and every way to write one wrongly."""

import json

import numpy as np
import pytest

from brdf import FileError, Material, UserError, build, load_material, save_material
from brdf.material import from_dict
from brdf.registry import expression_of, lobe_models, split


@pytest.mark.parametrize("expression", ["lambert", "lambert+ggx", "oren_nayar+ggx+beckmann+ggx"])
def test_a_saved_material_reads_back_equal(expression, tmp_path):
    rng = np.random.default_rng(1)
    data = Material(build(expression)).to_dict()
    for lobe in data["parameters"].values():
        for name, value in lobe.items():
            if isinstance(value, list):
                lobe[name] = rng.random(3).tolist()
            elif isinstance(value, float):
                lobe[name] = float(rng.uniform(0.01, 1))
    data["provenance"] = {"source": "a test", "numbers": [1, 0.1]}
    material = from_dict(data)
    save_material(material, tmp_path / "m.json")
    # Every digit: equality, not closeness.
    assert load_material(tmp_path / "m.json").to_dict() == data


def test_repeated_lobes_are_numbered_from_two():
    assert list(lobe_models("ggx+lambert+ggx+ggx")) == ["ggx", "lambert", "ggx_2", "ggx_3"]
    assert expression_of(build("ggx+lambert+ggx")) == "ggx+lambert+ggx"


def test_one_number_is_grey_and_what_is_left_out_is_default():
    brdf = from_dict({"model": "lambert+ggx", "parameters": {"lambert": {"albedo": 0.25}}}).brdf
    np.testing.assert_array_equal(split(brdf)["lambert"].albedo, [0.25] * 3)
    np.testing.assert_array_equal(split(brdf)["ggx"].alpha, build("ggx").alpha)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"model": "ggx", "choices": {"masking": "neumann"}}, "`choices` is not a key of a material"),
        ([], "JSON object"),
        ({}, "`model` is missing"),
        ({"model": 3}, "not a string"),
        ({"model": "lambrt"}, "Did you mean `lambert`"),
        ({"model": ""}, "is not a model"),
        ({"model": "ggx", "parameters": []}, "one object per lobe"),
        ({"model": "ggx", "parameters": {"gxg": {}}}, "Did you mean `ggx`"),
        ({"model": "ggx", "parameters": {"ggx": 3}}, "object of parameter names"),
        ({"model": "ggx", "parameters": {"ggx": {"alhpa": 0.1}}}, "Did you mean `alpha`"),
        ({"model": "ggx", "parameters": {"ggx": {"alpha": 1.7}}}, "outside [0.0001, 1]"),
        ({"model": "ggx", "parameters": {"ggx": {"alpha": float("nan")}}}, "outside"),
        ({"model": "ggx", "parameters": {"ggx": {"alpha": "0.1"}}}, "not numeric"),
        ({"model": "ggx", "parameters": {"ggx": {"alpha": True}}}, "not numeric"),
        ({"model": "ggx", "parameters": {"ggx": {"f0": [0.1, 0.2]}}}, "holds 2 numbers"),
        ({"model": "ggx", "parameters": {"ggx": {"f0": [0.1, 0.2, -0.1]}}}, "-0.1"),
        ({"model": "ggx", "parameters": {"ggx": {"masking": "smth"}}}, "Did you mean `smith`"),
        ({"model": "ggx", "provenance": 3}, "provenance"),
        ({"model": "ggx", "parameter": {}}, "Did you mean `parameters`"),
        ({"model": "GGXX"}, "Did you mean `ggx`"),
        ({"model": "+".join(["ggx"] * 7)}, "At most 6"),
    ],
)
def test_wrong_materials_are_refused_with_the_remedy(data, sentence, tmp_path):
    with pytest.raises(UserError) as caught:
        from_dict(data)
    assert sentence in str(caught.value)
    path = tmp_path / "m.json"
    path.write_text(json.dumps(data))
    with pytest.raises(FileError) as caught:
        load_material(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "not valid JSON (line 1"),
        (b'{"model": "ggx",\n "param', "line 2"),
        (b'{"model": "ggx", "model": "ggx"}', "`model` stands twice"),
        (b'{"model": ' + b"9" * 5000 + b"}", "not valid JSON"),
        (b"\xff\xfe\x00\x01", "not text (byte 0)"),
        (b"[" * 100_000, "not valid JSON"),
        (b" " * (16 * 2**20 + 1), "larger than 16 MiB"),
    ],
)
def test_broken_files_are_named_with_the_place(content, sentence, tmp_path):
    path = tmp_path / "m.json"
    path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        load_material(path)
    assert sentence in str(caught.value)


def test_missing_files_and_folders_are_named(tmp_path):
    for path in (tmp_path / "none.json", tmp_path):
        with pytest.raises(FileError, match="cannot be read"):
            load_material(path)


def test_saving_replaces_nothing_without_force(tmp_path):
    path = tmp_path / "m.json"
    path.write_text("mine")
    with pytest.raises(FileError, match="--force"):
        save_material(from_dict({"model": "lambert"}), path)
    assert path.read_text() == "mine"
    save_material(from_dict({"model": "lambert"}), path, force=True)
    assert load_material(path).model == "lambert"
