"""A plan as a picture: a box per pass, an edge from the pass that writes a resource to each that reads it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.sax.saxutils import escape

from .plan import FramePlan, Pass

# All in pixels.
_BOX = (168, 62)
_STEP = (228, 82)
_MARGIN = 24
# Fill, outline and text by what became of the pass.
_COLORS = {
    "run": ("#d7f0d8", "#2e7d32", "#14401a"),
    "reused": ("#dbe9fb", "#1f5fae", "#123a6b"),
    "dropped": ("#f4f4f4", "#a8a8a8", "#777777"),
}
_FONT = "font-family='DejaVu Sans, Verdana, sans-serif'"


def plan_svg(plan: FramePlan, milliseconds: Mapping[str, float]) -> str:
    """The plan as the text of an SVG file, to be read from left to right.

    **Arguments:**

    - `plan`: as `Image.plan` has it.
    - `milliseconds`: how long the passes that ran took, by name, as in `Image.counts`.
    """
    places = _places(plan.declared)
    width = _MARGIN * 2 + _STEP[0] * max(column for column, _ in places.values()) + _BOX[0]
    height = _MARGIN * 2 + _STEP[1] * max(row for _, row in places.values()) + _BOX[1] + 30
    lines = [
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{width}' height='{height}' viewBox='0 0 {width} {height}'>",
        f"<rect width='{width}' height='{height}' fill='white'/>",
    ]
    # Edges first: boxes cover what passes below them. Those of what was not needed come first of all.
    for status in ("dropped", "reused", "run"):
        for writer, reader in _edges(plan.declared):
            if status == _edge_status(plan, writer, reader):
                lines.append(_edge(places[writer], places[reader], status))
    lines += [_box(plan, one, places[one.name], milliseconds) for one in plan.declared]
    for index, status in enumerate(_COLORS):
        left, base = _MARGIN + 110 * index, height - 14
        fill, outline, text = _COLORS[status]
        lines.append(
            f"<rect x='{left}' y='{base - 12}' width='16' height='14' rx='3' fill='{fill}' stroke='{outline}'/>"
        )
        lines.append(f"<text x='{left + 23}' y='{base}' {_FONT} font-size='13' fill='{text}'>{status}</text>")
    return "\n".join([*lines, "</svg>", ""])


def _status(plan: FramePlan, name: str) -> str:
    return "run" if plan.runs(name) else "reused" if name in plan.reused else "dropped"


def _edge_status(plan: FramePlan, writer: str, reader: str) -> str:
    if not plan.runs(reader):
        return "dropped"
    return _status(plan, writer)


def _edges(declared: Iterable[Pass]) -> list[tuple[str, str]]:
    """Writer and reader; a resource that several passes write comes from all of those before the reader."""
    edges: list[tuple[str, str]] = []
    before: list[Pass] = []
    for reader in declared:
        edges += [(writer.name, reader.name) for writer in before if writer.writes & reader.reads]
        before.append(reader)
    return edges


def _places(declared: tuple[Pass, ...]) -> dict[str, tuple[int, int]]:
    """Column and row: a pass stands right of all that it reads from."""
    columns: dict[str, int] = {}
    edges = _edges(declared)
    for one in declared:
        columns[one.name] = 1 + max((columns[writer] for writer, reader in edges if reader == one.name), default=-1)
    rows = dict.fromkeys(columns.values(), 0)
    places = {}
    for name, column in columns.items():
        places[name] = (column, rows[column])
        rows[column] += 1
    return places


def _edge(start: tuple[int, int], end: tuple[int, int], status: str) -> str:
    x, y = _MARGIN + _STEP[0] * start[0] + _BOX[0], _MARGIN + _STEP[1] * start[1] + _BOX[1] / 2
    to_x, to_y = _MARGIN + _STEP[0] * end[0], _MARGIN + _STEP[1] * end[1] + _BOX[1] / 2
    outline = _COLORS[status][1]
    dash = " stroke-dasharray='4 4'" if status == "dropped" else ""
    path = f"M {x} {y} C {x + 45} {y}, {to_x - 45} {to_y}, {to_x - 7} {to_y}"
    tip = f"M {to_x} {to_y} l -9 -4.5 l 0 9 z"
    return (
        f"<path d='{path}' fill='none' stroke='{outline}' stroke-width='1.6'{dash}/><path d='{tip}' fill='{outline}'/>"
    )


def _box(plan: FramePlan, one: Pass, place: tuple[int, int], milliseconds: Mapping[str, float]) -> str:
    status = _status(plan, one.name)
    fill, outline, text = _COLORS[status]
    x, y = _MARGIN + _STEP[0] * place[0], _MARGIN + _STEP[1] * place[1]
    said = {"run": f"{milliseconds.get(one.name, 0.0):.1f} ms", "reused": "reused"}.get(status, "")
    said = said or plan.dropped[one.name]
    dash = " stroke-dasharray='4 3'" if status == "dropped" else ""
    words = [(one.name, 14, "bold"), (f"→ {_written(one)}", 11, "normal"), (said, 11, "normal")]
    lines = [
        f"<rect x='{x}' y='{y}' width='{_BOX[0]}' height='{_BOX[1]}' rx='7' fill='{fill}' stroke='{outline}'{dash}/>"
    ]
    for (word, size, weight), base in zip(words, (20, 37, 53), strict=True):
        lines.append(
            f"<text x='{x + 10}' y='{y + base}' {_FONT} font-size='{size}' font-weight='{weight}' fill='{text}'>"
            f"{escape(word)}</text>"
        )
    return "\n".join(lines)


def _written(one: Pass) -> str:
    """The resources, those that there is one of for every part under one name."""
    names = sorted({name.partition("[")[0] for name in one.writes})
    return ", ".join(names) if len(names) < 3 else f"{names[0]} and {len(names) - 1} more"
