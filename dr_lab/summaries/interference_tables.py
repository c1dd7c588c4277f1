"""Interference between contexts as a report tells it."""

from collections.abc import Sequence

import numpy as np

from dr_lab.recorders.interference import Interference
from dr_lab.reports.page import Section
from dr_lab.reports.quantity import ABSENT, number, percent
from dr_lab.reports.summarize import InterferenceEntry
from dr_lab.reports.tables import table
from dr_lab.trajectory import Array

KEY = "interference"
_TOLD = (
    "Cosines between the policy gradients of every two contexts, mean of the runs of a setting; below 0 a step that "
    "improves the policy in one context makes it worse in the other. Noise of the gradients draws them to 0. spread is "
    "their standard deviation over the runs, mean of the pairs of different contexts; interfere, help and in doubt say "
    "how many of these pairs, as far as both have a gradient, have a mean whose interval lies below 0, above 0, or "
    "about it."
)


def interference_section(found: Sequence[Interference]) -> Section:
    """The table, a row a group and policy; empty where nothing was evaluated."""
    if not found:
        return Section(KEY, "", "")
    header = ["setting", "control steps", "runs", "contexts", "mean cosine", "spread", "interfere", "help", "in doubt"]
    return Section(KEY, "Gradients of contexts", f"{_TOLD}\n\n{table(header, [_row(each) for each in found])}")


def interference_entries(found: Sequence[Interference]) -> tuple[InterferenceEntry, ...]:
    """The matrices as `report.json` holds them."""
    return tuple(
        InterferenceEntry(
            group=each.group,
            parameter=each.axis.name,
            unit=each.axis.unit,
            runs=each.runs,
            frames=each.frames,
            values=tuple(each.axis.values.tolist()),
            mean=_rows(each.mean),
            spread=_rows(each.spread),
            doubtful=tuple(tuple(row) for row in each.doubtful.tolist()),
        )
        for each in found
    )


def _row(found: Interference) -> list[str]:
    pairs = np.triu_indices(len(found.mean), 1)
    known = np.isfinite(found.mean[pairs])
    mean, sure = found.mean[pairs][known], ~found.doubtful[pairs][known]
    shares = [each.mean() if len(each) else np.nan for each in (sure & (mean < 0.0), sure & (mean > 0.0), ~sure)]
    count = [str(found.frames), str(found.runs), str(len(found.mean))]
    means = [_mean(mean), _mean(found.spread[pairs])]
    return [found.group, *count, *means, *(percent(float(share)) for share in shares)]


def _mean(values: Array) -> str:
    known = values[np.isfinite(values)]
    return number(float(known.mean()), 3) if len(known) else ABSENT


def _rows(values: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in values.tolist())
