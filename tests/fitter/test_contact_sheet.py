"""Contact sheets: where pictures and texts stand, and that nothing is cropped."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import brdf
from fitter.cli._sheet_fits import fits
from fitter.cli.main import cli
from fitter.contact_sheet import Row, Tile, contact_sheet

SIZE = 40
RED, BLUE = (np.broadcast_to(np.array(colour), (SIZE, SIZE, 3)) for colour in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))


def _count(sheet: Image.Image, colour: tuple[int, int, int]) -> int:
    return int((np.asarray(sheet) == colour).all(axis=-1).sum())


def test_every_picture_is_whole_and_in_its_place():
    rows = [Row(("first",), (Tile(RED), Tile(None))), Row(("second",), (Tile(None), Tile(BLUE, ("a", "b"))))]
    sheet = contact_sheet("t", rows, SIZE)
    assert _count(sheet, (255, 0, 0)) == _count(sheet, (0, 0, 255)) == SIZE * SIZE
    pixels = np.asarray(sheet).astype(int)
    red, blue = (np.argwhere((pixels == colour).all(-1)).mean(0) for colour in ([255, 0, 0], [0, 0, 255]))
    assert (blue > red + SIZE).all()


def test_no_text_leaves_the_sheet_or_its_picture():
    long = "a caption that is far wider than its picture"
    tall = contact_sheet("a title that is wider than all pictures", [Row((), (Tile(RED, (long,)),))], SIZE)
    ink = np.asarray(tall).min(axis=-1) < 200
    assert not np.concatenate([ink[:, :2].ravel(), ink[:, -2:].ravel(), ink[:2].ravel(), ink[-2:].ravel()]).any()
    assert not ink[-18:, 6 + SIZE :].any()


@pytest.mark.gpu
def test_a_fit_is_shown_beside_its_measurement_and_kept(tmp_path):
    from fitter.formats import merl

    model = brdf.MODELS["ggx"](f0=[0.8, 0.5, 0.2], alpha=0.3)
    path = tmp_path / "made.binary"
    merl.write_function(lambda wi, wo: np.asarray(brdf.evaluate(model, wi, wo)), path, (24, 12, 12))
    keep = tmp_path / "kept"
    arguments = ["sheet", "fits", str(path), "-m", "ggx", "-o", str(tmp_path / "s.png"), "--keep", str(keep), "-q"]
    done = CliRunner().invoke(cli, [*arguments, "--tile", "48"])
    assert done.exit_code == 0, done.output
    kept = json.loads((keep / "made" / "ggx.json").read_text())
    assert kept["parameters"]["ggx"]["alpha"] == pytest.approx(0.3, abs=1e-3)
    # A second call fits nothing.
    (found,) = fits(None, ("ggx",), keep / "made", pytest.fail)
    assert found.log_mae < 1e-3
    sheet = np.asarray(Image.open(tmp_path / "s.png")).astype(float)
    # The measured sphere and the fitted one beside it.
    top = next(row for row in range(len(sheet)) if (sheet[row, 6:54] == sheet[row, 6]).all() and sheet[row, 6, 0] < 150)
    left, right = sheet[top : top + 48, 6:54], sheet[top : top + 48, 60:108]
    assert np.abs(left - right).mean() < 12
    assert left.std() > 20
