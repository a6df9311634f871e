"""What a user may ask of the parameters: fixed, tied, bounded, freed, started. Oracles: truths, and other fits."""

import numpy as np
import pytest
from synthetic import measure, noisy_in_log, plastic

import brdf
import fitter
from brdf.registry import combine, split
from fitter.minimise import Problem
from fitter.solve import _distinct
from fitter.start import interchangeable, sort_lobes
from fitter.wishes import Wishes, choose

DATA = noisy_in_log(plastic(), 1, 1500)


def test_numbers_that_are_fixed_are_no_part_of_a_kept_program():
    # Oracle: the loss by its formula. A number compiled into the program would give the first fit's cost again.
    for alpha in (0.15, 0.3):
        result = fitter.fit("lambert+ggx", DATA, fixed={"alpha": alpha})
        cos_i = DATA.wi[:, 2:3]
        value = np.asarray(brdf.evaluate(result.brdf, DATA.wi, DATA.wo))
        r = np.log1p(value * cos_i) - np.log1p(DATA.value * cos_i)
        assert result.errors["cost"] == pytest.approx(np.sum(np.sqrt(1 + r * r) - 1), rel=1e-6)


def test_colours_tied_across_lobes_are_one_colour():
    # Oracle: the truth, in which they are equal.
    truth = plastic(albedo=(0.3, 0.2, 0.1), f0=(0.3, 0.2, 0.1))
    result = fitter.fit("lambert+ggx", measure(truth, count=1500), tied={"lambert.albedo": "ggx.f0"})
    lobes = split(result.brdf)
    np.testing.assert_allclose(lobes["lambert"].albedo, [0.3, 0.2, 0.1], rtol=1e-7)
    np.testing.assert_array_equal(lobes["lambert"].albedo, lobes["ggx"].f0)
    assert result.unknowns.size == 4
    assert "(tied to lambert.albedo)" in result.report()


def test_tied_slopes_are_the_isotropic_fit():
    # Oracle: the fit of the isotropic model. The start and the bound may name either slope.
    one = fitter.fit("ggx", DATA)
    fixed = {"anisotropy": "anisotropic", "rotation": 0.0}
    two = fitter.fit("ggx", DATA, fixed=fixed, tied={"alpha_x": "alpha_y"}, start={"alpha_y": 0.4})
    assert float(two.brdf.alpha_x) == float(two.brdf.alpha_y) == pytest.approx(float(one.brdf.alpha), rel=1e-6)
    assert two.standard_errors()["ggx.alpha_x"] == pytest.approx(one.standard_errors()["ggx.alpha"], rel=1e-3)
    narrow = fitter.fit("ggx", DATA, fixed=fixed, tied={"alpha_x": "alpha_y"}, bounds={"alpha_y": (0.4, 0.5)})
    assert float(narrow.brdf.alpha_x) in (0.4, 0.5)


def test_a_bound_that_excludes_the_truth_holds_and_is_named():
    # Oracle: with alpha on the bound the others are those of the fit with alpha fixed there.
    bounded = fitter.fit("lambert+ggx", DATA, bounds={"alpha": (0.2, 0.5)})
    fixed = fitter.fit("lambert+ggx", DATA, fixed={"alpha": 0.2})
    assert float(split(bounded.brdf)["ggx"].alpha) == 0.2
    assert "ggx.alpha" in bounded.at_bound()
    np.testing.assert_allclose(split(bounded.brdf)["ggx"].f0, split(fixed.brdf)["ggx"].f0, rtol=1e-5)


def test_a_start_from_a_material_reaches_the_same_minimum_from_there(tmp_path):
    scanned = fitter.fit("lambert+ggx", DATA)
    far = plastic(albedo=(0.1, 0.1, 0.1), f0=(0.3, 0.3, 0.3), alpha=0.5)
    brdf.save_material(brdf.Material(far), tmp_path / "far.json")
    started = fitter.fit("lambert+ggx", DATA, start=tmp_path / "far.json")
    assert float(split(started.initial)["ggx"].alpha) == 0.5
    assert started.errors["cost"] == pytest.approx(scanned.errors["cost"], rel=1e-9)
    assert float(split(started.brdf)["ggx"].alpha) == pytest.approx(float(split(scanned.brdf)["ggx"].alpha), rel=1e-5)


@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_a_held_parameter_takes_the_value_that_fits_best(metallic):
    # Oracle: the truth. Three starts that differ in an idle rotation alone once passed for three minima.
    lobe = brdf.MODELS["disney"](base_color=np.array([0.8, 0.5, 0.3]), metallic=metallic, roughness=0.4)
    result = fitter.fit("disney", measure(combine({"disney": lobe}), count=2000), quick=True)
    assert float(result.brdf.metallic) == metallic
    assert result.errors["log_mae"] < 1e-9
    np.testing.assert_allclose(result.brdf.base_color, [0.8, 0.5, 0.3], rtol=1e-5)
    assert "--free metallic" in result.report()


