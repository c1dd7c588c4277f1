"""A confusion matrix: what was hidden against what was answered, as numbers and as a picture."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from dr_lab.files import atomic
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour

Picture = NDArray[np.uint8]

# Pixels: side of a cell, size of the letters, distance between parts.
_CELL, _LETTER, _GAP = 32, 17, 10
# A cell that holds few of its row's cases is still told from an empty one.
_FAINTEST = 0.3


@dataclass(frozen=True)
class Confusion:
    """How often each truth got each answer.

    Attributes:
        truths: labels of the rows.
        answers: labels of the columns.
        count: cases, shape (rows, columns).
        right: those of them that were judged right, shape (rows, columns).
    """

    truths: tuple[str, ...]
    answers: tuple[str, ...]
    count: NDArray[np.intp]
    right: NDArray[np.intp]


def confusion(pairs: Sequence[tuple[str, str, bool]], order: Sequence[str]) -> Confusion:
    """Count pairs of truth and answer.

    Args:
        pairs: truth, answer and whether it was judged right, one a case.
        order: labels in the order of rows and columns; others follow in alphabetical order.
    """

    def labels(column: int) -> tuple[str, ...]:
        found = {pair[column] for pair in pairs if isinstance(pair[column], str)}
        known = [label for label in order if label in found]
        return (*known, *sorted(str(label) for label in found - set(known)))

    truths, answers = labels(0), labels(1)
    count, right = (np.zeros((len(truths), len(answers)), dtype=np.intp) for _ in range(2))
    for truth, answer, good in pairs:
        place = truths.index(truth), answers.index(answer)
        count[place] += 1
        right[place] += good
    return Confusion(truths, answers, count, right)


def confusion_csv(matrix: Confusion) -> str:
    """One row a pair that occurred: ``truth``, ``answer``, ``cases``, ``right``."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["truth", "answer", "cases", "right"])
    for row, column in np.argwhere(matrix.count):
        numbers = matrix.count[row, column], matrix.right[row, column]
        writer.writerow([matrix.truths[row], matrix.answers[column], *map(int, numbers)])
    return text.getvalue()


def confusion_picture(matrix: Confusion, look: Look) -> Picture:
    """Draw the matrix: a cell's colour says right or wrong, its strength the share of its row, its number the cases.

    Args:
        matrix: what to draw.
        look: ``after`` colours right answers, ``before`` wrong ones.

    Returns:
        Red, green and blue, shape (height, width, 3).
    """
    font = ImageFont.load_default(_LETTER)
    left, top = (_longest(labels, font) + 2 * _GAP for labels in (matrix.truths, matrix.answers))
    top += _LETTER + _GAP
    rows, columns = matrix.count.shape
    foot = 2 * (_LETTER + _GAP)
    size = (max(left + columns * _CELL, left + _longest(_legend(), font)) + 2 * _GAP, top + rows * _CELL + foot)
    image = Image.new("RGB", size, _rgb(look.colour("ground")))
    draw = ImageDraw.Draw(image)
    text, axis = _rgb(look.colour("text")), _rgb(look.colour("axis"))
    for row in range(rows):
        for column in range(columns):
            corner = left + column * _CELL, top + row * _CELL
            _cell(draw, corner, matrix, (row, column), look, font)
    for row, label in enumerate(matrix.truths):
        draw.text((left - _GAP, top + (row + 0.5) * _CELL), label, fill=text, font=font, anchor="rm")
    for column, label in enumerate(matrix.answers):
        upright = _upright(label, font, text, _rgb(look.colour("ground")))
        image.paste(upright, (round(left + (column + 0.5) * _CELL - upright.width / 2), top - _GAP - upright.height))
    draw.text((left - _GAP, top - _GAP), "hidden", fill=axis, font=font, anchor="rb")
    draw.text((left, _GAP), "answered", fill=axis, font=font, anchor="lt")
    for line, label in enumerate(_legend()):
        role = ("after", "before")[line]
        draw.text(
            (left, size[1] - foot + line * (_LETTER + _GAP / 2) + _GAP), label, fill=_rgb(look.colour(role)), font=font
        )
    return np.asarray(image)


def write_picture(path: Path, picture: Picture) -> None:
    """Write a picture as PNG, atomically.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with atomic(path) as temporary:
        Image.fromarray(picture).save(temporary)


def _legend() -> tuple[str, str]:
    return "blue: judged right (strength: share of the row)", "orange: judged wrong"


def _cell(
    draw: ImageDraw.ImageDraw,
    corner: tuple[int, int],
    matrix: Confusion,
    place: tuple[int, int],
    look: Look,
    font: ImageFont.FreeTypeFont | ImageFont.ImageFont,
) -> None:
    """A square whose lower part is as wrong as its cases are, with their number."""
    (x, y), count, right = corner, int(matrix.count[place]), int(matrix.right[place])
    ground, grid = look.colour("ground"), _rgb(look.colour("fixed"))
    box = (x, y, x + _CELL - 1, y + _CELL - 1)
    if count:
        strength = _FAINTEST + (1 - _FAINTEST) * count / int(matrix.count[place[0]].sum())
        split = y + round(_CELL * right / count)
        draw.rectangle(box, fill=_mixed(ground, look.colour("before"), strength))
        if split > y:
            draw.rectangle((x, y, x + _CELL - 1, split - 1), fill=_mixed(ground, look.colour("after"), strength))
        middle = x + _CELL / 2, y + _CELL / 2
        draw.text(middle, str(count), "white", font, anchor="mm", stroke_width=2, stroke_fill="black")
    draw.rectangle(box, outline=grid)


def _upright(
    label: str,
    font: ImageFont.FreeTypeFont | ImageFont.ImageFont,
    colour: tuple[int, int, int],
    ground: tuple[int, int, int],
) -> Image.Image:
    """A label that reads from below upwards."""
    strip = Image.new("RGB", (_longest([label], font) + 2, _CELL - 4), ground)
    ImageDraw.Draw(strip).text((0, strip.height / 2), label, fill=colour, font=font, anchor="lm")
    return strip.transpose(Image.Transpose.ROTATE_90)


def _longest(labels: Sequence[str], font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> int:
    return max((int(np.ceil(font.getlength(label))) for label in labels), default=0)


def _mixed(ground: Colour, colour: Colour, strength: float) -> tuple[int, int, int]:
    red, green, blue = (round(g + strength * (c - g)) for g, c in zip(ground[:3], colour[:3], strict=True))
    return red, green, blue


def _rgb(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = colour[:3]
    return red, green, blue
