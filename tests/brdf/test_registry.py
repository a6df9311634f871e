"""The declaration and the registry; the oracle is the models' own files."""

import dataclasses
import pathlib

import jax
import numpy as np
import pytest

import brdf
from brdf.parameter import slope
from brdf.registry import name_of

MODELS_FOLDER = pathlib.Path(brdf.__file__).parent / "models"


def test_every_file_holds_one_model_of_its_name():
    stems = sorted(file.stem for file in MODELS_FOLDER.glob("*.py") if file.stem != "__init__")
    assert list(brdf.MODELS) == stems
    for name, model in brdf.MODELS.items():
        assert name_of(model()) == name


@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_declarations_are_complete(name):
    model = brdf.MODELS[name]
    assert (model.__doc__ or "").strip()
    for p in brdf.parameters(model):
        assert p.lower <= p.default <= p.upper
        assert p.doc
        assert p.unit
        assert p.name == p.name.lower()
        assert all(p.lower <= start <= p.upper for start in p.starts)
        assert (p.kind == "color") == (not p.starts)
        np.testing.assert_array_equal(getattr(model(), p.name), np.full(p.size, p.default).squeeze())
    for c in brdf.choices(model):
        assert c.default in c.options
        assert c.doc


@pytest.mark.parametrize("name", list(brdf.MODELS))
def test_channels_mix_only_where_declared(name):
    # Oracle: change one channel of a colour and see which channels of the value follow.
    model = brdf.MODELS[name]()
    wi, wo = np.array([0.3, 0.2, np.sqrt(0.87)]), np.array([-0.1, 0.6, np.sqrt(0.63)])
    value = jax.jit(lambda model: model(wi, wo))
    before = np.asarray(value(model))
    for p in brdf.parameters(model):
        for channel in range(3 if p.kind == "color" else 0):
            color = np.array(getattr(model, p.name))
            color[channel] = 0.5 * color[channel] + 0.1
            changed = np.asarray(value(dataclasses.replace(model, **{p.name: color}))) != before
            changed[channel] = False
            assert bool(changed.any()) <= model.mixes_channels


def test_unknown_names_are_key_errors():
    with pytest.raises(KeyError):
        brdf.MODELS["nothing"]


def test_a_default_outside_its_bounds_is_a_mistake_of_the_model():
    with pytest.raises(ValueError, match="outside its own bounds"):
        slope(0.1, 1.0, 2.0, "too wide")
