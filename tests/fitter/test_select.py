"""The choice among models: what is held out, the rule of choice, and that one failure stops nothing.

Oracles: models whose samples were made by one of them, and the rules as they are written.
"""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import brdf
import fitter
from brdf.errors import UserError
from brdf.model import evaluate
from brdf.registry import combine
from fitter import select as module
from fitter.held_out import blocks
from fitter.reflectance import Grid, Reflectance
from fitter.result import FitResult
from fitter.rusinkiewicz import directions
from fitter.select import log_error, select
from fitter.selection import Candidate

GREY = np.full(3, 0.2)


def table(model, rows=16, columns=12, noise=0.0):
    """A slice of the model at phi_d = 90 degrees, (theta_d, theta_h) up to about 75 and 40 degrees, with noise."""
    theta_d = np.radians(np.linspace(0, 75, rows))
    theta_h = np.radians(40) * np.linspace(0, 1, columns) ** 2
    d, h = (axis.ravel() for axis in np.meshgrid(theta_d, theta_h, indexing="ij"))
    wi, wo = directions(h, d, np.full(d.size, np.pi / 2))
    value = np.asarray(evaluate(model, wi, wo), np.float64)
    value = value * np.exp(noise * np.random.default_rng(5).normal(size=value.shape))
    grid = Grid({"theta_d": theta_d, "theta_h": theta_h}, np.arange(d.size))
    return Reflectance(wi=wi, wo=wo, value=value, source="made", grid=grid)


def shiny(alpha=0.2):
    lobes = {"lambert": brdf.MODELS["lambert"](albedo=GREY), "ggx": brdf.MODELS["ggx"](f0=GREY, alpha=alpha)}
    return combine(lobes)


def test_blocks_hold_whole_rows_of_theta_d_and_every_sample_is_held_out_once():
    data = table(shiny())
    parts = blocks(data)
    assert (parts.angle, parts.count, parts.folds) == ("theta_d", 12, 4)
    rows = parts.block.reshape(16, 12)
    assert (rows == rows[:, :1]).all()
    assert (np.diff(rows[:, 0]) >= 0).all()
    folds = [parts.held_out(fold).reshape(16, 12) for fold in range(4)]
    assert all((fold == fold[:, :1]).all() for fold in folds)
    assert (np.sum(folds, axis=0) == 1).all()


def test_scattered_data_hold_out_theta_i_and_one_incident_angle_theta_o():
    data = table(shiny())
    theta = np.radians(np.linspace(5, 70, 40))
    wo = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    for angles, name, count in (([20, 40, 60, 70, 75], "theta_i", 5), ([30], "theta_o", 12)):
        theta_i = np.radians(np.repeat(angles, len(wo)))
        wi = np.stack([-np.sin(theta_i), 0 * theta_i, np.cos(theta_i)], axis=1)
        data = Reflectance(wi=wi, wo=np.tile(wo, (len(angles), 1)), value=np.ones((len(wi), 3)), source="made")
        assert (blocks(data).angle, blocks(data).count) == (name, count)


def test_a_single_direction_holds_nothing_out():
    up = np.array([[0.0, 0.0, 1.0]])
    parts = blocks(Reflectance(wi=up, wo=up, value=np.ones((1, 3)), source="made"))
    assert parts.folds == 0


def test_the_log_error_is_that_of_its_formula():
    # Oracle: Lambert's 1 / pi against a measurement of 1 at 60 degrees.
    wi = np.array([[np.sqrt(0.75), 0.0, 0.5]])
    data = Reflectance(wi=wi, wo=wi, value=np.ones((1, 3)), source="made")
    error = log_error(brdf.MODELS["lambert"](albedo=1.0), data)
    assert error == pytest.approx([np.log(1.5) - np.log1p(0.5 / np.pi)], rel=1e-12)


def test_the_model_that_made_the_samples_is_chosen_among_others():
    data = table(shiny(), noise=0.02)
    selection = select(data, ("lambert", "lambert+ggx", "lambert+ggx+ggx"))
    assert [one.name for one in selection.candidates] == ["lambert", "lambert+ggx", "lambert+ggx+ggx"]
    # The larger sum follows the noise: on all samples it is no worse, and it has more numbers.
    assert selection.chosen.expression == "lambert+ggx"
    assert selection.candidates[0].held_out > 3 * selection.chosen.held_out
    assert selection.result.brdf.lobes[1].alpha == pytest.approx(0.2, rel=0.02)
    assert (selection.angle, selection.folds) == ("theta_d", 4)


def test_held_out_errors_are_those_of_fits_that_never_saw_the_block():
    # Oracle: the same four fits by hand.
    data = table(shiny(), noise=0.05)
    selection = select(data, "lambert+ggx")
    used = selection.result.data
    parts, errors = blocks(used), np.zeros(len(used))
    for fold in range(4):
        out = parts.held_out(fold)
        seen = fitter.fit("lambert+ggx", used.select(~out, "out"))
        errors[out] = log_error(seen.brdf, used.select(out, "in"))
    # Both starts end in one minimum, up to where the solver stops.
    assert selection.chosen.held_out == pytest.approx(errors.mean(), rel=1e-5)
    assert selection.chosen.held_out > 1.005 * selection.chosen.log_mae
    assert selection.chosen.log_mae == pytest.approx(log_error(selection.result.brdf, used).mean(), rel=1e-9)