def test_starts_that_differ_in_nothing_that_matters_are_one_and_each_variant_has_its_best_first():
    # Costs of two variants a and b, in rising order; 1e-12 is rounding.
    a, b = object.__new__(Problem), object.__new__(Problem)
    row = np.zeros(1)
    costs = [(1.0, a), (1.0 + 1e-12, a), (2.0, a), (3.0, b), (3.0, b), (4.0, a), (5.0, b)]
    found = _distinct([(cost, place, variant, row) for place, (cost, variant) in enumerate(costs)])
    assert [(cost, variant is a) for cost, _, variant, _ in found] == [
        (1.0, True),
        (3.0, False),
        (2.0, True),
        (4.0, True),
        (5.0, False),
    ]


def test_held_weights_of_zero_are_tried_too():
    # OpenPBR's metalness is a weight, which is left out of the program where it is 0: not while it may be 1.
    variants = choose(brdf.build("openpbr"), Wishes()).variants()
    metalness = [float(split(one.template)["openpbr"].base_metalness) for one in variants]
    assert metalness == [0.0, 1.0]
    assert len({one.structure for one in variants}) == 1


def test_what_is_freed_tied_or_bounded_is_not_held():
    model = brdf.build("disney")
    assert dict(choose(model, Wishes()).held) == {("disney", "metallic"): (0.0, 1.0)}
    for wishes in (Wishes(freed=("metallic",)), Wishes(bounds={"metallic": (0.0, 0.5)})):
        unknowns = choose(model, wishes)
        assert unknowns.held == ()
        assert "disney.metallic" in unknowns.element_labels
    assert "disney.metallic" not in choose(model, Wishes(fixed={"metallic": 0.3})).element_labels


def test_data_that_do_not_turn_the_sample_hold_the_azimuth():
    # All half vectors in one plane, as in a scan: no azimuth can be told.
    theta = np.radians(np.linspace(-60, 60, 121))
    wo = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    wi = np.tile([[-0.5, 0.0, np.sqrt(0.75)]], (121, 1))
    value = np.asarray(brdf.evaluate(plastic(), wi, wo))
    scan = fitter.Reflectance(wi=wi, wo=wo, value=value, source="scan")
    fixed = {"anisotropy": "anisotropic"}
    held = fitter.fit("ggx", scan, fixed=fixed, tied={"alpha_x": "alpha_y"}, quick=True)
    assert "--free rotation" in held.report()
    turned = fitter.fit("ggx", DATA, fixed=fixed, tied={"alpha_x": "alpha_y"}, quick=True)
    assert "ggx.rotation" in turned.unknowns.element_labels


def test_only_lobes_that_may_be_exchanged_are_sorted_and_whole():
    model = brdf.build("lambert+ggx+ggx")
    unknowns = choose(model, Wishes())
    groups = interchangeable(unknowns)
    assert [[lobe[0].lobe for lobe in group] for group in groups] == [["ggx", "ggx_2"]]
    y = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.9, 0.7, 0.8, 0.85, 0.01])
    np.testing.assert_array_equal(sort_lobes(y, groups), [0.1, 0.2, 0.3, 0.7, 0.8, 0.85, 0.01, 0.4, 0.5, 0.6, 0.9])
    for wishes in (
        Wishes(bounds={"ggx.alpha": (0.1, 1.0)}),
        Wishes(fixed={"ggx.masking": "smith_separable"}),
        Wishes(fixed={"ggx.f0": 0.1}),
        Wishes(tied={"ggx.f0": "ggx_2.f0"}),
    ):
        assert interchangeable(choose(model, wishes)) == []


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"tied": {"alpha": "f0"}}, "not of one kind"),
        ({"tied": {"alpha_x": "alpha_y"}}, "needs `anisotropy` = anisotropic"),
        ({"tied": {"alpha": "masking"}}, "static choice"),
        ({"tied": {"alpha": "alpah"}}, "Did you mean `ggx.alpha`"),
        ({"bounds": {"alpha": (0.5, 0.2)}}, "smaller number first"),
        ({"bounds": {"alpha": (0.5, 2.0)}}, "leaves the declared bounds"),
        ({"bounds": {"alpha": (float("nan"), 0.5)}}, "is no range"),
        ({"bounds": {"alpha": (0.1, 0.5)}, "fixed": {"alpha": 0.2}}, "is fixed, and also"),
        ({"free": ["alpha"], "fixed": {"alpha": 0.2}}, "is fixed, and also"),
        ({"free": ["metallic"]}, "`metallic` is not a parameter here"),
        ({"start": {"alpah": 0.2}}, "Did you mean `ggx.alpha`"),
        ({"start": {"alpha": 0.9}, "bounds": {"alpha": (0.1, 0.5)}}, "outside [0.1, 0.5]"),
        ({"start": brdf.build("ggx")}, "The start is `ggx`, but `lambert+ggx` is fitted"),
        ({"weights": "sigm"}, "Did you mean `sigma`"),
    ],
)
def test_wishes_that_cannot_be_met_are_named_with_the_remedy(options, sentence):
    with pytest.raises(brdf.UserError) as caught:
        fitter.fit("lambert+ggx", DATA, **options)
    assert sentence in str(caught.value)
