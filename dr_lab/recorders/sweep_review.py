"""`review.rrd` of a sweep: tables, and what its runs learnt and earned, drawn over one another."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders import distributions, grids, heat_map, violins
from dr_lab.recorders.branch import FRAMES, Branch, entity_path
from dr_lab.recorders.counted_axis import counted_axis
from dr_lab.recorders.free_corner import free_corner
from dr_lab.recorders.interference import Interference
from dr_lab.recorders.look import Look
from dr_lab.recorders.matrices import log_matrix
from dr_lab.recorders.numbered_axis import numbered_axis
from dr_lab.recorders.recording import recording_file
from dr_lab.recorders.sampling import Sampled, highest_share, log_sampled
from dr_lab.recorders.sheet import sheet, sheet_rows
from dr_lab.recorders.training import Band, Grid, Marginal, Sample

# Rerun keeps one layout an application: every recording of a sweep shares this one.
APPLICATION = "dr_lab_sweep"
_RETURNS = "returns"  # below which lines over the same parameter are drawn over one another


@dataclass(frozen=True)
class SweepRecord:
    """What a recording of a sweep holds; what is empty gets no page.

    Attributes:
        name: of the recording.
        groups: what the runs are told apart by, which gives each its colour.
        bands: figures over control steps, those of the first page first.
        marginals: by parameter, what each group learnt of it.
        grids: returns over contexts, by group; those over the same parameter alone share one chart.
        violins: how returns are distributed, by group; all in one chart.
        pages: Markdown by title; the first stands on the first page.
        sampled: by parameter, how often contexts of each kind were drawn, one entry a group.
        interference: how the gradients of contexts agree, one entry a group and policy.
    """

    name: str
    groups: Sequence[str]
    bands: Sequence[Band] = ()
    marginals: Mapping[str, Mapping[str, Marginal]] = field(default_factory=dict)
    grids: Mapping[str, Grid] = field(default_factory=dict)
    violins: Mapping[str, Sequence[Sample]] = field(default_factory=dict)
    pages: Mapping[str, str] = field(default_factory=dict)
    sampled: Mapping[str, Sequence[Sampled]] = field(default_factory=dict)
    interference: Sequence[Interference] = ()

    @property
    def lines(self) -> dict[str, dict[str, Grid]]:
        """The grids over one parameter, by this and by group."""
        found: dict[str, dict[str, Grid]] = {}
        for group, grid in self.grids.items():
            if len(grid.axes) == 1:
                found.setdefault(grid.axes[0].name, {})[group] = grid
        return found

    @property
    def maps(self) -> dict[str, Grid]:
        """The grids over two."""
        return {group: grid for group, grid in self.grids.items() if len(grid.axes) == 2}


def write_sweep_review(path: Path, record: SweepRecord, look: Look) -> None:
    """Write the recording with its layout, atomically.

    Entities: ``/curve/<figure>/<group>``, with its ``interval``, on the timeline ``frames``,
    ``/distribution/<parameter>``, ``/returns/<parameter>`` and ``/grid/<group>``, ``/violins``,
    ``/sampled/<parameter>/<group>``, ``/matrix/<group and policy>``, ``/pages/<title>``.

    Args:
        path: the file, by custom ``review.rrd``.
        record: what it shows.
        look: colours and line widths.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with recording_file(path, APPLICATION, record.name, _blueprint(record)) as root:
        _log(root, record, look)


