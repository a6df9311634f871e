"""The errors a user can cause. Libraries raise them; only the command line prints them and exits."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable


class UserError(ValueError):
    """Something the user can mend: the message names the offending value, the rule and the remedy.

    `exit_status` is the command line's: 2 for wrong usage, 1 for what failed all the same.
    """

    exit_status = 2


class FileError(UserError):
    """A file that cannot be used as it is.

    **Arguments:**

    - `path`: the file, as the user named it.
    - `problem`: what is wrong and where in the file (byte, line, field, key), one sentence.
    - `remedy`: what to do about it, one sentence.
    """

    exit_status = 1

    def __init__(self, path: str | os.PathLike[str], problem: str, remedy: str):
        self.path = os.fspath(path)
        self.problem = problem
        self.remedy = remedy
        super().__init__(f"{self.path}: {problem} {remedy}")


def nearest(name: str, known: Iterable[str]) -> str:
    """A sentence part that names the nearest known name and all known names, for an error message."""
    known = list(known)
    close = difflib.get_close_matches(name.lower(), known, 1, 0.5)
    return (f"Did you mean `{close[0]}`? " if close else "") + "Known: " + ", ".join(known) + "."
