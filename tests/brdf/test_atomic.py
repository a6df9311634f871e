"""Whole files or none."""

from __future__ import annotations

import os
import stat

import pytest

from brdf.atomic import atomic_path
from brdf.errors import FileError


def test_file_appears_only_when_the_block_ends_well(tmp_path):
    target = tmp_path / "out.json"
    with atomic_path(target) as temporary:
        temporary.write_text("whole")
        assert not target.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".json"
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]


def test_failed_block_leaves_the_old_file_and_no_other(tmp_path):
    target = tmp_path / "out.json"
    target.write_text("old")
    with pytest.raises(RuntimeError), atomic_path(target, force=True) as temporary:  # noqa: PT012
        temporary.write_text("half")
        raise RuntimeError("stop")
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_existing_file_is_kept_without_force_and_replaced_with_it(tmp_path):
    target = tmp_path / "out.json"
    target.write_text("old")
    with pytest.raises(FileError, match="--force"), atomic_path(target):
        pytest.fail("the block must not run")
    with atomic_path(target, force=True) as temporary:
        temporary.write_text("new")
    assert target.read_text() == "new"


def test_file_that_appears_in_the_meantime_is_not_overwritten(tmp_path):
    target = tmp_path / "out.json"
    with pytest.raises(FileError, match="--force"), atomic_path(target) as temporary:  # noqa: PT012
        temporary.write_text("mine")
        target.write_text("theirs")
    assert target.read_text() == "theirs"
    assert list(tmp_path.iterdir()) == [target]


def test_folder_as_target_and_missing_folder_are_refused(tmp_path):
    with pytest.raises(FileError, match="is a folder"), atomic_path(tmp_path, force=True):
        pytest.fail("the block must not run")
    missing = tmp_path / "missing" / "out.json"
    with pytest.raises(FileError, match="does not exist"), atomic_path(missing):
        pytest.fail("the block must not run")


def test_written_file_has_the_permissions_of_any_new_file(tmp_path):
    # Oracle: a file that the system creates under the same mask.
    (tmp_path / "plain").write_text("")
    with atomic_path(tmp_path / "out.json") as temporary:
        temporary.write_text("")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "out.json")]
    assert modes[0] == modes[1]


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="root may write anywhere")
def test_folder_without_write_permission_is_told_at_once(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(FileError, match="permissions"), atomic_path(tmp_path / "out.json"):
            pytest.fail("the block must not run")
    finally:
        tmp_path.chmod(0o700)
