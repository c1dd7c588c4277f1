"""Labelled rows with a bar, a dot and an interval each: the ranking of effects and the ladder of models."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import LINES, Axis, Canvas, Chart, decade_axis, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import SIMULATED
from dr_lab.recorders.shape import Colour
from dr_lab.reports.gap_entries import CandidateEntry
from dr_lab.reports.ladder import LadderModel, status
from dr_lab.reports.quantity import number
from dr_lab.reports.rankings import by_gain

# Canvas units a row: a line of text above its bar, whose place is given as a share of the row from below.
_ROW = 18.0
_BAR = 0.25
# Rows that fill the ranking's view: fewer leave room below rather than drift apart, more are left to the table.
_RANKED = 10
_MOST = 14
# Losses are shown down to here, per cent; a candidate that does far worse than the plain model is merely rejected.
_WORST = -25.0


@dataclass(frozen=True)
class _Row:
    """One row: its label, its value on the axis, an interval or None, and its colour."""

    label: str
    value: float
    interval: tuple[float, float] | None
    colour: Colour


def ranking_canvas(ranking: Sequence[CandidateEntry]) -> Canvas:
    """Measures of the chart that `log_ranking` draws."""
    return _canvas(len(_drawn(ranking)), _RANKED)


def ladder_canvas(ladder: Sequence[LadderModel]) -> Canvas:
    """Measures of the chart that `log_ladder` draws."""
    return _canvas(len(ladder), 0)


def log_ranking(root: Branch, ranking: Sequence[CandidateEntry], verdict: str | None, look: Look) -> None:
    """Draw the best fitted candidates: the share of a typical window's χ² that each removes, with its interval.

    Args:
        root: where to.
        ranking: the candidates.
        verdict: of the whole report; where it names none, no candidate has the colour of what is named.
        look: colours.
    """
    colours = {"named": "after", "equivalent": "before"}
    rows = [
        _Row(
            _said(row),
            _as_percent(row.gain),
            None if None in row.gain_ci else (_as_percent(row.gain_ci[0]), _as_percent(row.gain_ci[1])),
            look.colour(colours.get(status(row, verdict), "noise")),
        )
        for row in _drawn(ranking)
    ]
    low = min([0.0, *(row.interval[0] for row in rows if row.interval)])
    axis = linear_axis("share of a typical window's χ² that the effect removes [%]", max(low, _WORST), 100.0)
    _log_rows(root, ranking_canvas(ranking), rows, axis, 0.0, look)


def log_ladder(root: Branch, ladder: Sequence[LadderModel], pair: Sequence[LadderModel], look: Look) -> None:
    """Draw the models from first to last: χ² on a logarithmic axis that starts at the noise floor, 1.

    Args:
        root: where to.
        ladder: the models.
        pair: the two that the rest of the recording shows, which have the same colours here.
        look: colours.
    """
    colours = {step.name: role for step, role in zip(pair, SIMULATED, strict=False)}
    chi2 = [step.held_out.chi2 for step in ladder]
    known = [value for value in chi2 if value]
    axis = decade_axis("χ² (1 = noise floor)", min([1.0, *known]), max([10.0, *known]) * 1.2)
    rows = [
        _Row(
            f"{step.name} · χ² {number(value)}",
            float(np.log10(value)) if value else axis.high,
            None,
            look.colour(colours.get(step.name, "noise")),
        )
        for step, value in zip(ladder, chi2, strict=True)
    ]
    _log_rows(root, ladder_canvas(ladder), rows, axis, axis.low, look)


def _drawn(ranking: Sequence[CandidateEntry]) -> list[CandidateEntry]:
    """Of what was not fitted no gain is known; the table says what it promised."""
    return [row for row in by_gain(ranking) if row.fitted][:_MOST]


def _said(row: CandidateEntry) -> str:
    """Its name and, where all windows were fitted, its χ²; the others were left after few."""
    return row.label if row.held_out_chi2 is None else f"{row.label} · χ² {number(row.held_out_chi2)}"


def _canvas(rows: int, room: int) -> Canvas:
    """Measures of a chart of so many rows, with room for at least `room` of them."""
    height, least = _ROW * max(rows, 1), _ROW * room
    spare = max(0.0, least - height)
    return Canvas(max(100.0, height, least), height, left=8.0, right=8.0, top=4.0, bottom=16.0 + spare)


def _log_rows(root: Branch, canvas: Canvas, rows: Sequence[_Row], x: Axis, start: float, look: Look) -> None:
    chart = Chart(root, canvas, x, Axis("", 0.0, float(max(len(rows), 1)), []))
    chart.frame(look.colour("axis"), look.colour("text"))
    for index, row in enumerate(rows):
        name, bottom = f"row_{index:02}", float(len(rows) - 1 - index)
        height = bottom + _BAR
        chart.line(f"{name}_bar", [start, row.value], [height] * 2, row.colour, 3.0)
        chart.dots(f"{name}_dot", [row.value], [height], row.colour, 6.0)
        if row.interval:
            # Above the bar, which would hide its lower half.
            chart.line(f"{name}_interval", row.interval, [height] * 2, look.colour("measured"), 1.0, layer=LINES + 1.0)
        above = chart.place((x.low + x.high) / 2, bottom + 1.0)[0]
        chart.words(f"{name}_label", [(above, row.label)], look.colour("text"), lift=0.0)


def _as_percent(share: float | None) -> float:
    """Per cent of a share; 0 where it is unknown, so that the row is drawn with its label and no bar."""
    return 100 * share if share is not None and np.isfinite(share) else 0.0
