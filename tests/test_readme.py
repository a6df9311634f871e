"""The README against the program it describes."""

import pathlib

from fitter.catalogue import markdown_table

ROOT = pathlib.Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_the_table_of_models_is_the_declarations():
    table = README.partition("`brdf models --markdown` -->\n")[2].partition("\n<!-- /models")[0]
    assert table == markdown_table()


def test_every_command_named_exists():
    commands = {line.split()[1] for line in README.splitlines() if line.startswith("brdf ")}
    files = {file.stem for file in (ROOT / "fitter" / "cli").glob("*.py")}
    assert commands
    assert commands <= files


def test_its_picture_is_there():
    assert (ROOT / "docs" / "demo.png").read_bytes().startswith(b"\x89PNG")
