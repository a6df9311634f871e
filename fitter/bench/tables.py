"""Tables of text, for a terminal and for the docs."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

# Of the sentences in a terminal.
_WIDTH = 100

Table = list[Sequence[str]]


def filled(text: str) -> str:
    """A sentence broken into lines."""
    return textwrap.fill(text, _WIDTH)


def aligned(rows: Table) -> str:
    """A table of aligned columns; the first row is the head."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(
            [f"{row[0]:{widths[0]}}", *(f"{cell:>{width}}" for cell, width in zip(row[1:], widths[1:], strict=True))]
        )
        for row in rows
    ]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]])


def piped(rows: Table) -> str:
    """A table in Markdown."""
    lines = [rows[0], ["---", *["---:"] * (len(rows[0]) - 1)], *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
