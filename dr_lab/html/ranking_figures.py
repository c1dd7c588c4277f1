"""Every ranking of a report, rung by rung: what each effect removes, best first."""

from collections.abc import Mapping, Sequence

import plotly.graph_objects as go

from dr_lab.html.document import Fold, Part, Text
from dr_lab.html.figure import AFTER, BEFORE, INK, NOISE, Plot, chart, rows_height
from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import CandidateEntry
from dr_lab.reports.ladder import scored, status
from dr_lab.reports.quantity import number
from dr_lab.reports.rankings import rankings
from dr_lab.reports.tables import intervals_of, promise_table, ranking_table

_MOST = 20  # rows of a plot; all candidates are in the table
_WORTH = 0.01  # share that a candidate promises, from which on it is drawn although it was not fitted
_WORST = -25.0  # %; what does far worse than the plain model is merely rejected, and left to the table
_COLOURS = {"named": AFTER, "equivalent": BEFORE}
_SYMBOLS = {"absorbed": "square", "not excited": "x"}  # which are as grey as what is rejected


def ranking_parts(report: GapReport) -> list[Part]:
    """A plot and a table a rung; the first rung is open, since it says what the calibrated model lacks."""
    parts: list[Part] = []
    for index, ranking in enumerate(rankings(report)):
        if not ranking.rows:
            continue
        inside = [*_plot(ranking.rows, report), _tables(ranking.rows, report)]
        parts += [Fold(ranking.title, inside)] if index else [Text(f"### {ranking.title}"), *inside]
    return parts


def _tables(ordered: Sequence[CandidateEntry], report: GapReport) -> Fold:
    """All candidates. Most were not fitted, and there is little to say of them: two of these stand side by side."""
    fitted, others = ([row for row in ordered if row.fitted is each] for each in (True, False))
    first, middle, verdict = len(fitted) + 1, -(-len(others) // 2), report.verdict
    halves = [promise_table(others[:middle], verdict, first), promise_table(others[middle:], verdict, first + middle)]
    texts = [
        Text(ranking_table(fitted, verdict, report.judged.confidence)),
        *(Text(half, half=True) for half in halves),
    ]
    return Fold(f"All {len(ordered)} candidates", [text for text in texts if text.markdown])


def _plot(ordered: Sequence[CandidateEntry], report: GapReport) -> list[Plot]:
    fitted = [row for row in ordered if row.fitted and row.gain is not None and 100 * row.gain >= _WORST][:_MOST]
    promised = [row for row in ordered if not row.fitted and (row.predicted_gain or 0.0) >= _WORTH]
    shown = [*fitted, *promised[: max(0, _MOST - len(fitted))]]
    if not shown:
        return []
    figure = chart()
    told = {row.label: status(row, report.verdict) for row in fitted}
    for word in dict.fromkeys(told.values()):
        figure.add_trace(_removed([row for row in fitted if told[row.label] == word], word))
    if len(shown) > len(fitted):
        figure.add_trace(_promised(shown[len(fitted) :]))
    figure.add_vline(x=0.0, line={"color": INK, "width": 1})
    low = min([0.0, *(100 * row.gain_ci[0] for row in fitted if row.gain_ci[0] is not None)])
    figure.update_xaxes(title="share of a typical window's χ² removed [%]", range=[max(low, _WORST) - 2.0, 102.0])
    names = [row.label for row in shown]
    figure.update_yaxes(categoryorder="array", categoryarray=names[::-1], range=[-0.7, len(shown) - 0.3])
    left = len(ordered) - len(shown)
    caption = f"On {scored(report)}; lines are {intervals_of(report.judged.confidence)}s."
    caption += f" The table has {left} more." if left else ""
    return [Plot(figure, rows_height(len(shown)), caption)]


def _removed(rows: Sequence[CandidateEntry], word: str) -> go.Scatter:
    gains = [100 * (row.gain or 0.0) for row in rows]
    ends = [tuple(100 * (end if end is not None else row.gain or 0.0) for end in row.gain_ci) for row in rows]
    error: Mapping[str, object] = {
        "type": "data",
        "symmetric": False,
        "array": [max(high - gain, 0.0) for gain, (_, high) in zip(gains, ends, strict=True)],
        "arrayminus": [max(gain - low, 0.0) for gain, (low, _) in zip(gains, ends, strict=True)],
        "thickness": 2,
    }
    said = [f"χ² {number(row.held_out_chi2)}" if row.final else "tried on few windows" for row in rows]
    marker = {"color": _COLOURS.get(word, NOISE), "symbol": _SYMBOLS.get(word, "circle"), "size": 10}
    labels = [row.label for row in rows]
    return go.Scatter(x=gains, y=labels, error_x=error, text=said, name=word, mode="markers", marker=marker)


def _promised(rows: Sequence[CandidateEntry]) -> go.Scatter:
    """Of what was not fitted there is no gain, only what a linear step foretells."""
    marker = {"color": NOISE, "size": 9, "symbol": "diamond-open"}
    x, y = [100 * (row.predicted_gain or 0.0) for row in rows], [row.label for row in rows]
    return go.Scatter(x=x, y=y, name="not fitted: what it promised", mode="markers", marker=marker)
