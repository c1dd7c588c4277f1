"""`metrics.csv`: the error of every model on the scored logs, for spreadsheets and data frames."""

import csv
import io

from dr_lab.reports.gap import GapReport
from dr_lab.reports.ladder import steps

_OF_A_MODEL = ("chi2", "chi2_predicted")
_OF_A_CHANNEL = ("rmse", "rmse_predicted", "nrmse", "fit_percent")


def metrics_csv(report: GapReport) -> str:
    """One row a model and channel, models in the order of their making.

    Columns: ``model`` as the report calls it, ``effects`` that it holds, ``channel`` and its ``unit``; χ² per sample of
    all channels together (``chi2``, and ``chi2_predicted`` from starts known only from earlier samples); then of the
    channel ``rmse`` and ``rmse_predicted`` in its unit, ``nrmse`` and ``fit_percent``. What is not known is empty.

    Args:
        report: what was found.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["model", "effects", "channel", "unit", *_OF_A_MODEL, *_OF_A_CHANNEL])
    for step in steps(report):
        common = [getattr(step.held_out, key) for key in _OF_A_MODEL]
        for channel, noise in report.noise.items():
            own = [getattr(step.held_out, key).get(channel) for key in _OF_A_CHANNEL]
            writer.writerow([step.name, " ".join(step.effects), channel, noise.unit, *common, *own])
    return text.getvalue()
