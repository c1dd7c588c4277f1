"""What a reader of a summary should know: keys that no run has, and runs that are not what they seem."""

from collections.abc import Iterator, Mapping, Sequence

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.reports.places import beside
from dr_lab.summaries.configuration import experiment, flat, holds
from dr_lab.summaries.evaluated import TRAINED
from dr_lab.summaries.groups import ABSENT, CONFIGURATION, Group, figures_of
from dr_lab.summaries.runs import Run, picked
from dr_lab.sweeps.overrides import differing
from dr_lab.sweeps.sweep import identity_of


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
        if key not in typed and not any(holds(run.configuration, key) for run in runs):
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


def repeated_runs(runs: Sequence[Run], ignored: Sequence[str]) -> list[str]:
    """What to tell of runs that were configured alike, the seed included.

    Args:
        runs: that are summarised.
        ignored: keys of configurations that do not tell runs apart.
    """
    same: dict[str, list[str]] = {}
    for run in runs:
        same.setdefault(identity_of(experiment(run.configuration, ignored)), []).append(run.name)
    return [
        f"Configured alike, the seed included, so that one result counts {len(names)} times: {', '.join(names)}."
        for names in same.values()
        if len(names) > 1
    ]


def divided_runs(groups: Sequence[Group], ignored: Sequence[str]) -> list[str]:
    """What to tell of runs with the same overrides that were configured differently.

    Args:
        groups: of runs.
        ignored: keys of configurations that do not tell groups apart.
    """
    apart: dict[tuple[str, ...], list[Group]] = {}
    for group in groups:
        if group.settings.get(CONFIGURATION, ABSENT) != ABSENT:
            typed = tuple(value for key, value in group.settings.items() if key != CONFIGURATION)
            apart.setdefault(typed, []).append(group)
    told = []
    for alike in apart.values():
        keys = differing([flat(experiment(group.runs[0].configuration, ignored)) for group in alike])
        names = "; ".join(f"{group.label}: {', '.join(run.name for run in group.runs)}" for group in alike)
        told.append(f"The same overrides, but configured differently ({', '.join(keys)}): {names}.")
    return told


def lost_trainings(runs: Sequence[Run]) -> list[str]:
    """What to tell of evaluations whose training no longer says how it was made.

    Args:
        runs: that are summarised.
    """
    lost = [run.name for run in runs if isinstance(run.configuration.get(TRAINED), str)]
    if not lost:
        return []
    alone = "so that its path alone tells these evaluations apart"
    return [f"The folder of the training no longer says how it was made, {alone}: {', '.join(lost)}."]


def _missing(runs: Sequence[Run], schema: str, paths: Sequence[str]) -> Iterator[str]:
    reports = [run.report for run in runs if run.report["schema"] == schema]
    for path in paths:
        available = {key for report in reports for key in beside(report, path)}
        if available and not any(picked(report, [path]) for report in reports):
            yield str(UnknownNameError("figure", path, available, f"reports of schema {schema}"))