def _log(root: Branch, record: SweepRecord, look: Look) -> None:
    colours = {group: look.series(index) for index, group in enumerate(record.groups)}
    for band in record.bands:
        _log_band(root / "curve" / band.name / band.group, band, record.groups.index(band.group), look)
    for name, learned in record.marginals.items():
        distributions.log_marginals(root / "distribution" / name, learned, colours, look)
    for name, lines in record.lines.items():
        grids.log_lines(root / _RETURNS / name, lines, colours, look, grids.return_span(list(lines.values())))
    span = grids.return_span(list(record.maps.values()))
    for group, grid in record.maps.items():
        grids.log_grid(root / "grid" / group, grid, look, span)
    drawn = [(violin, colours[group]) for group, each in record.violins.items() for violin in each]
    if drawn:
        each, colour = zip(*drawn, strict=True)
        violins.log_violins(root / violins.ROOT, each, colour, look)
    for name, each in record.sampled.items():
        highest = max(map(highest_share, each))
        for sampled in each:
            log_sampled(root / "sampled" / name / sampled.group, sampled, look, highest)
    for interference in record.interference:
        log_matrix(root / "matrix" / interference.matrix.title, interference.matrix, look)
    for title, text in record.pages.items():
        (root / "pages" / title).static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def _log_band(place: Branch, band: Band, index: int, look: Look) -> None:
    """The mean as a line above its interval where this is known; of one point alone a dot, its ends as smaller ones."""
    known, within = np.isfinite(band.value), np.isfinite(band.low) & np.isfinite(band.high)
    colour, names = look.series(index), [band.group]
    if known.sum() == 1:  # of which a line or a band would show nothing
        values = np.stack([band.value, *([band.low, band.high] if within.any() else [])], axis=1)[known]
        sizes = [3 * look.line_width, look.line_width, look.line_width][: values.shape[1]]
        place.static(rr.SeriesPoints(colors=[colour] * len(sizes), names=names * len(sizes), marker_sizes=sizes))
        place.over_frames(band.frames[known], rr.Scalars.columns(scalars=values))
        return
    place.static(rr.SeriesLines(colors=[colour], names=names, widths=[look.line_width]))
    place.over_frames(band.frames[known], rr.Scalars.columns(scalars=band.value[known]))
    if within.any():
        low, high = band.low[within], band.high[within]
        around = place / "interval"
        around.static(rr.Measurements.from_fields(colors=[colour], names=names, widths=[0.0]))
        columns = rr.Measurements.columns(values=(low + high) / 2, variances=np.square((high - low) / 2))
        around.over_frames(band.frames[within], columns)


def _blueprint(record: SweepRecord) -> rrb.Blueprint:
    text = [rrb.TextDocumentView(origin=entity_path("pages", title), name=title) for title in record.pages]
    # A view stands in one place only: the overview has its own.
    plots = [*_curves(record)[:1], *(_learned(record) or _maps(record) or _matrices(record))[:1]]
    overview = rrb.Horizontal(*text[:1], *([rrb.Vertical(*plots)] if plots else []), name="Overview")
    sheets = {
        "Curves": _curves(record),
        "Learned distributions": _learned(record),
        "Returns over contexts": _maps(record),
        "Sampling frequency": _sampled(record),
        "Gradients of contexts": _matrices(record),
    }
    pages = [overview, *(sheet(name, views) for name, views in sheets.items() if views), *text[1:]]
    frames = rrb.TimePanel(state="collapsed", timeline=FRAMES, play_state="following")
    return rrb.Blueprint(
        rrb.Tabs(*pages, name="Review"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        frames if record.bands else rrb.TimePanel(state="hidden"),
    )


def _curves(record: SweepRecord) -> list[rrb.View]:
    """One plot a figure; the first says which colour is which group's."""
    last = max((int(band.frames[-1]) for band in record.bands if len(band.frames)), default=0)
    figures: dict[str, list[Band]] = {}
    for band in record.bands:
        figures.setdefault(band.name, []).append(band)
    rows = sheet_rows(len(figures))
    return [_plot(name, each, last, rows, legend=not k) for k, (name, each) in enumerate(figures.items())]


def _learned(record: SweepRecord) -> list[rrb.View]:
    return [distributions.CANVAS.view(["distribution", name], f"p(z) of {name}") for name in record.marginals]


def _maps(record: SweepRecord) -> list[rrb.View]:
    lines = [
        grids.CANVAS.view([_RETURNS, name], f"returns over {name}{grids.told([*each.values()])}")
        for name, each in record.lines.items()
    ]
    every = [violin for each in record.violins.values() for violin in each]
    return [
        *violins.views(every),
        *lines,
        *(grids.CANVAS.view(["grid", group], f"returns, {group}") for group in record.maps),
    ]


def _sampled(record: SweepRecord) -> list[rrb.View]:
    return [
        heat_map.CANVAS.view(["sampled", name, each.group], f"share of draws of {name}, {each.group} ({each.told})")
        for name, of_parameter in record.sampled.items()
        for each in of_parameter
    ]


def _matrices(record: SweepRecord) -> list[rrb.View]:
    return [
        heat_map.CANVAS.view(["matrix", each.matrix.title], f"cosine, {each.matrix.title} ({each.told})")
        for each in record.interference
    ]


def _plot(name: str, bands: Sequence[Band], last: int, rows: int, legend: bool) -> rrb.TimeSeriesView:
    curves = [(band.frames.astype(np.float64), np.stack([band.value, band.low, band.high], axis=1)) for band in bands]
    return rrb.TimeSeriesView(
        origin=entity_path("curve", name),
        name=name.replace("_", " "),
        axis_x=counted_axis(0, last),
        axis_y=numbered_axis((values for _, values in curves), rows),
        plot_legend=rrb.PlotLegend(free_corner(curves), visible=legend),
    )
