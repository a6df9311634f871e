"""What models declare and what their functions say of them, kept on disk: a material of a known kind needs no JAX.

As Python keeps compiled modules, this depends on the program alone. A material's own numbers are read from its file
each time.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import os
import pathlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

import brdf
from brdf.material import load_plain
from brdf.parameter import Choice, Parameter
from brdf.plain import Declaration, PlainLobe, declared

from .kept_tables import Arrays, kept
from .material_block import twin_of_lobes
from .traced import Traced, trace
from .twin import Twin

# Not among the tables, which are of one material or environment each.
FOLDER = "models"
# Their versions say how they are made and written: `traced` is not among the files of the program's digest.
_DECLARATION, _TRACE = "declaration-1", "trace-1"


def twin_of_file(path: str | os.PathLike[str]) -> Twin:
    """The twin of a material file, as `material_block.twin` makes it of the loaded material.

    JAX is loaded only for a model that was never seen, or not with these choices and these weights of 0.

    Raises what `brdf.load_material` raises.
    """
    lobes = load_plain(path, _declaration)
    return twin_of_lobes(lobes, {name: _traced(lobe) for name, lobe in lobes.items()})


def _declaration(model: str) -> Declaration:
    def make() -> Arrays:
        content = json.dumps(dataclasses.asdict(declared(model)))
        return {"json": np.frombuffer(content.encode(), np.uint8)}

    found = json.loads(kept(_DECLARATION, (_program(), model.encode()), make, FOLDER)["json"].tobytes())
    parameters = tuple(Parameter(**_fields(one)) for one in found["parameters"])
    return Declaration(parameters, tuple(Choice(**_fields(one)) for one in found["choices"]))


def _fields(found: dict[str, Any]) -> dict[str, Any]:
    return {name: _tuples(value) for name, value in found.items()}


def _tuples(value: Any) -> Any:
    """JSON's lists as the tuples that they were."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _traced(lobe: PlainLobe) -> Traced:
    def make() -> Arrays:
        made = trace(lobe.build())
        unused = np.zeros(0)
        tables = {f"table_{name}": unused if table is None else table for name, table in made.tables.items()}
        return {"proposals": np.array(made.proposals), **tables}

    structure = json.dumps([lobe.model, dict(lobe.options), lobe.absent])
    found = kept(_TRACE, (_program(), structure.encode()), make, FOLDER)
    tables = {
        name.removeprefix("table_"): _used(np.asarray(table, np.float64))
        for name, table in found.items()
        if name != "proposals"
    }
    return Traced(tables, int(found["proposals"]))


def _used(table: NDArray[np.float64]) -> NDArray[np.float64] | None:
    return table if table.size else None


@functools.cache
def _program() -> bytes:
    """A digest of all files that the models are made of."""
    digest = hashlib.blake2b(digest_size=16)
    folder = pathlib.Path(brdf.__file__).parent
    for file in sorted(folder.rglob("*.py")):
        content = file.read_bytes()
        digest.update(f"{file.relative_to(folder)} {len(content)}\n".encode() + content)
    return digest.digest()
