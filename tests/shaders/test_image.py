"""Pictures out. Oracle: reading them back with Pillow."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from PIL import Image as PillowImage

import brdf
from shaders import write_exr, write_png


@pytest.mark.parametrize("channels", [3, 4])
def test_a_png_reads_back_to_half_a_step(tmp_path: pathlib.Path, channels: int):
    display = np.random.default_rng(1).random((7, 5, channels)).astype(np.float32)
    write_png(tmp_path / "a.tmp", display)
    with PillowImage.open(tmp_path / "a.tmp") as read:
        assert read.format == "PNG"
        np.testing.assert_allclose(np.asarray(read) / 255, display, atol=0.5 / 255 + 1e-6)


@pytest.mark.parametrize("write", [write_png, write_exr])
@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 2), (0, 4, 3)])
def test_what_is_no_picture_is_refused(tmp_path: pathlib.Path, write, shape: tuple[int, ...]):
    with pytest.raises(brdf.UserError, match="not the shape of a picture"):
        write(tmp_path / "a.png", np.zeros(shape))


def test_a_png_refuses_nan(tmp_path: pathlib.Path):
    with pytest.raises(brdf.UserError, match="NaN"):
        write_png(tmp_path / "a.png", np.full((2, 2, 3), np.nan))
