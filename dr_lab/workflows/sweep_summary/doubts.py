"""What was asked of runs and none of them has."""

from collections.abc import Iterator, Mapping, Sequence

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.workflows.sweep_summary.configuration import without
from dr_lab.workflows.sweep_summary.groups import figures_of
from dr_lab.workflows.sweep_summary.runs import Run, beside, picked


def require_known(runs: Sequence[Run], aggregate: Sequence[str]) -> None:
    """Refuse to take runs together over a key that none of them has.

    Args:
        runs: that are summarised.
        aggregate: keys of overrides.

    Raises:
        UnknownNameError: no run has such a key, neither typed nor in its configuration.
    """
    typed = {key for run in runs for key in run.overrides}
    for key in aggregate:
        if key not in typed and not any(without(run.configuration, key) != run.configuration for run in runs):
            raise UnknownNameError("override", key, typed, "these runs (aggregate)")


def missing_figures(runs: Sequence[Run], figures: Mapping[str, Sequence[str]]) -> list[str]:
    """What to tell of the paths into reports that lead nowhere.

    Args:
        runs: that are summarised.
        figures: paths into a report, by its schema.

    Returns:
        A sentence each, with the closest key.

    Raises:
        ConfigError: not one figure was found.
    """
    told = [sentence for schema, paths in figures.items() for sentence in _missing(runs, schema, paths)]
    if told and not any(figures_of(run, figures) for run in runs):
        raise ConfigError("\n".join(["Not one of the figures was found.", *told]))
    return told


def _missing(runs: Sequence[Run], schema: str, paths: Sequence[str]) -> Iterator[str]:
    reports = [run.report for run in runs if run.report["schema"] == schema]
    for path in paths:
        available = {key for report in reports for key in beside(report, path)}
        if available and not any(picked(report, [path]) for report in reports):
            yield str(UnknownNameError("figure", path, available, f"reports of schema {schema}"))