def test_a_failing_model_is_a_row_with_its_sentence_and_stops_no_other():
    data = table(shiny())
    selection = select(data, ("lambert", "lambert+ggx"), fixed={"alpha": 0.2})
    failed, fitted = selection.candidates
    assert "`alpha` is not a parameter here" in failed.note
    assert (failed.result, failed.numbers) == (None, None)
    assert selection.chosen is fitted
    assert failed.note in selection.report()


def test_no_fit_at_all_is_an_error_that_says_why():
    with pytest.raises(UserError, match=r"No model could be fitted[.] `lambert`: `alpha` is not a parameter"):
        select(table(shiny()), "lambert", fixed={"alpha": 0.2})


def test_an_unknown_model_is_refused_before_anything_is_fitted(monkeypatch):
    monkeypatch.setattr(module, "fit", lambda *a, **k: pytest.fail("fitted"))
    with pytest.raises(UserError, match="Did you mean `lambert`"):
        select(table(shiny()), ("ggx", "lambrt"))
    with pytest.raises(UserError, match="`models` is empty"):
        select(table(shiny()), ())


def row(expression, held_out, log_mae, numbers, converged=True):
    """A candidate as the rule sees it."""
    result = object.__new__(FitResult)
    seen = {"unknowns": SimpleNamespace(size=numbers), "errors": {"log_mae": log_mae}, "converged": converged}
    for name, value in seen.items():
        object.__setattr__(result, name, value)
    return Candidate(expression, "", result, held_out, 0.0, 0.0, "")


@pytest.mark.parametrize(
    ("rows", "chosen"),
    [
        # As good as the best: fewer numbers win.
        ([row("a", 0.0300, 0.02, 5), row("b", 0.0295, 0.02, 9)], "a"),
        ([row("a", 0.0320, 0.02, 5), row("b", 0.0295, 0.02, 9)], "b"),
        ([row("a", 0.0005, 0.02, 5), row("b", 0.0003, 0.02, 9)], "a"),
        # Never worse than the reference on all samples.
        ([row("lambert+ggx", 0.05, 0.04, 7), row("b", 0.03, 0.041, 9)], "lambert+ggx"),
        ([row("lambert+ggx", 0.05, 0.04, 7), row("b", 0.03, 0.039, 9)], "b"),
        # What has not converged is taken only if nothing has.
        ([row("a", 0.05, 0.05, 7), row("b", 0.03, 0.03, 9, converged=False)], "a"),
        ([row("b", 0.03, 0.03, 9, converged=False)], "b"),
        # Without a held-out error that of all samples decides.
        ([row("a", np.nan, 0.05, 7), row("b", np.nan, 0.03, 9)], "b"),
    ],
)
def test_the_rule_of_choice(rows, chosen):
    assert module._choose(rows, None).chosen.expression == chosen


def test_auto_stops_where_nothing_is_left_to_explain_and_starts_from_what_it_has(monkeypatch):
    data, calls = table(shiny()), []

    def spy(model, data, **options):
        calls.append((brdf.registry.expression_of(model), options["start"]))
        return fitter.fit(model, data, **options)

    monkeypatch.setattr(module, "fit", spy)
    selection = select(data)
    assert [one.expression for one in selection.candidates] == ["lambert", "lambert+ggx", "lambert+general_gtr"]
    assert selection.chosen.log_mae < 1e-6
    # Folds start from the fit to all samples.
    assert sum(isinstance(start, dict) for _, start in calls) == 3
    assert len(calls) == 15


def test_auto_goes_on_to_two_lobes_started_from_one():
    found = [row("lambert", 0.2, 0.2, 3), row("lambert+ggx", 0.1, 0.1, 7), row("lambert+general_gtr", 0.05, 0.05, 13)]
    data = table(shiny())
    assert brdf.registry.expression_of(list(module._ladder(data, found))[-1]) == "lambert+general_gtr+general_gtr"
    lobe = brdf.MODELS["general_gtr"](alpha=0.3, gamma=1.2, spread=0.4, falloff=3.0)
    fitted = fitter.fit(combine({"lambert": brdf.MODELS["lambert"](), "general_gtr": lobe}), data, start={"alpha": 0.3})
    one = Candidate("lambert+general_gtr", "", fitted, 0.05, 0.0, 0.0, "")
    start = module._start(brdf.build("lambert+general_gtr+general_gtr"), [one])
    names = ("alpha", "gamma", "spread", "falloff")
    assert start == {f"general_gtr.{name}": float(getattr(fitted.brdf.lobes[1], name)) for name in names}


def test_the_table_is_json_and_text():
    selection = select(table(shiny()), ("lambert", "lambert+ggx"))
    told = json.loads(json.dumps(selection.to_dict(), allow_nan=False))
    assert told["chosen"] == "lambert+ggx"
    assert [one["numbers"] for one in told["candidates"]] == [3, 7]
    assert told["candidates"][0]["delta_e_itp"] > 1
    lines = selection.report().splitlines()
    assert [line.split()[0] for line in lines[2:4]] == ["lambert", "->"]
