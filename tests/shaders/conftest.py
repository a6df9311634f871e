"""What the tests of the shaders share: the skip without OpenGL, and float64 as the truth."""

from __future__ import annotations

import jax
import pytest

jax.config.update("jax_enable_x64", True)


@pytest.fixture(autouse=True)
def _opengl(request: pytest.FixtureRequest) -> None:
    """Skips a test that is marked `gpu` where there is no OpenGL 4.3."""
    if request.node.get_closest_marker("gpu") is None:
        return
    from shaders.context import describe

    found = describe()
    if not found["available"]:
        pytest.skip(found["problem"])
