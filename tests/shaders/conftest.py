"""Shared by the tests of shaders."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module")
def nothing_kept(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Lobes and blurs are made anew: those that an earlier run has kept would hide a change of how they are made."""
    from shaders.round_lobes import round_lobes

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BRDF_CACHE_DIR", str(tmp_path_factory.mktemp("kept")))
        round_lobes.cache_clear()
        yield
    round_lobes.cache_clear()
