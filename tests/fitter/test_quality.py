"""Dirty and partial data are named, and clean data are not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fitter
from brdf.errors import UserError
from fitter.formats import slices
from fitter.quality import inspect, reorder_channels
from fitter.reflectance import Reflectance

TRUTH = {"alpha": 0.2, "ggx.f0": [0.9, 0.7, 0.4], "albedo": [0.3, 0.2, 0.1]}


@pytest.fixture(scope="module")
def clean() -> Reflectance:
    """3,000 samples of everything, with 3 % noise."""
    return fitter.synthesize("lambert+ggx", values=TRUTH, noise=0.03, samples=3000)


@pytest.fixture(scope="module")
def goniometer() -> Reflectance:
    return fitter.synthesize("lambert+ggx", values=TRUTH, noise=0.03, layout="goniometer")


def findings(data):
    return {finding.name: finding for finding in inspect(data)}


def changed(data, value, **more):
    return dataclasses.replace(data, value=value, **more)


def spherical(theta_deg, phi_deg):
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def scan(theta_i, theta_o, phi_o, value=None):
    """A made-up measurement at angles in degrees, phi_i = 0."""
    theta_i, theta_o, phi_o = (a.ravel() for a in np.broadcast_arrays(theta_i, theta_o, phi_o))
    wi, wo = spherical(theta_i, np.zeros(len(theta_i))), spherical(theta_o, phi_o)
    value = np.random.default_rng(0).uniform(0.1, 0.3, (len(wi), 3)) if value is None else value
    return Reflectance(wi=wi, wo=wo, value=value, source="made up")


@pytest.mark.parametrize(
    ("model", "layout"),
    [("lambert+ggx", "random"), ("lambert+ggx", "merl"), ("phong", "goniometer"), ("ashikhmin_shirley", "goniometer")],
)
def test_clean_data_have_no_finding(model, layout):
    # A goniometer meets the normal twice; a model without colour has one channel until noise comes in.
    data = fitter.synthesize(model, layout=layout, samples=900)
    assert set(findings(data)) <= {"repeated", "one channel"}
    noisy = data.value * (1 + 0.1 * np.random.default_rng(3).normal(size=data.value.shape))
    assert set(findings(changed(data, np.maximum(noisy, 0)))) <= {"repeated"}


def test_the_measured_slices_have_nothing_but_their_one_phi_d(shared):
    # Oracle: 70 real measurements without any of these faults.
    path = shared / "data" / "merl_slices" / "merl_phid90_slices.npz"
    for member in slices.members(path):
        assert set(findings(fitter.read(f"{path}:{member}"))) == {"one phi_d"}, member


def test_the_measured_rgl_materials_are_not_reciprocal_and_partly_negative(shared):
    # Oracle: what is known of these files: 1-20 % non-reciprocal (with interpolation up to 31), some values negative.
    found = {}
    for path in sorted((shared / "data" / "rgl_bsdf").glob("*.bsdf")):
        data = fitter.read(path)
        found[path.stem] = findings(data)
        assert set(found[path.stem]) <= {"not reciprocal", "clamped"}, path.stem
        assert ("clamped" in found[path.stem]) == (data.clamped > 0)
    assert sum("not reciprocal" in names for names in found.values()) == 9
    assert "not reciprocal" not in found["paper_white_rgb"]


def test_other_measured_data_have_only_real_findings(shared):
    # Oracle: the files' own headers. PTFE.data.csv holds one column of values.
    assert set(findings(fitter.read(shared / "data" / "ptfe" / "PTFE.data.csv"))) <= {"one channel"}


def test_a_saturated_highlight_is_counted(clean):
    # Oracle: the clipping done here.
    limit = np.quantile(clean.value[:, 0], 0.95)
    finding = findings(changed(clean, np.minimum(clean.value, [limit, np.inf, np.inf])))["saturated"]
    assert finding.count == np.count_nonzero(clean.value[:, 0] >= limit)
    assert finding.share == finding.count / 3000
    assert f"red {limit:.4g}" in finding.sentence
    assert "green" not in finding.sentence


def test_the_ridge_of_a_mirror_lobe_is_no_saturation():
    # A Phong lobe has exactly its highest value along all of theta_h = 0.
    data = fitter.synthesize("phong", layout="slice")
    assert (data.value == data.value.max()).sum() > 100
    assert "saturated" not in findings(data)


@pytest.mark.parametrize("factor", [100, 255, np.pi * 5])
def test_values_that_are_not_in_1_per_sr_are_told(factor, clean):
    assert "not in 1/sr" in findings(changed(clean, clean.value * factor))["scale"].sentence


def test_values_that_are_all_almost_zero_are_told(clean):
    assert "scale" in findings(changed(clean, clean.value * 1e-9))


@pytest.mark.parametrize(("name", "end"), [("cos(theta_i)", "wi"), ("cos(theta_o)", "wo")])
def test_values_that_contain_the_cosine_are_told(name, end, clean, goniometer):
    for data in (clean, goniometer):
        found = findings(changed(data, data.value * getattr(data, end)[:, 2:]))
        assert f"Divide them by {name}." in found["cosine"].sentence


def test_angles_in_radians_are_told_before_anything_else(goniometer):
    # Oracle: the mistake itself: pi/2 taken for degrees is 1.57 degrees.
    theta_i, theta_o = (np.arccos(np.clip(w[:, 2], -1, 1)) for w in (goniometer.wi, goniometer.wo))
    wrong = scan(theta_i, theta_o, np.arctan2(goniometer.wo[:, 1], goniometer.wo[:, 0]), goniometer.value)
    found = inspect(wrong)
    assert [finding.name for finding in found] == ["radians"]
    assert "the largest is 1.35" in found[0].sentence


def test_pairs_in_both_orders_show_what_is_not_reciprocal(clean):
    # Oracle: the factor put in here, exchanged pairs exact otherwise.
    def both(first, second):
        return changed(
            clean,
            np.concatenate([clean.value * first, clean.value * second]),
            wi=np.concatenate([clean.wi, clean.wo]),
            wo=np.concatenate([clean.wo, clean.wi]),
            weight=np.ones(1),
        )

    finding = findings(both(1, 1.2))["not reciprocal"]
    assert "differ by 18 %" in finding.sentence  # 0.2 / 1.1
    assert finding.count == np.count_nonzero(np.minimum(clean.wi[:, 2], clean.wo[:, 2]) > 0.5)
    assert "not reciprocal" not in findings(both(1, 1.02))


def test_an_isotropic_scan_finds_its_exchanged_pairs():
    # Angles in the plane of incidence, each pair in both orders: theta_i and theta_o from the same set.
    theta = np.arange(5, 60, 5)
    i, o = (a.ravel() for a in np.meshgrid(theta, theta))
    value = np.repeat((1 + 0.3 * (i > o))[:, None], 3, axis=1)
    finding = findings(scan(i, o, 180, value))["not reciprocal"]
    assert finding.count == 11 * 10 // 2
    assert "differ by 26 %" in finding.sentence  # 0.3 / 1.15


def test_scatter_beyond_75_degrees_is_told():
    # Oracle: the noise put in here, 30 % beyond 75 degrees.
    data = fitter.synthesize("lambert+ggx", values=TRUTH, noise=0.01, layout="slice")
    beyond = np.minimum(data.wi[:, 2], data.wo[:, 2]) < np.cos(np.radians(75))
    noise = np.where(beyond, 0.3, 0.0)[:, None] * np.random.default_rng(5).uniform(-1, 1, (len(data), 1)) * np.sqrt(3)
    finding = findings(changed(data, data.value * (1 + noise)))["grazing"]
    assert finding.count == np.count_nonzero(beyond)
    scatter = float(finding.sentence.partition("scatter by ")[2].partition(" %")[0])
    assert 20 < scatter < 40
    assert "grazing" not in findings(data)


def test_clamped_values_are_counted(clean):
    finding = findings(changed(clean, clean.value, clamped=90))["clamped"]
    assert (finding.count, finding.share) == (90, 0.01)


def test_repeated_directions_are_counted_with_their_scatter(clean):
    # Oracle: 500 repetitions with 10 % noise each, on top of the 3 %.
    noise = 1 + 0.1 * np.random.default_rng(6).normal(size=(500, 1))
    data = changed(
        clean,
        np.concatenate([clean.value, clean.value[:500] * noise]),
        wi=np.concatenate([clean.wi, clean.wi[:500]]),
        wo=np.concatenate([clean.wo, clean.wo[:500]]),
        weight=np.ones(1),
    )
    finding = findings(data)["repeated"]
    assert finding.count == 500
    scatter = float(finding.sentence.partition("differ by ")[2].partition(" %")[0])
    assert scatter == pytest.approx(100 * 0.1 / np.sqrt(2), rel=0.1)  # of the pair: one of the two is exact


GRID = np.arange(0.0, 80, 4)


@pytest.mark.parametrize(
    ("angles", "names"),
    [
        ((30, GRID, np.arange(0, 360, 30.0)[:, None]), {"one incident angle"}),
        ((0, GRID, np.arange(0, 360, 30.0)[:, None]), {"one incident angle", "no grazing angles"}),
        ((GRID[:, None], GRID, 180), {"plane of incidence"}),
        ((30, GRID, 180), {"one-dimensional scan"}),
        ((GRID, 30, 180), {"one-dimensional scan"}),
        ((GRID, GRID, 180), {"one-dimensional scan"}),
        ((GRID, GRID, 0), {"one-dimensional scan", "no grazing angles"}),
        ((GRID[3:, None], GRID[3:], np.array([60, 90, 120.0])[:, None, None]), {"no highlight"}),
        ((GRID[:10, None], GRID[:10], np.array([0, 40, 180.0])[:, None, None]), {"no grazing angles"}),
        ((GRID[:, None], GRID, np.arange(0, 360, 30.0)[:, None, None]), set()),
    ],
)
def test_partial_data_are_named(angles, names):
    # Oracle: the angles themselves.
    assert set(findings(scan(*angles))) - {"repeated", "not reciprocal"} == names


def test_one_sample_outside_makes_data_complete(clean):
    # The first look is at every hundredth sample or so; the odd one must still be seen.
    data = scan(*np.broadcast_arrays(30, np.tile(GRID, 300), 0.5 + np.arange(20 * 300) % 359))
    assert "one incident angle" in findings(data)
    wi = data.wi.copy()
    wi[1] = clean.wi[0]
    assert "one incident angle" not in findings(dataclasses.replace(data, wi=wi))


def test_one_channel_is_named_and_one_coloured_sample_refutes_it(clean):
    grey = np.repeat(clean.value[:, :1], 3, axis=1)
    assert "one channel" in findings(changed(clean, grey))
    grey[2500, 2] *= 1.01
    assert "one channel" not in findings(changed(clean, grey))


@pytest.mark.parametrize(("order", "place"), [("bgr", [2, 1, 0]), ("gbr", [2, 0, 1]), ("RGB", [0, 1, 2])])
def test_channels_are_put_in_order(order, place, clean):
    # Oracle: the file holds them as said: its first channel is the first letter.
    data = dataclasses.replace(clean, interpolant=lambda wi, wo: wi)
    again = reorder_channels(data, order)
    np.testing.assert_array_equal(again.value, clean.value[:, place])
    np.testing.assert_array_equal(again.evaluate(clean.wi, clean.wo), clean.wi[:, place])


def test_a_wrong_order_of_channels_is_refused(clean):
    with pytest.raises(UserError, match="each of r, g and b once"):
        reorder_channels(clean, "rgg")


def test_every_sentence_has_a_count_that_fits_the_data(clean, goniometer):
    for data in (changed(clean, clean.value * 100, clamped=3), goniometer):
        for finding in inspect(data):
            assert finding.sentence.endswith(".")
            assert "{" not in finding.sentence
            assert 0 < finding.share <= 1
