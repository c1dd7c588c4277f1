"""The next experiment: the one that separates two models most, or tells most about what is poorly known."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.next_experiment.aims import Aim, poorly_known, separating, sharpening
from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.next_experiment.search import Found, NothingFound, Search
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.errors import DataError
from dr_lab.trajectory import Signal

_LEAST_COMMANDS = 3  # the first and the last hold the machine


@dataclass(frozen=True)
class Sharpened:
    """A parameter that an experiment would tell better.

    Attributes:
        parameter: its name.
        unit: its unit.
        before: its standard deviation by the logs.
        after: the same after the experiment.
    """

    parameter: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True)
class Proposal:
    """An experiment that may be played.

    Attributes:
        commands: the commands by actuator, times in s from the start; they begin and end with those that hold it.
        duration: s.
        taken: largest share of any limit, less its reserve, that the simulated motions take.
        sigma: √Δχ² by which the wrong model, refitted to this experiment, would miss it; None where it separates none.
        sharpened: the parameters that it is for; none where it separates models.
    """

    commands: Mapping[str, Signal]
    duration: float
    taken: float
    sigma: float | None = None
    sharpened: tuple[Sharpened, ...] = ()


@dataclass(frozen=True)
class Refusal:
    """Why no experiment is proposed.

    Attributes:
        reason: which limit stands in the way, in words.
    """

    reason: str


def separate(
    chosen: Contender, rival: Contender, machine: ExperimentMachine, settings: ExperimentSettings
) -> Proposal | Refusal:
    """The experiment that separates two models most.

    One model plays the truth, without noise; the other is refitted to what it shows, the starts of all windows
    included, and what it still misses counts: min over both roles of √Σ (residual/σ)².
    """
    aim = separating(chosen, rival, machine, settings.seconds, settings.iterations)
    found = _longest(aim, machine, settings)
    if isinstance(found, NothingFound):
        return Refusal(found.reason)
    return _proposal(found, machine, sigma=found.value)


def sharpen(
    contender: Contender, machine: ExperimentMachine, settings: ExperimentSettings
) -> Proposal | Refusal | None:
    """The experiment that tells most about the parameters that are poorly known; None where none is."""
    poor = poorly_known(contender, settings.poor, settings.least_size)
    if not poor:
        return None
    aim = sharpening(contender, poor, machine, settings.seconds)
    found = _longest(aim, machine, settings)
    if isinstance(found, NothingFound):
        return Refusal(found.reason)
    space, std = contender.model.space, np.sqrt(np.diag(contender.covariance))
    rows = zip(poor, aim.after(found.shown), strict=True)
    sharpened = tuple(Sharpened(space.names[k], space.parameters[k].unit, float(std[k]), float(s)) for k, s in rows)
    return replace(
        _proposal(found, machine), sharpened=tuple(sorted(sharpened, key=lambda row: row.after / row.before))
    )


def _longest(aim: Aim, machine: ExperimentMachine, settings: ExperimentSettings) -> Found | NothingFound:
    """The best experiment of the first duration in which there is one."""
    found: Found | NothingFound = NothingFound("too little time for a window, or for commands as rare as the logs'")
    for duration in settings.durations:
        if len(machine.command_times(duration)) < _LEAST_COMMANDS:
            continue
        try:
            found = Search(aim, machine, settings, duration).run()
        except DataError:  # too short for what its windows remember
            continue
        if isinstance(found, Found):
            break
    return found


def _proposal(found: Found, machine: ExperimentMachine, sigma: float | None = None) -> Proposal:
    (commands,) = machine.signals(found.values[None], found.time)
    return Proposal(commands, float(found.time[-1]), found.taken, sigma)
