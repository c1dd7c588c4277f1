"""`report.html` of a benchmark: how often the answers are right, and what was answered instead."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.document import Chapter, Text, write_document
from dr_lab.html.figure import AFTER, BEFORE, INK, NOISE, Plot, chart, rows_height
from dr_lab.recorders.confusion import Confusion
from dr_lab.reports.benchmark import BenchmarkReport
from dr_lab.reports.page import Page

_CELL = 26  # px
_FAINTEST = 0.35  # opacity of a cell that holds few of its row's cases


def write_benchmark_page(
    path: Path, page: Page, report: BenchmarkReport, said: Mapping[str, str], matrix: Confusion
) -> None:
    """Write the page, atomically: what `report.md` says, with plots.

    Args:
        path: the file, by custom ``report.html``.
        page: what is said.
        report: what all cases come to.
        said: what each rate is called.
        matrix: what was answered, by what is hidden.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    plots = {"figures": rate_plots(report, said), "confusion": confusion_plots(matrix)}
    chapters = []
    for section in page.sections:
        text = [Text(section.body)] if section.key != "confusion" else []
        chapters.append(Chapter(section.title, [*plots.get(section.key, []), *text]))
    write_document(path, page.title, page.lead, chapters)


def rate_plots(report: BenchmarkReport, said: Mapping[str, str]) -> list[Plot]:
    """Shares with Wilson's interval, blue where the goal is met and orange where it is missed."""
    known = [(name, rate) for name in said if (rate := report.rates.get(name)) is not None]
    if not known:
        return []
    figure = chart()
    for name, rate in known:
        goal = report.goals.get(name)
        colour = NOISE if goal is None or goal.met is None else AFTER if goal.met else BEFORE
        ends = {"array": [100 * (rate.high - rate.share)], "arrayminus": [100 * (rate.share - rate.low)]}
        error = {"type": "data", "symmetric": False, "thickness": 3, "width": 6, **ends}
        text = f"{rate.count} of {rate.of}" + ("" if goal is None else f", goal {goal.goal}")
        look = {"mode": "markers", "marker": {"color": colour, "size": 11}, "showlegend": False}
        figure.add_trace(go.Scatter(x=[100 * rate.share], y=[said[name]], error_x=error, text=[text], **look))
    figure.update_xaxes(title="share of the cases [%]", range=[-2.0, 102.0])
    figure.update_yaxes(autorange="reversed")
    caption = "Lines: 95 % intervals. Blue: the goal is met, orange: missed, grey: none is set."
    return [Plot(figure, rows_height(len(known)), caption)]


def confusion_plots(matrix: Confusion) -> list[Plot]:
    """Cases by what is hidden and what was answered; blue was judged right, orange wrong."""
    if not matrix.count.size:
        return []
    share = matrix.count / np.maximum(matrix.count.sum(1, keepdims=True), 1)
    strength = np.where(matrix.count > 0, _FAINTEST + (1.0 - _FAINTEST) * share, 0.0)
    right = matrix.right / np.maximum(matrix.count, 1)
    signed = np.where(matrix.count > 0, np.where(right >= 0.5, strength, -strength), np.nan)
    colours = [[0.0, BEFORE], [0.5, "var(--page)"], [1.0, AFTER]]
    text = np.where(matrix.count > 0, matrix.count.astype(str), "")
    figure = chart()
    figure.add_trace(
        go.Heatmap(
            x=matrix.answers, y=matrix.truths, z=signed, zmin=-1.0, zmax=1.0, colorscale=colours, showscale=False,
            text=text, texttemplate="%{text}", textfont={"color": INK}, customdata=matrix.right, xgap=1, ygap=1,
            hovertemplate="hidden %{y}, answered %{x}: %{text} cases, %{customdata} judged right<extra></extra>",
        )
    )  # fmt: skip
    figure.update_xaxes(title="answered", side="top", tickangle=-60, showgrid=False)
    figure.update_yaxes(title="hidden", autorange="reversed", showgrid=False)
    caption = "Blue: most of the cell's cases were judged right, orange: wrong; strength: share of the row."
    return [Plot(figure, 240 + _CELL * len(matrix.truths), caption)]
