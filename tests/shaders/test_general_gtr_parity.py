"""`general_gtr` in GLSL float32 against float64 over its whole parameter box, on the same rounded numbers."""

from __future__ import annotations

import numpy as np
import pytest
from directions import adversarial_pairs
from numpy.typing import NDArray

import brdf

pytestmark = pytest.mark.gpu

# Rounding of an exponent, up to 87, multiplied into the value: measured are 1.2e-5 at most.
BOUND = 2e-5
# Below it float32 itself has fewer digits.
_NORMAL = 1e-36


def _rounded(value: object) -> NDArray[np.float64]:
    return np.asarray(value, np.float32).astype(np.float64)


@pytest.mark.parametrize("spread", [-1.0, -0.4, 0.0, 0.7, 1.0])
@pytest.mark.parametrize("alpha", [1e-4, 1e-2, 0.3, 1.0])
def test_general_gtr_agrees_with_float64(alpha: float, spread: float):
    from shaders import evaluate

    wi, wo = adversarial_pairs(81, alpha, 1000)
    for gamma, falloff in ((0.5, 10.0), (1.0, 5.0), (2.7, 0.5), (10.0, 3.1)):
        model = brdf.MODELS["general_gtr"](
            # No two channels equal: a swap would show.
            f0=_rounded([0.02, 0.5, 0.97]),
            f90=_rounded([0.9, 0.3, 0.0]),
            alpha=_rounded(alpha),
            gamma=_rounded(gamma),
            spread=_rounded(spread),
            falloff=_rounded(falloff),
        )
        value = evaluate(model, wi, wo)
        truth = np.asarray(brdf.evaluate(model, wi.astype(np.float64), wo.astype(np.float64)))
        assert np.isfinite(value).all()
        assert (value >= 0).all()
        counted = truth > _NORMAL
        assert counted.sum() > 1000
        error = np.abs(value[counted] - truth[counted]) / truth[counted]
        assert error.max() <= BOUND, (gamma, falloff, error.max())
