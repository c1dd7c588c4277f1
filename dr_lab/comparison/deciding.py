"""The experiment that would decide between rivals, as a command file that can be played."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.next_experiment import ExperimentMachine, ExperimentSettings, propose
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.files import write_text
from dr_lab.reports.gap_entries import ExperimentEntry
from dr_lab.trajectory import Signal

FILE = "next_experiment.csv"


def deciding_experiment(
    study: Study, ladder: Ladder, settings: ExperimentSettings, run_dir: Path
) -> ExperimentEntry | None:
    """Look for the experiment that separates the first added effect with rivals from the best of them.

    Writes ``next_experiment.csv``: column ``time_s`` and one column of held commands for each actuator.

    Returns:
        The report's entry; None where the ladder leaves no rivals, or the machine no command.
    """
    step = next((step for step in ladder.steps if step.rivals), None)
    limits = _limits(study)
    if step is None or not limits:
        return None
    machine = ExperimentMachine(
        start=study.compiled.qpos0,
        limits=limits,
        noise={name: study.measurements.noise[name] for name in study.measurements.fit[0].outputs},
        windows=study.settings.windows,
        solver=study.bench.solver,
        threads=study.bench.threads,
    )
    found = propose(step.fitted_model, step.rivals[0].fitted_model, machine, settings)
    if found is None:
        return None
    write_text(run_dir / FILE, _table(found.commands))
    return ExperimentEntry(
        separates=tuple(found.separates),
        sigma=found.sigma,
        needed=study.bench.evidence.threshold**0.5,
        excitation=found.excitation,
        duration=settings.duration,
        command_file=FILE,
    )


def _limits(study: Study) -> dict[str, tuple[float, float]]:
    """Range of each command: the actuator's ctrlrange, or as far as the logs went."""
    compiled, limits = study.compiled, {}
    for name, column in study.bench.fit.commands.items():
        largest = study.scales.command.get(name, 0.0)
        low, high = compiled.actuator_ctrlrange[column] if compiled.actuator_ctrllimited[column] else (0.0, 0.0)
        low, high = (float(low), float(high)) if high > low else (-largest, largest)
        if high > low:
            limits[name] = (low, high)
    return limits


def _table(commands: Mapping[str, Signal]) -> str:
    time = next(iter(commands.values())).time
    text = io.StringIO()
    rows = np.column_stack([time, *(signal.value for signal in commands.values())])
    np.savetxt(text, rows, fmt="%.9g", delimiter=",", header=",".join(["time_s", *commands]), comments="")
    return text.getvalue()
