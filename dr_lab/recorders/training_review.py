"""`review.rrd` of a training run or an evaluation: curves, learned distribution, returns, episodes, report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders import course, distributions, grids, heat_map, violins, ways
from dr_lab.recorders.branch import FRAMES, ITERATIONS, TIMELINE, Branch
from dr_lab.recorders.counted_axis import counted_axis
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.episodes import ROOT, episodes_page, log_episodes, log_starts
from dr_lab.recorders.gains import log_gain
from dr_lab.recorders.look import Look
from dr_lab.recorders.matrices import log_matrix
from dr_lab.recorders.recording import recording_file
from dr_lab.recorders.training import Curve, Gain, Grid, Marginal, Matrix, Pair, Sample, Ways
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


def write_training_review(path: Path, record: TrainingRecord, look: Look) -> None:
    """Write the recording with its layout, atomically.

    Entities: ``/curve/<name>``, ``/distribution/<parameter>``, ``/distribution/<parameter>, <parameter>``,
    ``/course/<parameter>``, ``/grid/<title>``, ``/matrix/<title>``, ``/gain/<title>``, ``/ways/<title>``,
    ``/violins``, ``/pages/<title>`` on the timeline ``iteration``, curves over control steps on ``frames``,
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
        place = root / "curve" / curve.name
        place.static(
            rr.SeriesLines(
                colors=[look.colour("after")], names=[titled(curve.name, curve.unit)], widths=[look.line_width]
            )
        )
        place.over(curve.over, curve.at, rr.Scalars.columns(scalars=curve.value))
    for marginal in record.marginals:
        distributions.log_marginal(root / "distribution" / marginal.name, marginal, look)
        course.log_course(root / "course" / marginal.name, marginal, look)
    for pair in record.pairs:
        distributions.log_pair(root / "distribution" / _joined(pair), pair, look)
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
        log_episodes(root / ROOT, record.episodes, look)
    counting = _counting(record)
    if counting is not None:
        log_starts(root / ROOT, record.episodes, look, counting)
    for title, text in record.pages.items():
        (root / "pages" / title).static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def _blueprint(record: TrainingRecord, look: Look) -> rrb.Blueprint:
    text = [rrb.TextDocumentView(origin=rr.new_entity_path(["pages", title]), name=title) for title in record.pages]
    # A view stands in one place only: the overview has its own.
    shown = _learned(record) or _adapted(record) or _maps(record) or _matrices(record)
    plots = [*_curves(record)[:1], *shown[:1]]
    overview = rrb.Horizontal(*text[:1], *([rrb.Vertical(*plots)] if plots else []), name="Overview")
    sheets = {
        "Curves": _curves(record),
        "Learned distribution": _learned(record),
        "Returns over contexts": _maps(record),
        "Gradients of contexts": _matrices(record),
        "Adaptation": _adapted(record),
    }
    pages: list[rrb.Container | rrb.View] = [
        *([overview] if text or plots else []),
        *(rrb.Grid(*views, name=name) for name, views in sheets.items() if views),
        *([episodes_page(record.episodes, look)] if record.episodes else []),
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
    if record.episodes:
        return rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing", loop_mode="all")
    return rrb.TimePanel(state="hidden")


def _counting(record: TrainingRecord) -> str | None:
    """The timeline of what changes while training goes on; None where nothing does."""
    if record.marginals or record.pairs or any(curve.over == ITERATIONS for curve in record.curves):
        return ITERATIONS
    return FRAMES if record.curves else None


def _curves(record: TrainingRecord) -> list[rrb.View]:
    return [_plot(curve) for curve in record.curves]


def _learned(record: TrainingRecord) -> list[rrb.View]:
    names = [*(marginal.name for marginal in record.marginals), *(_joined(pair) for pair in record.pairs)]
    present = [distributions.CANVAS.view(["distribution", name], f"p(z) of {name}") for name in names]
    changed = [marginal.name for marginal in record.marginals if len(marginal.iteration) > 1]
    return [*present, *(grids.CANVAS.view(["course", name], f"p(z) of {name} over iterations") for name in changed)]


def _maps(record: TrainingRecord) -> list[rrb.View]:
    maps = [grids.CANVAS.view(["grid", grid.title], f"returns, {grid.title}") for grid in record.grids]
    return [*violins.views(record.samples), *maps]


def _adapted(record: TrainingRecord) -> list[rrb.View]:
    gained = [heat_map.CANVAS.view(["gain", each.title], f"gain {each.title}") for each in record.gains]
    return [*gained, *(ways.CANVAS.view(["ways", each.title], f"ways, {each.title}") for each in record.ways)]


def _matrices(record: TrainingRecord) -> list[rrb.View]:
    return [heat_map.CANVAS.view(["matrix", each.title], each.title) for each in record.matrices]


def _plot(curve: Curve) -> rrb.TimeSeriesView:
    origin = rr.new_entity_path(["curve", curve.name])
    return rrb.TimeSeriesView(
        origin=origin,
        name=titled(curve.name, curve.unit),
        axis_x=counted_axis(0, int(curve.at[-1])),
        plot_legend=rrb.PlotLegend(visible=False),
    )


def _joined(pair: Pair) -> str:
    return ", ".join(pair.names)
