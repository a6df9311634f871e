"""The pages of the models: what stands in docs/models is what the declarations say now, and the pictures are whole."""

import itertools
import pathlib

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import brdf
from brdf.errors import UserError
from brdf.parameter import choices
from brdf.registry import MODELS
from fitter import catalogue, pages, portrait
from fitter.cli.models import command

DOCS = pathlib.Path(__file__).parents[2] / "docs" / "models"
REMEDY = "run `brdf models --pages docs/models --force`"


@pytest.mark.parametrize("name", ["README", *MODELS])
def test_the_pages_in_the_docs_are_the_declarations(name):
    text = pages.index() if name == "README" else pages.page(name)
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == text, REMEDY


def test_every_model_has_a_page_and_a_picture_and_nothing_else_is_there():
    files = {file.name for file in DOCS.iterdir()}
    assert files == {"README.md"} | {f"{name}{suffix}" for name in MODELS for suffix in (".md", ".png")}, REMEDY
    for name in MODELS:
        assert (DOCS / f"{name}.png").stat().st_size < 120_000


@pytest.mark.parametrize("name", MODELS)
def test_what_is_told_of_claims_holds_for_every_combination_of_choices(name):
    found = catalogue.cases(name, repr)
    for options in itertools.product(*(choice.options for choice in choices(MODELS[name]))):
        chosen = dict(zip([choice.name for choice in choices(MODELS[name])], options, strict=True))
        told = [said for case, said in found if all(chosen[key] in case[key] for key in case)]
        assert told == [repr(MODELS[name](**chosen).claims())]


def test_claims_are_told_in_sentences():
    assert catalogue.claims("gltf") == ["Not reciprocal.", "No bound on the light that leaves."]
    assert catalogue.claims("eon")[1] == (
        "At most 1.0002 times the light that arrives leaves with albedo_form = polynomial; otherwise no more light "
        "leaves than arrives."
    )


@pytest.mark.parametrize("columns", [80, 100])
def test_a_page_fits_into_the_terminal(columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    # The leading comment is kept as it is in the file; the tables, from the head on, are wrapped.
    table = catalogue.page("ggx").partition("parameter  ")[2]
    assert max(map(len, table.splitlines()[1:])) <= columns
    assert "(with fresnel = dielectric)" in " ".join(table.split())
    assert max(map(len, catalogue.overview().splitlines()[:-2])) <= columns


def test_prose_is_neither_html_nor_emphasis_and_formulas_stay():
    assert pages._prose("the average <E> * 2, `a < b`\n\n    f = <E> * 2") == (
        "the average \\<E> \\* 2, `a < b`\n\n    f = <E> * 2"
    )


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    path = tmp_path_factory.mktemp("picture") / "ggx.png"
    asked = []

    def sphere(model, size):
        asked.append(model)
        return np.full((size, size, 3), [1.0, 0.0, 0.0], np.float32)

    model, words = portrait.shown("ggx", MODELS["ggx"])
    portrait.draw(model, path, sphere)
    assert words == "`f0` = (0.9, 0.6, 0.3), all else at its default"
    np.testing.assert_array_equal(asked[0].f0, [0.9, 0.6, 0.3])
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def test_the_picture_has_three_panels_and_clips_nothing(picture):
    assert picture.shape == (310, 900, 3)
    # A label that leaves the picture would cross its rim.
    for rim in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert (rim == 255).all()
    for left, right in ((0, 370), (370, 630), (630, 900)):
        assert (picture[:, left:right] < 200).any()


def test_the_sphere_is_shown_pixel_by_pixel(picture):
    assert (picture == [255, 0, 0]).all(axis=-1).sum() == 250 * 250


def test_the_slice_has_the_mirror_direction_at_the_left_and_grazing_above(picture):
    # Oracle: what GGX does. Pixels inside the frame of the slice; row 0 is at the top.
    inside = picture[48:246, 412:610].sum(axis=-1)
    assert inside[150, 5] > inside[150, 140] + 100
    assert inside[2, 5] > inside[190, 5] + 50


def test_lobes_lean_away_from_the_light(picture):
    # Coloured pixels below the arrows: GGX reflects to the right where the light is at the left.
    lobes = picture[120:210, 2:358]
    coloured = lobes.max(axis=-1) - lobes.min(axis=-1) > 12
    assert coloured[:, 180:].sum() > 5 * coloured[:, :176].sum()


def test_without_opengl_the_panel_says_so(tmp_path):
    portrait.draw(brdf.build("lambert"), tmp_path / "lambert.png", None)
    panel = np.asarray(Image.open(tmp_path / "lambert.png").convert("L"))[60:280, 640:890]
    assert 50 < (panel < 128).sum() < 2000


@pytest.mark.parametrize("arguments", [["ggx", "--pages", "x"], ["--pages", "x", "--json"], ["ggx", "--markdown"]])
def test_options_that_exclude_each_other_are_refused(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert isinstance(CliRunner().invoke(command, arguments).exception, UserError)
    assert list(tmp_path.iterdir()) == []
