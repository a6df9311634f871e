"""Shared by all tests: strict JAX settings, run-time checks of shapes and types, and the folder of real data."""

import os
import pathlib

import hypothesis
import jax
import pytest
from jaxtyping import install_import_hook

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")
# What an earlier run has compiled or made is used again; the first run fills this. Never the user's own folder.
_KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
jax.config.update("jax_compilation_cache_dir", str(_KEPT / "jax"))
os.environ["BRDF_CACHE_DIR"] = str(_KEPT / "brdf")
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)

_hook = install_import_hook(["brdf", "fitter", "shaders"], "type_checker.check")

hypothesis.settings.register_profile("house", derandomize=True, deadline=None)
hypothesis.settings.load_profile("house")


@pytest.fixture(scope="session")
def shared() -> pathlib.Path:
    """The folder of real measurements and independent values beside the checkout; skips where it is missing."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip(f"needs real data in {folder.parent.name}/{folder.name}, which is not on this machine")
    return folder


@pytest.fixture(autouse=True)
def _opengl(request: pytest.FixtureRequest) -> None:
    """Skips a test that is marked `gpu`, saying what was tried, where there is no OpenGL 4.3."""
    if request.node.get_closest_marker("gpu") is None:
        return
    from shaders.context import describe

    found = describe()
    if not found["available"]:
        pytest.skip(f"needs OpenGL 4.3: {found['problem']}")
