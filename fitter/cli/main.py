"""The command `brdf`: finds its subcommands by file name and turns errors into messages and exit codes."""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import pathlib
import sys

import click

from brdf.errors import UserError

_NOT_COMMANDS = {"main", "options"}
# New objects after which Python looks for garbage.
_GARBAGE_THRESHOLD = 50_000


class _Commands(click.Group):
    """Imports `fitter/cli/NAME.py` when its command is asked for, and calls its `command`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        stems = {file.stem for file in pathlib.Path(__file__).parent.glob("[!_]*.py")}
        return sorted(stems - _NOT_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.list_commands(ctx):
            return None
        return importlib.import_module(f".{cmd_name}", __package__).command


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="brdf-fitter", prog_name="brdf")
def cli() -> None:
    """Fits reflectance models to measurements and previews the fitted materials.

    \b
    Example:
      brdf fit gold.binary --model lambert+ggx -o gold.json --plot gold-fit.png
      brdf preview gold.json -o gold.png
    """


def main() -> None:
    """Entry point. Exit status: 0 done, 1 failed, 2 wrong usage."""
    # Modules stay: to look through them for garbage while they are loaded, and once more at the end, takes a tenth of a
    # short command.
    gc.set_threshold(_GARBAGE_THRESHOLD)
    atexit.register(gc.freeze)
    try:
        # click returns the status of a command that leaves through its context.
        status = cli(prog_name="brdf", standalone_mode=False)
        sys.exit(status if isinstance(status, int) else 0)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except click.exceptions.Exit as error:
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        _fail("stopped.", 130)
    except UserError as error:
        _fail(str(error), error.exit_status)
    except BrokenPipeError:
        # The reader of our output has left; Python must not complain about it once more when it exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        _fail(f"{error.filename or 'writing'}: {error.strerror or error}. Check the path, permissions and free space.")
    except MemoryError:
        _fail("memory ran out. Fit fewer samples or close other programs.")


def _fail(message: str, status: int = 1) -> None:
    click.echo(f"brdf: {message}", err=True)
    sys.exit(status)
