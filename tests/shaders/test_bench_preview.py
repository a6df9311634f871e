"""`brdf bench preview`: it runs whole at its smallest, and its peers and measures are right where that can be known."""

import dataclasses
import importlib.util
import json

import numpy as np
import pytest
from click.testing import CliRunner

import shaders
from brdf.errors import UserError
from fitter.cli.bench import command
from fitter.cli.main import cli
from shaders.bench.case import Case
from shaders.bench.difference import check_flip, difference
from shaders.bench.filtered import cosine_points, ggx_points, kernel_points
from shaders.bench.furnace import measure_furnace
from shaders.bench.tables import direct_sum, measure_tables
from shaders.bench.textbook import Textbook, dfg_table
from shaders.kernel import COSINE, nearest_kernel

SMALL = ["-e", "furnace", "--roughness", "0.6", "--size", "24", "--timed-size", "24", "--rounds", "1", "--seconds", "1"]
needs_flip = pytest.mark.skipif(importlib.util.find_spec("flip_evaluator") is None, reason="needs flip-evaluator")


def run(*arguments):
    result = CliRunner().invoke(cli, ["bench", "preview", *SMALL, "--samples-max", "64", "-q", *arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.mark.gpu
@needs_flip
def test_the_command_runs_at_its_smallest_and_prints_and_draws_what_it_measured(tmp_path):
    picture = tmp_path / "a.png"
    found = json.loads(run("--only", "tier", "--only", "truth", "--json", "--plot", str(picture)).stdout)
    assert [row["material"] for row in found["pictures"]] == ["metal", "dielectric"]
    methods = [point["method"] for point in found["pictures"][0]["points"]]
    assert methods == ["textbook", "interactive", "still", "truth", "truth"]
    assert len(found["bars"]) >= 4
    assert picture.stat().st_size > 0
    page = run("--only", "furnace", "--only", "tables", "--markdown").stdout
    assert page.startswith("<!-- Made by `brdf bench preview --markdown`. -->")
    assert "## Furnace" in page
    assert "## Blurred environments" in page


def test_an_unknown_part_is_refused_and_the_known_ones_named():
    result = CliRunner().invoke(command, ["preview", "--only", "speed"])
    assert result.exit_code == 2
    assert "'tier', 'truth', 'furnace', 'tables', 'start'" in result.output


def test_a_plot_without_tiers_is_refused():
    with pytest.raises(UserError, match="leaves out"):
        run("--only", "furnace", "--plot", "a.png")


def test_a_missing_flip_is_named_with_the_remedy(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"`flip_evaluator`, .* Run: pip install"):
        check_flip()


@needs_flip
def test_a_difference_counts_the_sphere_alone():
    # Oracle: by hand; 0.1 apart inside, while outside nothing covers the colour.
    reference = np.full((24, 24, 4), 0.4, np.float32)
    reference[..., 3] = 0.0
    reference[8:16, 8:16, 3] = 1.0
    test = reference.copy()
    test[..., :3] = 0.5
    found = difference(reference, test)
    assert found.rmse == pytest.approx(0.1, rel=1e-5)
    assert found.flip_inside > found.flip > 0


def test_points_have_the_density_that_they_are_drawn_from():
    # Oracles: closed forms of the mean cosine: 2/3; that of the kernel is its first coefficient.
    kernel = nearest_kernel(2.0, 0.5)
    assert cosine_points(1024, 64, 0.0)[:, 2].mean() == pytest.approx(2 / 3, abs=2e-3)
    assert kernel_points(kernel, 1024, 64, 0.0)[:, 2].mean() == pytest.approx(kernel.coefficients()[1], abs=2e-3)
    # GGX of alpha 1 has cos_h^2 uniform: a mirrored direction's cosine is so too, and half are above the horizon.
    cosine = ggx_points(1.0, 1024, 64, 0.0)[:, 2]
    assert len(cosine) == 512
    assert cosine.mean() == pytest.approx(0.5, abs=2e-3)


def test_the_textbook_table_of_a_mirror_is_schlicks_term():
    # Oracle: at no roughness all light is reflected, scale + bias = 1, and the bias is (1 - cos)^5.
    row = dfg_table()[0]
    cosine = (np.arange(len(row)) + 0.5) / len(row)
    np.testing.assert_allclose(row.sum(axis=-1)[4:], 1.0, atol=2e-3)
    np.testing.assert_allclose(row[4:, 1], (1 - cosine[4:]) ** 5, atol=2e-3)


@pytest.mark.gpu
def test_the_textbook_reflects_a_constant_light_by_its_own_table():
    # Oracle: under light of 1 the look-ups are 1; what is left is albedo + f scale + bias at the sphere's middle.
    case = Case("dielectric", 0.5, shaders.load_environment("furnace"))
    scene = dataclasses.replace(case.scene("interactive", 31), sky="none", exposure=-1.0)
    picture, milliseconds = Textbook(case.environment).render(case, scene)
    assert set(milliseconds) == {"surface", "resolve", "tone_map"}
    scale, bias = 0.5 * (dfg_table()[31, -1] + dfg_table()[32, -1])
    linear = 0.5 * (np.array(case.albedo) + 0.04 * scale + bias)
    # Below Khronos' compression: what it takes off is x - 6.25 x^2 of the least channel, at most 0.04.
    least = linear.min()
    linear -= least - 6.25 * least**2 if least < 0.08 else 0.04
    np.testing.assert_allclose(picture[15, 15, :3], 1.055 * linear ** (1 / 2.4) - 0.055, atol=2e-3)


def test_direct_summation_of_a_linear_sky_is_the_first_coefficient():
    # Oracle: Funk-Hecke: blurring 1 + y multiplies y by the kernel's first coefficient.
    height = 64
    y = np.cos(np.pi * (np.arange(height) + 0.5) / height)
    pixels = np.broadcast_to((1 + y)[:, None, None], (height, 2 * height, 3)).astype(np.float32)
    directions = np.array([[0.0, 1.0, 0.0], [0.6, 0.0, 0.8], [0.0, -0.6, 0.8]])
    kernel = nearest_kernel(2.0, 0.5)
    found = direct_sum(shaders.Environment(pixels, "linear"), kernel, directions)
    expected = 1 + kernel.coefficients()[1] * directions[:, 1]
    np.testing.assert_allclose(found, expected[:, None].repeat(3, axis=1), atol=2e-3)


@pytest.mark.gpu
def test_both_ways_to_blur_keep_a_constant_sky():
    # Oracle: a kernel's integral is 1; ours is that of a picture of so few texels that the solid angles of points show.
    rows = measure_tables(["furnace"], 1, lambda sentence: None)
    assert rows[0].kernel == COSINE.name
    assert max(row.ours_error for row in rows) < 5e-3
    assert max(row.theirs_error for row in rows) < 1e-6


@pytest.mark.gpu
def test_models_that_are_not_white_are_left_out_of_the_furnace_with_the_reason():
    found = measure_furnace(8, 16, (0.6,), lambda sentence: None)
    assert {row.model for row in found.rows} == {"beckmann", "eon", "gaussian", "ggx", "lambert"}
    assert "not white" in found.left_out["phong"]
    assert "bound" in found.left_out["disney"]
    assert "1.5" in found.left_out["burley"]
