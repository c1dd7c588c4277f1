"""`review.rrd` of a training run or an evaluation: curves, learned distribution, returns, episodes, report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders import comparisons, course, distributions, grids, heat_map, spread, violins, ways
from dr_lab.recorders.branch import FRAMES, ITERATIONS, TIMELINE, Branch
from dr_lab.recorders.counted_axis import counted_axis
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.episodes import ROOT, anything_drawn, episodes_page, log_episodes
from dr_lab.recorders.gains import log_gain
from dr_lab.recorders.look import Look
from dr_lab.recorders.matrices import log_matrix
from dr_lab.recorders.numbered_axis import numbered_axis
from dr_lab.recorders.recording import recording_file
from dr_lab.recorders.sheet import sheet, sheet_rows
from dr_lab.recorders.title_numbers import first_last
from dr_lab.recorders.training import (
    Comparisons,
    Curve,
    Decline,
    Gain,
    Grid,
    Marginal,
    Matrix,
    Pair,
    Sample,
    Spread,
    Ways,
)
from dr_lab.reports.quantity import titled

# Rerun keeps one layout an application: every recording of training and evaluation shares this one.
APPLICATION = "dr_lab_train"


@dataclass(frozen=True)
class TrainingRecord:
    """What a recording of training holds; what is empty gets no page.

    Attributes:
        name: of the recording.
        curves: figures as training goes on, those of the first page first; one plot a unit and name.
        marginals: one parameter's distribution each.
        pairs: two parameters' ellipses each.
        grids: returns over contexts.
        pages: Markdown by title; the first stands on the first page.
        episodes: of the trained policy.
        matrices: cosines between the gradients of contexts, that of the first page first.
        gains: what updates add to the return over contexts, that of the first page first.
        ways: in the plane, before and after updates.
        samples: returns whose scatter is looked at, as violins in one chart.
        spreads: one parameter's mean and standard deviation each.
        comparisons: one quantity of target and model each.
        declines: figures that fall by orders of magnitude.
    """

    name: str
    curves: Sequence[Curve] = ()
    marginals: Sequence[Marginal] = ()
    pairs: Sequence[Pair] = ()
    grids: Sequence[Grid] = ()
    pages: Mapping[str, str] = field(default_factory=dict)
    episodes: Sequence[Episode] = ()
    matrices: Sequence[Matrix] = ()
    gains: Sequence[Gain] = ()
    ways: Sequence[Ways] = ()
    samples: Sequence[Sample] = ()
    spreads: Sequence[Spread] = ()
    comparisons: Sequence[Comparisons] = ()
    declines: Sequence[Decline] = ()

    @property
    def courses(self) -> Sequence[Marginal | Spread]:
        """What shows how each parameter's distribution changed: mean and bands where known, else the density."""
        return [each for each in self.spreads or self.marginals if len(each.iteration) > 1]


