"""Pictures out. Oracle: reading them back with Pillow."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from PIL import Image as PillowImage

import brdf
from shaders import write_exr, write_png


@pytest.mark.parametrize("channels", [3, 4])
def test_a_png_reads_back_to_one_step(tmp_path: pathlib.Path, channels: int):
    display = np.random.default_rng(1).random((7, 5, channels)).astype(np.float32)
    write_png(tmp_path / "a.tmp", display)
    with PillowImage.open(tmp_path / "a.tmp") as read:
        assert read.format == "PNG"
        np.testing.assert_allclose(np.asarray(read) / 255, display, atol=1 / 255 + 1e-6)


def test_a_png_keeps_what_eight_bits_hold_and_the_mean_of_the_rest(tmp_path: pathlib.Path):
    exact = np.broadcast_to(np.arange(256, dtype=np.float32)[:, None, None] / 255, (256, 8, 3))
    write_png(tmp_path / "a.png", exact)
    with PillowImage.open(tmp_path / "a.png") as read:
        np.testing.assert_array_equal(np.asarray(read), np.rint(exact * 255))
    # Dither: without it a constant between two levels comes back as one of them, half a level off.
    write_png(tmp_path / "b.png", np.full((64, 64, 3), 100.5 / 255))
    with PillowImage.open(tmp_path / "b.png") as read:
        assert abs(np.asarray(read).mean() - 100.5) < 0.05


@pytest.mark.parametrize("write", [write_png, write_exr])
@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 2), (0, 4, 3)])
def test_what_is_no_picture_is_refused(tmp_path: pathlib.Path, write, shape: tuple[int, ...]):
    with pytest.raises(brdf.UserError, match="not the shape of a picture"):
        write(tmp_path / "a.png", np.zeros(shape))


def test_a_png_refuses_nan(tmp_path: pathlib.Path):
    display = np.zeros((4, 5, 3))
    display[1, 3, 2] = display[2, 0, 0] = np.nan
    with pytest.raises(brdf.UserError, match=r"`row 1, column 3` .* is NaN.* \.exr"):
        write_png(tmp_path / "a.png", display)
    assert not (tmp_path / "a.png").exists()
