"""When the truth stops: the estimated error against the measured one, and each of its limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import brdf
from shaders import Environment, Image, Part, Renderer, Scene
from shaders.blurred_sky import blurred

pytestmark = pytest.mark.gpu

SPOTS = np.full((16, 32, 3), 0.2, np.float32)
SPOTS[3, 5], SPOTS[6, 20] = (20, 10, 5), (5, 10, 20)
SPOTS_SKY = Environment(SPOTS, "spots")


def _picture(**settings: Any) -> Image:
    part = Part(brdf.MODELS["ggx"](f0=0.8, alpha=0.4))
    return Renderer().render(Scene((part,), SPOTS_SKY, **{"width": 64, "height": 64} | settings))


def _measured(image: Image, truth: Image) -> float:
    """The RMS difference of the display pictures where the ball is, weighted by its coverage."""
    assert image.display is not None
    assert truth.display is not None
    weight = truth.display[..., 3]
    square = np.square(image.display - truth.display)[..., :3].mean(axis=-1)
    return float(np.sqrt((square * weight).sum() / weight.sum()))


def test_the_estimated_error_is_the_measured_one():
    truth = _picture(samples=8192, sky="none")
    ratios = []
    for samples in (128, 256, 512, 1024, 2048):
        image = _picture(samples=samples, error=1e-5, sky="none")
        error = image.counts["error"]
        assert error is not None
        ratios.append(error / _measured(image, truth))
    # An estimate is itself noisy: at the outline, where most of the error is, by the few offsets that all pixels share.
    # The truth's own error is far below.
    np.testing.assert_allclose(ratios, 1, atol=0.4)
    assert float(np.exp(np.log(ratios).mean())) == pytest.approx(1, abs=0.15)


def test_a_truth_stops_when_its_error_is_reached_and_not_long_after():
    image = _picture(error=0.004)
    assert image.counts["error"] <= 0.004
    assert image.counts["stopped"] == "the error is at most 0.004"
    # A factor of 1.25 in samples between two looks; 64 pixels square of noise.
    assert image.counts["error"] > 0.0016
    assert image.counts["samples"] > 128


def test_without_a_limit_the_error_is_five_thousandths_or_the_samples_are_spent():
    counts = _picture(width=24, height=24).counts
    assert counts["error"] <= 0.005 or counts["samples"] >= 512


def test_a_truth_stops_at_its_samples_and_at_its_time():
    counts = _picture(error=1e-5, samples=100).counts
    assert counts["samples"] == 128
    assert counts["stopped"] == "128 samples were drawn"
    # Not a measurement of time: the limit is over before the first frame is.
    counts = _picture(error=1e-5, seconds=1e-9).counts
    assert counts["frames"] == 2
    assert counts["stopped"] == "1e-09 seconds had passed"


def test_samples_alone_are_exact():
    assert _picture(samples=64).counts["samples"] == 64
    assert _picture(samples=65).counts["samples"] == 80


def test_samples_alone_are_one_sequence_whose_error_is_smaller_and_not_known():
    truth = _picture(samples=8192, sky="none")
    fixed, halves = (_picture(samples=512, sky="none", **asked) for asked in ({}, {"error": 1e-5}))
    assert fixed.counts["samples"] == halves.counts["samples"] == 512
    assert fixed.counts["error"] is None
    assert _measured(fixed, truth) < 0.95 * _measured(halves, truth)


def test_a_still_has_one_sum_and_knows_no_error():
    counts = _picture(tier="still").counts
    assert counts["error"] is None
    assert counts["samples"] == 64


def test_another_exposure_shows_the_same_sums_and_estimates_their_error_anew():
    renderer, part = Renderer(), Part(brdf.MODELS["ggx"](f0=0.8, alpha=0.4))
    plain, darker = (
        renderer.render(Scene((part,), SPOTS_SKY, width=32, height=32, samples=64, error=1e-5, exposure=stops))
        for stops in (0.0, -4.0)
    )
    assert darker.counts["samples"] == plain.counts["samples"]
    # Sixteen times darker, encoded: errors shrink by 16 in linear light, by less after encoding.
    assert darker.counts["error"] < 0.5 * plain.counts["error"]


def test_a_blurred_sky_keeps_the_light_of_all_directions_and_has_no_detail():
    pixels = np.random.default_rng(2).random((128, 256, 3), np.float32)
    pixels[:64] += 1.0
    smooth = blurred(Environment(pixels, "noise")).pixels.astype(np.float64)
    weight = np.sin(np.pi * (np.arange(64) + 0.5) / 64)[:, None, None]
    fine = np.sin(np.pi * (np.arange(128) + 0.5) / 128)[:, None, None]
    # Oracle: a convolution with a kernel of integral 1 keeps the integral over the sphere; 1 % for the small grid.
    np.testing.assert_allclose(
        (smooth * weight).mean((0, 1)) / weight.mean(), (pixels * fine).mean((0, 1)) / fine.mean(), rtol=0.01
    )
    # Far from the horizon it is the mean of the noise.
    np.testing.assert_allclose(smooth[8], 1.5, rtol=0.05)
    np.testing.assert_allclose(smooth[-8], 0.5, rtol=0.05)
    # No seam: the step across u = 0 is like any other.
    steps = np.abs(np.diff(smooth, axis=1, append=smooth[:, :1])).max(axis=(0, 2))
    assert steps[-1] <= 1.5 * steps[:-1].max()
