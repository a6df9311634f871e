"""What libraries print by themselves, kept from the user's terminal and from results on stdout."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterator

# The process has one stdout: two threads that exchange it at once would keep each other's nowhere.
_LOCK = threading.RLock()


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Sends all that this process prints meanwhile to nowhere, also what is not printed by Python.

    Use it around a call of a library that reports by its return value or an exception as well. One thread at a time is
    silent, others wait. Where the process has no stdout or stderr, there is nothing to do.
    """
    with _LOCK, open(os.devnull, "w") as nowhere, contextlib.ExitStack() as stack:
        for number, stream in ((1, sys.stdout), (2, sys.stderr)):
            with contextlib.suppress(OSError, ValueError, AttributeError):
                stream.flush()
            with contextlib.suppress(OSError):
                kept = os.dup(number)
                stack.callback(os.close, kept)
                stack.callback(os.dup2, kept, number)
                os.dup2(nowhere.fileno(), number)
        stack.enter_context(contextlib.redirect_stdout(nowhere))
        stack.enter_context(contextlib.redirect_stderr(nowhere))
        yield
