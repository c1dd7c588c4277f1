"""`report.html` of compare, fit, diagnose, add and close."""

from collections.abc import Sequence
from pathlib import Path

from dr_lab.html.channel_figures import channel_plots
from dr_lab.html.document import Chapter, Fold, Part, Text, write_document
from dr_lab.html.experiment_figures import experiment_plots
from dr_lab.html.force_figures import force_plots
from dr_lab.html.ladder_figures import horizon_plots, ladder_plots
from dr_lab.html.parameter_figures import parameter_plots
from dr_lab.html.ranking_figures import ranking_parts
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import gap_page

_POINTS = 90_000  # of all curves against time together: about 1.5 MB
_LEAST = 300  # of one of them, less shows no shape
_MOST = 2400  # of one of them, more than a screen has pixels
_CURVES = 8  # of a channel, about


def write_gap_page(path: Path, report: GapReport, overlays: Sequence[Overlay], look: Look) -> None:
    """Write the page, atomically: what `report.md` says, with plots.

    Args:
        path: the file, by custom ``report.html``.
        report: what was found.
        overlays: the scored logs; the first is shown, the others are folded.
        look: how many dots a scatter plot has.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    page, plots = gap_page(report), _plots(report, overlays, look)
    plots["next_experiment"] = experiment_plots(path.parent, report.judged.next_experiment)
    bodies = {section.key: [Text(section.body)] if section.body else [] for section in page.sections}
    bodies["candidates"] = []  # which are told rung by rung
    chapters = [Chapter(s.title, [*plots.get(s.key, ()), *bodies[s.key]]) for s in page.sections]
    write_document(path, page.title, page.lead, chapters)


def _plots(report: GapReport, overlays: Sequence[Overlay], look: Look) -> dict[str, Sequence[Part]]:
    """By the section that they belong to."""
    return {
        "ladder": ladder_plots(report),
        "channels": _signals(overlays),
        "candidates": ranking_parts(report),
        "parameters": parameter_plots(report),
        "missing_forces": _by_log(overlays, [force_plots(overlay, look) for overlay in overlays]),
        "horizons": horizon_plots(report),
    }


def _signals(overlays: Sequence[Overlay]) -> list[Part]:
    """As many logs as the page has room for; that points are left out, and which logs."""
    channels = max((len(overlay.measured) for overlay in overlays), default=1)
    shown = overlays[: max(1, _POINTS // (_LEAST * _CURVES * channels))]
    points = min(_MOST, max(_LEAST, _POINTS // (_CURVES * channels * max(len(shown), 1))))
    parts = _by_log(shown, [channel_plots(overlay, points) for overlay in shown])
    others = ", ".join(overlay.log for overlay in overlays[len(shown) :])
    left = f" It also holds {others}." if others else ""
    told = f"Curves are thinned to about {points} points, the extremes of every stretch; review.rrd holds all.{left}"
    return [*parts, Text(told)] if parts else []


def _by_log(overlays: Sequence[Overlay], plots: Sequence[Sequence[Part]]) -> list[Part]:
    """The first log's plots, and those of the others behind its name."""
    found = [(overlay.log, each) for overlay, each in zip(overlays, plots, strict=True) if each]
    if len(found) < 2:
        return [part for _, each in found for part in each]
    (first, shown), *others = found
    return [Text(f"### {first}"), *shown, *(Fold(log, each) for log, each in others)]
