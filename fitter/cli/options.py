"""What several subcommands share: options, the outputs' checks, progress, and the compilation cache."""

from __future__ import annotations

import contextlib
import os
import pathlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import click

from brdf.errors import UserError

force = click.option("--force", is_flag=True, help="Replace output files that exist.")
quiet = click.option("--quiet", "-q", is_flag=True, help="No progress on stderr.")
as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a text to read.")


def check_output(path: str | None, suffixes: tuple[str, ...], force: bool) -> None:
    """Refuses an output before any work is done: a wrong suffix, a missing folder, a file that exists.

    Raises `UserError` for the suffix, `FileError` for the rest; does nothing if `path` is None.
    """
    if path is None:
        return
    from brdf.atomic import refuse_to_overwrite

    if pathlib.Path(path).suffix.lower() not in suffixes:
        raise UserError(f"`{path}` does not end in {' or '.join(suffixes)}. Name the file so.")
    refuse_to_overwrite(path, force)


def pairs(texts: tuple[str, ...], option: str) -> dict[str, str]:
    """Splits `name=value` texts; raises `UserError`, naming the option, for one without `=`."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise UserError(f"`{option} {text}` is not a name and a value. Write `{option} name=value`.")
        found[name.strip()] = value.strip()
    return found


@contextlib.contextmanager
def progress(quiet: bool) -> Iterator[Callable[[str], None]]:
    """A function that shows what is being done now, on stderr: a spinner on a terminal, lines in a log."""
    if quiet:
        yield lambda sentence: None
        return
    if not sys.stderr.isatty():
        yield lambda sentence: click.echo(sentence, err=True)
        return
    from rich.console import Console

    with Console(stderr=True).status("starting") as status:
        yield status.update


@contextlib.contextmanager
def leaving_at_once() -> Iterator[None]:
    """Inside, Ctrl-C ends the process where it stands, with status 130; for work that has nothing to clean up.

    An exception would be lost or crash when it is raised in a garbage collector's callback, as JAX has one, or while a
    compiled module is imported. Does nothing in a thread, where signals do not arrive.
    """

    def leave(signum: int, frame: object) -> None:
        show_cursor = "\x1b[?25h" if sys.stderr.isatty() else ""
        # Not through Python's buffers: the interruption may have come while one was written to.
        os.write(2, f"{show_cursor}\nbrdf: stopped.\n".encode())
        os._exit(130)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def value(text: str) -> Any:
    """A number, a list of numbers, or the text itself."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers[0] if len(numbers) == 1 else numbers


def cache_compilations() -> None:
    """Keeps compiled JAX programs on disk between runs, in `BRDF_CACHE_DIR` or the user's cache folder."""
    folder = cache_folder()
    if folder is not None:
        import jax

        jax.config.update("jax_compilation_cache_dir", folder)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def cache_folder() -> str | None:
    """The folder for compiled programs; None if it cannot be written."""
    from brdf.cache import cache_folder as folder

    found = folder("jax")
    return None if found is None else str(found)
