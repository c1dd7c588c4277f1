"""The next experiment, as a command file that can be played: between rivals, or for what is poorly known."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dr_lab.comparison.experiment_machine import experiment_machine
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.next_experiment.machine import Contender
from dr_lab.diagnosis.next_experiment.propose import Proposal, Refusal, separate, sharpen
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.next_experiment.standing import Standing
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.uncertainty import known
from dr_lab.files import write_text
from dr_lab.reports.gap_entries import ExperimentEntry, SharpenedEntry
from dr_lab.trajectory import Signal

FILE = "next_experiment.csv"


def deciding_experiment(
    study: Study, ladder: Ladder, settings: ExperimentSettings, run_dir: Path
) -> ExperimentEntry | None:
    """Look for the experiment that separates the first added effect with rivals from the first of them.

    Where there are no rivals it is the one that tells most about the last model's poorly known parameters. Writes
    ``next_experiment.csv``: column ``time_s`` and one column of held commands for each actuator.

    Returns:
        The report's entry; None where nothing is to be decided or sharpened, or the machine has no command.
    """
    step = next((step for step in ladder.steps if step.rivals), None)
    last = ladder.models[-1] if step is None else step.fitted_model
    found = experiment_machine(study, last, settings)
    if found is None:
        return None
    (machine, at_rest), chosen = found, contender(study, last)
    if step is None:
        proposal, labels = sharpen(chosen, machine, settings), ()
    else:
        rival = contender(study, step.rivals[0].fitted_model)
        proposal, labels = separate(chosen, rival, machine, settings), (chosen.label, rival.label)
    if proposal is None:
        return None
    if isinstance(proposal, Refusal):
        return ExperimentEntry(separates=labels, reason=proposal.reason)
    write_text(run_dir / FILE, _table(proposal.commands))
    return _entry(study, proposal, at_rest, labels, machine.command_rate)


def contender(study: Study, fitted_model: FittedModel) -> Contender:
    """A fitted model with the uncertainty that the report states."""
    return Contender(fitted_model.model, fitted_model.fit.z, known(study.bench, fitted_model).estimate.covariance)


def _entry(
    study: Study, proposal: Proposal, at_rest: Standing, labels: tuple[str, ...], rate: float
) -> ExperimentEntry:
    measured = [s.channel for s in study.bench.fit.samples if s.channel.kind == "position"]
    first = study.measurements.fit[0].commands
    return ExperimentEntry(
        separates=labels,
        sigma=proposal.sigma,
        needed=study.bench.evidence.threshold**0.5,
        duration=proposal.duration,
        command_file=FILE,
        rate=rate,
        start={channel.name: float(at_rest.qpos[channel.address]) for channel in measured},
        hold=dict(at_rest.hold),
        units={name: first[name].unit for name in at_rest.hold if name in first},
        rests=at_rest.rests,
        taken=proposal.taken,
        sharpens=tuple(SharpenedEntry(s.parameter, s.unit, s.before, s.after) for s in proposal.sharpened),
    )


def _table(commands: Mapping[str, Signal]) -> str:
    time = next(iter(commands.values())).time
    text = io.StringIO()
    rows = np.column_stack([time, *(signal.value for signal in commands.values())])
    np.savetxt(text, rows, fmt="%.9g", delimiter=",", header=",".join(["time_s", *commands]), comments="")
    return text.getvalue()
