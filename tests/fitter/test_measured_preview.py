"""A measurement as the preview's table: laid out or resampled as its format defines, or refused with a reason."""

from __future__ import annotations

import json

import numpy as np
import pytest
from synthetic_rgl import VARIANTS, fields, write_tensor_file

import fitter.formats
from brdf.errors import UserError
from fitter.cli._measured import material_of, tabulated
from fitter.formats import merl
from fitter.reflectance import Reflectance
from fitter.rusinkiewicz import directions

RGL = ["chm_mint", "cc_green_malachite", "irid_flake_paint1", "paper_white"]


def smooth(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Reciprocal and isotropic, no two channels alike."""
    cos_h = ((wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True))[..., 2]
    return (0.1 + cos_h[..., None] ** 20) * np.array([1.0, 0.5, 0.2])


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("merl") / "smooth.binary"
    merl.write_function(smooth, path, (30, 20, 24))
    return path


@pytest.mark.parametrize("cells", ["edge", "centre"])
def test_a_merl_table_is_taken_as_it_is(table, cells: str):
    data = fitter.formats.read(table, {"cells": cells})
    found = tabulated(data)
    assert (found.cells, found.is_reciprocal, found.holds) == (cells, True, "f")
    expected = data.grid.scatter(data.value)
    valid = np.isfinite(expected)
    np.testing.assert_array_equal(found.values[valid], expected[valid].astype(np.float32))
    assert not valid.all()


def test_holes_get_the_value_of_a_neighbour_also_around_phi_d(table):
    data = fitter.formats.read(table)
    # The cell of theta_h = 9, theta_d = 3, phi_d = 0 and its neighbours but the last of phi_d.
    row, column, layer = np.unravel_index(data.grid.index, data.grid.shape)
    hole = (abs(row - 9) <= 2) & (abs(column - 3) <= 2) & (layer <= 2)
    found = tabulated(data.select(~hole, "test")).values
    np.testing.assert_array_equal(found[9, 3, 0], found[9, 3, -1])


@pytest.mark.gpu
def test_a_merl_file_is_rendered_with_the_values_that_evaluate_gives(table):
    # Oracle: the reader's own interpolation in float64.
    from shaders import evaluate

    data = fitter.formats.read(table)
    rng = np.random.default_rng(4)
    theta_d = rng.uniform(0, 0.5, 2000)
    pairs = directions(rng.uniform(0, 0.6, 2000), theta_d, rng.uniform(-np.pi, np.pi, 2000), rng.uniform(-3, 3, 2000))
    wi, wo = (w.astype(np.float32) for w in pairs)
    np.testing.assert_allclose(evaluate(material_of(str(table)), wi, wo), data.evaluate(wi, wo), rtol=1e-5)


@pytest.mark.gpu
@pytest.mark.parametrize("name", RGL)
def test_an_rgl_file_is_resampled_within_two_percent_of_the_independent_evaluation(shared, name: str):
    # Oracle: Mitsuba 3.9 `measured`. The tail is the edge of what was measured, at grazing angles.
    from shaders import evaluate

    with np.load(shared / "oracle" / f"rgl_{name}_rgb.npz") as oracle:
        wi, wo, expected = oracle["wi"], oracle["wo"], np.maximum(oracle["si_wi_is_wi"], 0)
    counted = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05)
    found = evaluate(material_of(str(shared / "data" / "rgl_bsdf" / f"{name}_rgb.bsdf")), wi[counted], wo[counted])
    expected, cos_i = expected[counted], wi[counted, 2:]
    assert np.abs(np.log1p(found * cos_i) - np.log1p(expected * cos_i)).mean() < 0.01
    error = np.abs(found - expected).mean(1) / np.maximum(expected.mean(1), 1e-6)
    assert np.median(error) < 0.02


def test_measurements_that_no_isotropic_table_holds_are_refused(tmp_path):
    write_tensor_file(tmp_path / "turned.bsdf", fields(*VARIANTS["whole"]))
    with pytest.raises(UserError, match=r"anisotropic.*Fit a model"):
        material_of(str(tmp_path / "turned.bsdf"))
    up = np.array([[0.0, 0.0, 1.0]])
    with pytest.raises(UserError, match=r"scattered samples.*brdf fit"):
        tabulated(Reflectance(up, up, np.ones((1, 3)), source="one sample"))


def test_options_of_a_reader_are_refused_for_a_material(tmp_path):
    (tmp_path / "m.json").write_text(json.dumps({}))
    with pytest.raises(UserError, match="--read"):
        material_of(str(tmp_path / "m.json"), {"cells": "edge"})