def write_training_review(path: Path, record: TrainingRecord, look: Look) -> None:
    """Write the recording with its layout, atomically.

    Entities: ``/curve/<name>``, ``/distribution/<parameter>``, ``/distribution/<parameter>, <parameter>``,
    ``/course/<parameter>``, ``/comparison/<quantity>``, ``/decline/<name>``, ``/grid/<title>``, ``/matrix/<title>``,
    ``/gain/<title>``, ``/ways/<title>``, ``/violins``, ``/pages/<title>`` on the timeline ``iteration``, curves over
    control steps on ``frames``,
    ``/episode/<name>/{world,reward,action}`` on ``t``, the time since the episode's start.

    Args:
        path: the file, by custom ``review.rrd``.
        record: what it shows.
        look: colours and line widths.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with recording_file(path, APPLICATION, record.name, _blueprint(record, look)) as root:
        _log(root, record, look)


def _log(root: Branch, record: TrainingRecord, look: Look) -> None:
    for curve in record.curves:
        _log_curve(root / "curve" / curve.name, curve, look)
    _log_learned(root, record, look)
    span = grids.return_span(record.grids)
    for grid in record.grids:
        grids.log_grid(root / "grid" / grid.title, grid, look, span)
    for matrix in record.matrices:
        log_matrix(root / "matrix" / matrix.title, matrix, look)
    for gain in record.gains:
        log_gain(root / "gain" / gain.title, gain, look)
    for each in record.ways:
        ways.log_ways(root / "ways" / each.title, each, look)
    if record.samples:
        violins.log_violins(root / violins.ROOT, record.samples, [look.colour("after")] * len(record.samples), look)
    if record.episodes:
        log_episodes(root / ROOT, record.episodes, look, _counting(record))
    for title, text in record.pages.items():
        (root / "pages" / title).static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def _log_curve(place: Branch, curve: Curve, look: Look) -> None:
    """A line; of one point alone a dot, because a line would show nothing."""
    colours, names = [look.colour("after")], [titled(curve.name, curve.unit)]
    if np.isfinite(curve.value).sum() == 1:
        place.static(rr.SeriesPoints(colors=colours, names=names, marker_sizes=[2 * look.measured_width]))
    else:
        place.static(rr.SeriesLines(colors=colours, names=names, widths=[look.line_width]))
    place.over(curve.over, curve.at, rr.Scalars.columns(scalars=curve.value))


def _log_learned(root: Branch, record: TrainingRecord, look: Look) -> None:
    for marginal in record.marginals:
        distributions.log_marginal(root / "distribution" / marginal.name, marginal, look)
    for each in record.courses:
        place = root / "course" / each.name
        spread.log_spread(place, each, look) if isinstance(each, Spread) else course.log_course(place, each, look)
    for each in record.comparisons:
        comparisons.log_comparisons(root / "comparison" / each.shown[0].name, each, look)
    for decline in record.declines:
        comparisons.log_decline(root / "decline" / decline.name, decline, look)
    for pair in record.pairs:
        distributions.log_pair(root / "distribution" / _joined(pair), pair, look)


def _blueprint(record: TrainingRecord, look: Look) -> rrb.Blueprint:
    text = [rrb.TextDocumentView(origin=rr.new_entity_path(["pages", title]), name=title) for title in record.pages]
    # A view stands in one place only: the overview has its own, and a page of it alone would say the same again.
    pictures = next((find for find in (_learned, _adapted, _maps, _matrices) if find(record)), _maps)
    first = [find(record) for find in (_curves, pictures)]
    columns = [[*text[:1], *first[0][:1]], first[1][:1]]
    alone = {views[0].name for views in first if len(views) == 1}
    overview = rrb.Horizontal(*(rrb.Vertical(*views) for views in columns if views), name="Overview")
    sheets = {
        "Curves": _curves(record),
        "Learned distribution" if record.courses else "Contexts of training": _learned(record),
        "Pairs of parameters": _pairs(record),
        "Target and model": _compared(record),
        "Mean returns": _maps(record),
        "Gradients of contexts": _matrices(record),
        "Adaptation": _adapted(record),
    }
    pages: list[rrb.Container | rrb.View] = [
        *([overview] if any(columns) else []),
        *(sheet(name, views) for name, views in sheets.items() if {view.name for view in views} - alone),
        *([episodes_page(record.episodes, look, _counting(record))] if record.episodes else []),
        *text[1:],
    ]
    return rrb.Blueprint(
        rrb.Tabs(*pages, name="Review"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        _time(record),
    )


def _time(record: TrainingRecord) -> rrb.TimePanel:
    """The slider over what training counts, where anything changes with it, else over the time of episodes."""
    counting = _counting(record)
    if counting is not None:
        return rrb.TimePanel(state="collapsed", timeline=counting, play_state="following")
    if anything_drawn(record.episodes):
        return rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing", loop_mode="all")
    return rrb.TimePanel(state="hidden")


def _counting(record: TrainingRecord) -> str | None:
    """The timeline of what changes while training goes on; None where nothing does."""
    if record.marginals or record.pairs or any(curve.over == ITERATIONS for curve in record.curves):
        return ITERATIONS
    return FRAMES if record.curves else None


def _curves(record: TrainingRecord) -> list[rrb.View]:
    return [_plot(curve, sheet_rows(len(record.curves)), _where(record, curve)) for curve in record.curves]


def _where(record: TrainingRecord, curve: Curve) -> str:
    """The timeline to be chosen for a curve, where there is another one: on that of episodes its plot is empty."""
    return f" (timeline {curve.over})" if anything_drawn(record.episodes) else ""


def _learned(record: TrainingRecord) -> list[rrb.View]:
    names = [marginal.name for marginal in record.marginals]
    present = [distributions.CANVAS.view(["distribution", name], f"p(z) of {name}") for name in names]
    changed = [each.name for each in record.courses]
    return [*present, *(grids.CANVAS.view(["course", name], f"p(z) of {name} over iterations") for name in changed)]


def _pairs(record: TrainingRecord) -> list[rrb.View]:
    names = [_joined(pair) for pair in record.pairs]
    return [distributions.CANVAS.view(["distribution", name], f"p(z) of {name}") for name in names]


def _compared(record: TrainingRecord) -> list[rrb.View]:
    names = [each.shown[0].name for each in record.comparisons]
    moved = [comparisons.CANVAS.view(["comparison", name], f"{name} of target and model") for name in names]
    fallen = [comparisons.CANVAS.view(["decline", d.name], f"{d.name} over iterations") for d in record.declines]
    return [*moved, *fallen]


def _maps(record: TrainingRecord) -> list[rrb.View]:
    maps = [
        grids.CANVAS.view(["grid", grid.title], f"returns, {grid.title}{grids.told([grid])}") for grid in record.grids
    ]
    return [*violins.views(record.samples), *maps]


def _adapted(record: TrainingRecord) -> list[rrb.View]:
    gained = [heat_map.CANVAS.view(["gain", each.title], f"gain {each.title}") for each in record.gains]
    return [*gained, *(ways.CANVAS.view(["ways", each.title], f"ways, {each.title}") for each in record.ways)]


def _matrices(record: TrainingRecord) -> list[rrb.View]:
    return [heat_map.CANVAS.view(["matrix", each.title], each.title) for each in record.matrices]


def _plot(curve: Curve, rows: int, where: str) -> rrb.TimeSeriesView:
    origin = rr.new_entity_path(["curve", curve.name])
    return rrb.TimeSeriesView(
        origin=origin,
        name=f"{titled(curve.name.replace('_', ' '), curve.unit)}{first_last(curve.value)}{where}",
        axis_x=counted_axis(0, int(curve.at[-1])),
        axis_y=numbered_axis([curve.value], rows),
        plot_legend=rrb.PlotLegend(visible=False),
    )


def _joined(pair: Pair) -> str:
    return ", ".join(pair.names)
