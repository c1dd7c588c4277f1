"""`report.html` of train and evaluate."""

from pathlib import Path

from dr_lab.html.context_figures import marginal_plots, pair_plots
from dr_lab.html.curve_figures import choice_plots, curve_plots
from dr_lab.html.document import Chapter, Text, write_document
from dr_lab.html.return_figures import gain_plots, grid_plots, matrix_plots, sample_plots, ways_plots
from dr_lab.html.target_figures import comparison_plots, decline_plots
from dr_lab.recorders.training_review import TrainingRecord
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.page import Page
from dr_lab.reports.train import TrainReport


def write_training_page(path: Path, page: Page, report: TrainReport | EvaluateReport, record: TrainingRecord) -> None:
    """Write the page, atomically: what `report.md` says, with plots of what the recording holds.

    Args:
        path: the file, by custom ``report.html``.
        page: what is said.
        report: what was found.
        record: what is drawn.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    learned = [each for each in record.marginals if each.learned]
    fixed = [each for each in record.marginals if not each.learned]
    choice = report.choice if isinstance(report, TrainReport) else None
    pairs, curves = pair_plots(record.pairs), curve_plots(record.curves)
    returns = [plot for curve, plot in zip(record.curves[:1], curves, strict=False) if "return" in curve.name]
    plots = {
        "Mean returns": grid_plots(record.grids),
        "Returns": sample_plots(record.samples),
        "Adaptation": [*gain_plots(record.gains), *ways_plots(record.ways)],
        "Gradients of contexts": matrix_plots(record.matrices),
        "Return": returns,
        "Learned distribution": [*marginal_plots(learned, record.spreads), *pairs],
        "Target and model": [*decline_plots(record.declines), *comparison_plots(record.comparisons)],
        "Choice of the policy": choice_plots(choice),
        "Contexts of training": marginal_plots(fixed),
        "Other figures": curves[len(returns) :],
    }
    told = {section.title: [Text(section.body)] for section in page.sections if section.body}
    chapters = [Chapter(title, [*plots.get(title, ()), *told.get(title, ())]) for title in {**plots, **told}]
    write_document(path, page.title, page.lead, chapters)
