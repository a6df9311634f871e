"""The sequence of points in GLSL. Oracle: the definition of a (0, 2)-sequence, and what scrambling leaves of it."""

from __future__ import annotations

import numpy as np
import pytest

import brdf
from shaders import evaluation
from shaders.sequence import sequence_point, shuffled_index

pytestmark = pytest.mark.gpu
_TEXT = """
#include "sequence.glsl"
vec3 result(vec3 a, vec3 b) {
    uvec2 seed = sequence_seed(uvec2(b.xy), uint(b.z));
    return vec3(unit_point(sequence_point(uint(a.x), seed)), 0.0);
}
"""


def _points(first: int, count: int, seed: int) -> np.ndarray:
    numbers = np.zeros((count, 3), np.float32)
    numbers[:, 0] = np.arange(first, first + count)
    seeds = np.broadcast_to(np.array([seed, 5, 7], np.float32), numbers.shape)
    return evaluation._run(_TEXT, brdf.build("lambert"), numbers, seeds)[:, :2]


@pytest.mark.parametrize("seed", [0, 1, 12345])
@pytest.mark.parametrize("start", [0, 3])
def test_every_elementary_interval_holds_one_of_each_run_of_points(seed: int, start: int):
    # A (0, 2)-sequence: of points k 2^m to (k + 1) 2^m - 1, one lies in each interval of area 2^-m.
    for m in (1, 4, 8):
        points = _points(start << m, 1 << m, seed)
        assert ((points >= 0) & (points < 1)).all()
        for across in range(m + 1):
            column = np.floor(points[:, 0] * 2**across).astype(int)
            row = np.floor(points[:, 1] * 2 ** (m - across)).astype(int)
            assert len(np.unique(column + (row << across))) == 1 << m


def test_seeds_move_every_point_evenly():
    # Mean 1/2 and variance 1/12 over 400 seeds, whichever the point; 4 standard deviations of the means.
    drawn = np.array([_points(0, 8, seed) for seed in range(400)])
    np.testing.assert_allclose(drawn.mean(axis=0), 0.5, atol=4 * (1 / 12 / 400) ** 0.5)
    np.testing.assert_allclose(drawn.var(axis=0), 1 / 12, atol=4 * (1 / 180 / 400) ** 0.5)


def test_the_hosts_points_are_those_of_the_shader():
    # Seeds as the host takes them, small enough for the float32 by which the shader gets them.
    text = _TEXT.replace("sequence_seed(uvec2(b.xy), uint(b.z))", "uvec2(b.xy)")
    numbers = np.zeros((64, 3), np.float32)
    numbers[:, 0] = np.arange(64)
    seeds = np.broadcast_to(np.array([123456, 7654321, 0], np.float32), numbers.shape)
    drawn = evaluation._run(text, brdf.build("lambert"), numbers, seeds)[:, :2]
    expected = [sequence_point(i, (123456, 7654321)) for i in range(64)]
    np.testing.assert_allclose(drawn, expected, atol=2**-23)


def test_another_order_of_the_points_has_the_same_runs_and_shares_no_bit_with_the_index():
    order = np.array([shuffled_index(i, 2654435769) for i in range(4096)])
    for m in (1, 4, 8):
        # Each aligned run of 2^m indices becomes one.
        assert len(np.unique(order.reshape(-1, 1 << m) >> m)) == 4096 >> m
        np.testing.assert_array_equal(np.ptp(order.reshape(-1, 1 << m) >> m, axis=1), 0)
    # Bits of the order agree with those of the index half the time; 5 standard deviations of the mean.
    for one in range(5):
        for other in range(8):
            alike = (order >> one & 1) == (np.arange(4096) >> other & 1)
            assert abs(alike.mean() - 0.5) < 5 * 0.5 / (2048 >> one) ** 0.5
