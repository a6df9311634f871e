"""Synthetic measurements: the truth comes back from them."""

from __future__ import annotations

import json

import numpy as np
import pytest

import fitter
from brdf import build, evaluate
from brdf.errors import UserError
from brdf.material import from_dict
from fitter import synthetic
from fitter.formats import merl
from fitter.rusinkiewicz import half_difference

PARAMETERS = {"alpha": 0.2, "ggx.f0": [0.9, 0.7, 0.4], "albedo": 0.1}
COUNTS = {"random": 20_000, "merl": 1_111_428, "slice": 8100, "plane": 6 * (86 + 85), "goniometer": 916}


@pytest.mark.parametrize("layout", sorted(synthetic.LAYOUTS))
def test_every_layout_measures_the_model_itself(layout):
    # Oracle: the model called at the same directions.
    data = fitter.synthesize("lambert+ggx", values=PARAMETERS, layout=layout, samples=500)
    truth = synthetic.truth_of("lambert+ggx", PARAMETERS).brdf
    assert len(data) == 500
    np.testing.assert_allclose(data.value, evaluate(truth, data.wi, data.wo), rtol=1e-12)
    assert data.clamped == 0


@pytest.mark.parametrize("layout", sorted(set(COUNTS) - {"merl"}))
def test_a_layout_has_its_number_of_samples(layout):
    # 8100 of a slice: no cell of 90 x 90 at phi_d = 90 degrees lies below the horizon.
    assert len(fitter.synthesize("lambert", layout=layout)) == COUNTS[layout]


def test_grids_are_those_of_the_file_formats():
    # Oracle: the angles of the directions, computed back.
    table = fitter.synthesize("lambert", layout="merl", samples=300)
    cut = fitter.synthesize("lambert", layout="slice", samples=300)
    assert table.grid.shape == merl.SIZE
    assert cut.grid.shape == (90, 90)
    for data in (table, cut):
        angles = half_difference(data.wi, data.wo)
        cells = np.unravel_index(data.grid.index, data.grid.shape)
        for name, cell in zip(data.grid.axes, cells, strict=True):
            keep = (angles.theta_d > 0) | (name != "phi_d")
            expected = data.grid.axes[name][cell]
            np.testing.assert_allclose(getattr(angles, name)[keep], expected[keep], atol=1e-7)


def test_random_directions_find_narrow_highlights():
    data = fitter.synthesize("lambert", seed=3)
    theta_h = half_difference(data.wi, data.wo).theta_h
    assert (theta_h < 0.01).sum() > 1000
    assert (theta_h > 0.5).sum() > 3000
    assert min(data.wi[:, 2].min(), data.wo[:, 2].min()) > np.cos(np.radians(85.001))


def test_noise_has_the_standard_deviation_asked_for():
    # Oracle: the standard deviation of 60,000 draws, whose own error is 0.3 %.
    clean = fitter.synthesize("lambert").value
    relative = fitter.synthesize("lambert", noise=0.05).value / clean - 1
    absolute = fitter.synthesize("lambert", noise=0.01, noise_kind="additive").value - clean
    assert relative.std() == pytest.approx(0.05, rel=0.02)
    assert absolute.std() == pytest.approx(0.01, rel=0.02)
    assert abs(relative.mean()) < 1e-3


def test_noise_below_zero_is_clamped_and_counted():
    data = fitter.synthesize("lambert", values={"albedo": 0.01}, noise=0.1, noise_kind="additive")
    assert data.clamped == np.count_nonzero(data.value == 0)
    assert data.clamped > 20_000


def test_the_seed_decides_everything():
    one, again, other = (fitter.synthesize("lambert+ggx", noise=0.1, seed=seed, samples=50) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.value, again.value)
    np.testing.assert_array_equal(one.wi, again.wi)
    assert not np.array_equal(one.wi, other.wi)
    assert not np.array_equal(one.value, other.value)


def test_the_source_tells_the_truth():
    data = fitter.synthesize("lambert+ggx", values=PARAMETERS, samples=10, noise=0.05, seed=4)
    told = json.JSONDecoder().raw_decode(data.source.removeprefix("synthetic: "))[0]
    assert from_dict(told).to_dict()["parameters"]["ggx"]["alpha"] == 0.2
    assert "0.05 multiplicative noise, layout random, seed 4" in data.source


def test_a_fit_recovers_the_truth():
    # Oracle: the truth, to rounding of the solver.
    data = fitter.synthesize("lambert+ggx", values=PARAMETERS, samples=2000)
    fitted = fitter.fit("lambert+ggx", data).material.to_dict()["parameters"]
    assert fitted["ggx"]["alpha"] == pytest.approx(0.2, rel=1e-5)
    np.testing.assert_allclose(fitted["ggx"]["f0"], PARAMETERS["ggx.f0"], rtol=1e-5)


def test_models_materials_and_expressions_are_the_same(tmp_path):
    model = synthetic.truth_of("lambert+ggx", PARAMETERS)
    values = [
        fitter.synthesize(truth, values=more, samples=20).value
        for truth, more in ((model, None), (model.brdf, None), ("lambert+ggx", PARAMETERS))
    ]
    np.testing.assert_array_equal(values[0], values[1])
    np.testing.assert_array_equal(values[0], values[2])
    assert isinstance(build("lambert"), type(synthetic.truth_of(build("lambert"), {}).brdf))


def test_a_written_measurement_is_read_back(tmp_path):
    data = fitter.synthesize("lambert+ggx", values=PARAMETERS, samples=100, noise=0.05)
    fitter.write(data, tmp_path / "samples.csv")
    again = fitter.read(tmp_path / "samples.csv")
    np.testing.assert_array_equal(again.value, data.value)
    assert '"alpha": 0.2' in (tmp_path / "samples.csv").read_text().splitlines()[0]
    table = fitter.synthesize("lambert+ggx", values=PARAMETERS, layout="merl", samples=1000)
    fitter.write(table, tmp_path / "table.binary")
    again = fitter.read(tmp_path / "table.binary")
    np.testing.assert_array_equal(again.grid.index, table.grid.index)
    np.testing.assert_allclose(again.value, table.value, rtol=1e-14)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"layout": "rand"}, "Did you mean `random`"),
        ({"noise_kind": "gaussian"}, "multiplicative, additive"),
        ({"noise": -0.1}, "noise = -0.1"),
        ({"noise": float("nan")}, "noise = nan"),
        ({"samples": 0}, "samples = 0"),
        ({"layout": "slice", "samples": 8101}, "more than the 8100"),
        ({"seed": -1}, "seed = -1"),
        ({"values": {"alpa": 1}}, "Did you mean"),
        ({"values": {"alpha": 2}}, "outside"),
    ],
)
def test_wrong_arguments_are_named(wrong, message):
    with pytest.raises(UserError, match=message):
        fitter.synthesize("lambert+ggx", **wrong)
