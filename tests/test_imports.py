"""Who may import whom (see CONTRIBUTING); the oracle is the syntax tree of every file."""

import ast
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parent.parent
ALLOWED = {"brdf": {"brdf"}, "shaders": {"shaders", "brdf"}, "fitter": {"fitter", "brdf"}}
FILES = sorted(file for package in ALLOWED for file in (ROOT / package).rglob("*.py"))
# Too slow to load before a subcommand is known.
HEAVY = {"jax", "equinox", "optimistix", "matplotlib", "moderngl", "colour", "OpenEXR", "numpy", "rich", "scipy"}
CONTEXT_ONLY = "moderngl"


def imported(tree: ast.AST, package: str):
    """Top-level names of everything a file imports, relative imports resolved."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield package if node.level else (node.module or "").partition(".")[0]


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_packages_import_only_what_they_may(file):
    package = file.relative_to(ROOT).parts[0]
    ours = {name for name in imported(ast.parse(file.read_text()), package) if name in ALLOWED}
    allowed = ALLOWED[package] | ({"shaders"} if "cli" in file.relative_to(ROOT).parts else set())
    assert ours <= allowed


@pytest.mark.parametrize("file", sorted((ROOT / "fitter" / "cli").glob("*.py")), ids=lambda file: file.stem)
def test_the_command_line_imports_nothing_heavy_at_its_top(file):
    top = ast.Module([n for n in ast.parse(file.read_text()).body if isinstance(n, ast.Import | ast.ImportFrom)], [])
    assert not set(imported(top, "fitter")) & HEAVY


def test_help_loads_no_heavy_module():
    code = (
        "import sys; sys.argv = ['brdf', '--help']\n"
        "from fitter.cli.main import main\n"
        "try: main()\n"
        f"finally: print('HEAVY', sorted({sorted(HEAVY)!r} & sys.modules.keys()))"
    ).replace(f"{sorted(HEAVY)!r} &", f"set({sorted(HEAVY)!r}) &")
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True).stdout
    assert "HEAVY []" in out


@pytest.mark.parametrize("package", ["brdf", "fitter"])
def test_files_stay_short_enough_to_hold_one_idea(package):
    for file in (ROOT / package).rglob("*.py"):
        assert len(file.read_text().splitlines()) <= 320, file
