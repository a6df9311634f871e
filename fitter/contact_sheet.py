"""Many small pictures on one sheet, in rows, each with a caption of its own."""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Sequence

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

_PAPER, _INK, _FAINT = (255, 255, 255), (34, 34, 34), (110, 110, 110)
_GAP = 6
_TITLE_SIZE, _LABEL_SIZE, _CAPTION_SIZE = 17, 14, 12
# Between the lines of a text, as a factor of its size.
_LEADING = 1.3
_HEADING = 24


@dataclasses.dataclass(frozen=True)
class Tile:
    """A picture with up to a few lines below it.

    - `picture`: (size, size, 3), encoded for displays, in [0, 1]; None leaves the place empty.
    - `caption`: lines; one that is too long for the picture's width is cut and ends in an ellipsis.
    """

    picture: NDArray[np.floating] | None
    caption: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class Row:
    """Pictures side by side; `label`: lines that stand to the left of them; `heading`: a line above them."""

    label: tuple[str, ...]
    tiles: tuple[Tile, ...]
    heading: str = ""


def contact_sheet(title: str, rows: Sequence[Row], size: int) -> Image.Image:
    """Lays out rows below each other.

    **Arguments:**

    - `title`: one line above all.
    - `rows`: at least one; their numbers of tiles may differ.
    - `size`: of a tile's picture in pixels.
    """
    label_width = max((_width(line, _LABEL_SIZE) for row in rows for line in row.label), default=0)
    left = _GAP + (label_width + 2 * _GAP if label_width else 0)
    top = _GAP + round(_LEADING * _TITLE_SIZE) + _GAP
    text_width = max(_width(title, _TITLE_SIZE), *(_width(row.heading, _LABEL_SIZE) for row in rows))
    width = max(left + max(len(row.tiles) for row in rows) * (size + _GAP), text_width + 2 * _GAP)
    sheet = Image.new("RGB", (width, top + sum(_height(row, size) for row in rows)), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_GAP, _GAP), title, _INK, _font(_TITLE_SIZE))
    for row in rows:
        if row.heading:
            draw.text((_GAP, top), row.heading, _INK, _font(_LABEL_SIZE))
            top += _HEADING
        _write(draw, row.label, (_GAP, top + size // 2 - len(row.label) * _LABEL_SIZE // 2), _LABEL_SIZE, label_width)
        for number, tile in enumerate(row.tiles):
            x = left + number * (size + _GAP)
            if tile.picture is not None:
                pixels = np.round(255 * np.clip(tile.picture, 0, 1)).astype(np.uint8)
                sheet.paste(Image.fromarray(pixels), (x, top))
            _write(draw, tile.caption, (x, top + size + 2), _CAPTION_SIZE, size)
        top += _height(row, size) - (_HEADING if row.heading else 0)
    return sheet


def _height(row: Row, size: int) -> int:
    lines = max((len(tile.caption) for tile in row.tiles), default=0)
    return (_HEADING if row.heading else 0) + size + round(lines * _LEADING * _CAPTION_SIZE) + 2 * _GAP


def _write(draw: ImageDraw.ImageDraw, lines: tuple[str, ...], place: tuple[int, int], size: int, width: int) -> None:
    for number, line in enumerate(lines):
        colour = _FAINT if number else _INK
        y = place[1] + round(number * _LEADING * size)
        draw.text((place[0], y), _cut(line, size, width), colour, _font(size))


def _cut(line: str, size: int, width: int) -> str:
    """A line that is no wider than that many pixels."""
    if _width(line, size) <= width:
        return line
    while line and _width(line + "…", size) > width:
        line = line[:-1]
    return line + "…"


def _width(line: str, size: int) -> int:
    return int(np.ceil(_font(size).getlength(line)))


def _font(size: int) -> ImageFont.FreeTypeFont:
    # Pillow brings no font of every size; Matplotlib does.
    return ImageFont.truetype(pathlib.Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size)
