"""`brdf bench preview`: it runs whole at its smallest, and its peers and measures are right where that can be known."""

import dataclasses
import importlib.util
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import shaders
from brdf.errors import UserError
from fitter.bench.start import IMPORT_JAX, NEW, SEEN, Start, write_hdr
from fitter.cli._bench_preview_bars import bars
from fitter.cli._bench_preview_run import PreviewBench
from fitter.cli.bench import command
from fitter.cli.main import cli
from shaders.bench.case import Case
from shaders.bench.difference import Difference, check_flip, difference
from shaders.bench.filtered import cosine_points, ggx_points, kernel_points
from shaders.bench.furnace import deviations, measure_furnace
from shaders.bench.pictures import PictureSettings, Point, convergence
from shaders.bench.tables import TableRow, Tables, direct_sum, measure_tables
from shaders.bench.textbook import Textbook, dfg_table
from shaders.kernel import COSINE, nearest_kernel

SMALL = ["-e", "furnace", "--material", "metal", "--roughness", "0.6", "--size", "24", "--timed-size", "24"]
QUICK = ["--rounds", "1", "--error", "0.05", "--seconds", "1", "--samples-max", "32", "-q"]
needs_flip = pytest.mark.skipif(importlib.util.find_spec("flip_evaluator") is None, reason="needs flip-evaluator")


def run(*arguments):
    result = CliRunner().invoke(cli, ["bench", "preview", *SMALL, *QUICK, *arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.mark.gpu
@needs_flip
def test_the_command_runs_at_its_smallest_and_prints_and_draws_what_it_measured(tmp_path):
    picture = tmp_path / "a.png"
    found = json.loads(run("--only", "tier", "--only", "truth", "--json", "--plot", str(picture)).stdout)
    (row,) = found["pictures"]
    assert [point["method"] for point in row["points"]] == ["textbook", "interactive", "still", "truth"]
    assert row["frame_ratio"] > 0
    assert row["look_ups"] >= 1
    assert len(found["bars"]) == 4
    assert picture.stat().st_size > 0


@pytest.mark.gpu
def test_the_page_of_the_docs_has_what_was_measured_and_no_more():
    page = run("--only", "tables", "--markdown").stdout
    assert page.startswith("<!-- Made by `brdf bench preview --markdown`. -->")
    assert [line for line in page.splitlines() if line.startswith("## ")] == ["## Bars", "## Blurred environments"]


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
    # Oracle: under light of 1 the look-ups are 1; what is left is albedo + F scale + bias, at the middle of the sphere
    # and near its rim, where the ray through the pixel meets it.
    case = Case("dielectric", 0.5, shaders.load_environment("furnace"))
    scene = dataclasses.replace(case.scene("interactive", 31), sky="none", exposure=-1.0)
    picture, milliseconds = Textbook(case.environment).render(case, scene)
    assert set(milliseconds) == {"surface", "resolve", "tone_map"}
    for column in (15, 26):
        ray = np.array([(column - 15) / 15.5 * math.tan(math.radians(15)), 0, -1])
        ray /= np.linalg.norm(ray)
        eye = np.array([0, 0, 4.77])
        along = -ray @ eye - math.sqrt((ray @ eye) ** 2 - eye @ eye + 1)
        cos_o = -ray @ (eye + along * ray)
        scale, bias = np.array(
            [np.interp(cos_o, (np.arange(64) + 0.5) / 64, part) for part in dfg_table()[31:33].mean(0).T]
        )
        linear = 0.5 * (np.array(case.albedo) + (0.04 + 0.46 * (1 - cos_o) ** 5) * scale + bias)
        # Below Khronos' compression: what it takes off is x - 6.25 x^2 of the least channel, at most 0.04.
        least = linear.min()
        linear -= least - 6.25 * least**2 if least < 0.08 else 0.04
        np.testing.assert_allclose(picture[15, column, :3], 1.055 * linear ** (1 / 2.4) - 0.055, atol=3e-3)


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
    (found,) = measure_tables(["furnace"], 1, lambda sentence: None)
    assert found.rows[0].kernel == COSINE.name
    assert max(row.ours_error for row in found.rows) < 5e-3
    assert max(row.theirs_error for row in found.rows) < 1e-6
    assert found.ours_ms == pytest.approx(sum(row.ours_ms for row in found.rows))


@pytest.mark.gpu
def test_models_that_are_not_white_are_left_out_of_the_furnace_with_the_reason():
    found = measure_furnace(["burley", "disney", "lambert", "phong"], 8, 0.01, (0.6,), lambda sentence: None)
    assert [row.model for row in found.rows] == ["lambert"]
    assert max(found.rows[0].largest.values()) < 1e-3
    assert "not white" in found.left_out["phong"]
    assert "bound" in found.left_out["disney"]
    assert "1.5" in found.left_out["burley"]


def test_rings_take_the_noise_out_of_a_furnace_and_leave_the_bias():
    # Oracle: by hand: columns are by turns 0.2 too bright and too dark, then all are 0.1 brighter.
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[:, ::2, :3] += 0.2
    pixels[:, 1::2, :3] -= 0.2
    largest, ring = deviations(pixels)
    assert largest == pytest.approx(0.2, rel=1e-5)
    assert ring < 0.02
    pixels[..., :3] += 0.1
    assert deviations(pixels)[1] == pytest.approx(0.1, abs=0.02)


def test_a_truth_that_converges_by_the_root_of_its_samples_halves_its_error_for_four_times_as_many():
    # Oracle: RMSE = 0.08 / sqrt(n / 16), plus the truth's own error; a sample costs half a frame: 0.004 takes 6400.
    points = [Point("truth", n, Difference(0, 0, math.hypot(0.32 / math.sqrt(n), 0.001)), 2.0 * n) for n in (32, 128)]
    gain, cost = convergence(points, 0.001, 4.0)
    assert gain == pytest.approx(2.0)
    assert cost == pytest.approx(0.5 * 6400, rel=1e-6)
    assert convergence(points[:1], 0.001, 4.0) == (None, None)


def test_a_bar_is_met_at_its_limit_and_missed_above():
    # Oracle: the limits of the issue: 1.5 s cold, 0.9 s warm; half the time and a fiftieth of the error.
    row = TableRow("cosine", 64, 1.0, 2.0, 0.01, 0.5)
    settings = PictureSettings(("x",), ("metal",), (0.6,), 24, 24, 1, (), 0.1, 1.0)
    starts = [Start(NEW, 1.5, 1.0), Start(SEEN, 1.0, 1.0), Start(IMPORT_JAX, 3.0, 3.0)]
    found = PreviewBench([], None, [Tables("x", (row,), 1.0, 1.0, 2.0, 0.5)], starts, settings, "none", None)
    assert [(bar.found, bar.is_met) for bar in bars(found)] == [
        ("0.50 x", True),
        ("50 x; 1 of 1 met", True),
        ("1.50 s (1.00 s of CPU, 0.50 x import jax)", True),
        ("1.00 s (1.00 s of CPU, 0.33 x import jax)", False),
    ]


def test_the_environment_of_the_cold_start_is_read_as_it_was_written(tmp_path):
    # Oracle: the round trip, to 8 bits of mantissa.
    pixels = np.random.default_rng(3).uniform(0.1, 50, (200, 400, 3))
    pixels[:, 100:300] = 3.0
    pixels[2] = pixels[2, 0]
    write_hdr(tmp_path / "a.hdr", pixels)
    found = shaders.load_environment(str(tmp_path / "a.hdr")).pixels
    np.testing.assert_allclose(found, pixels, atol=pixels.max(axis=-1).max() / 128)
