"""The experiment that would tell two effects apart which the logs cannot separate."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dr_lab.bounds import Count, Positive, require_bounds
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.experiment import readings
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.errors import ConfigError, ModelError
from dr_lab.seeding import stream
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal


class Excitation(Protocol):
    """A shape of commands over time."""

    def command(self, time: Array, peak: float, generator: np.random.Generator) -> Array:
        """The command at each time, at most `peak` in size."""
        ...


@dataclass(frozen=True)
class ExperimentSettings:
    """Which experiments are tried, and how they are measured.

    Attributes:
        excitations: shapes of the commands, by name.
        shares: sizes of the commands, shares of what the actuator allows.
        draws: times that each shape is drawn anew.
        refitted: how many refits are finished at most, those that look best after the first steps.
        duration: s.
        command_rate: commands a second, Hz.
        sample_rate: samples a second of every channel, Hz.
        seed: of the draws.

    Raises:
        ConfigError: a number is too small, a share is not between 0 and 1, or there is no excitation.
    """

    excitations: Mapping[str, Excitation]
    shares: Sequence[float]
    draws: Count
    refitted: Count
    duration: Positive
    command_rate: Positive
    sample_rate: Positive
    seed: int

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment")
        if not self.excitations or not self.shares or not all(0 < share <= 1 for share in self.shares):
            raise ConfigError("next_experiment needs an excitation and shares between 0 and 1.")


@dataclass(frozen=True)
class ExperimentMachine:
    """What an experiment on the machine can do and show.

    Attributes:
        start: positions at which it begins, at rest, shape (nq,).
        limits: lowest and highest command by actuator.
        noise: noise of the measured channels.
        windows: how its log is cut.
        solver: settings of the fits.
        threads: C threads.
    """

    start: Array
    limits: Mapping[str, tuple[float, float]]
    noise: Mapping[str, Noise]
    windows: WindowSettings
    solver: SolverSettings
    threads: int


@dataclass(frozen=True)
class Proposal:
    """The experiment that separates two models most.

    Attributes:
        separates: labels of the two effects.
        sigma: √Δχ² by which the wrong model, refitted to this experiment, would miss it, whichever is the wrong one.
        excitation: name of the shape.
        commands: the commands by actuator, times in s from the start.
    """

    separates: tuple[str, str]
    sigma: float
    excitation: str
    commands: Mapping[str, Signal]


def propose(
    chosen: FittedModel, rival: FittedModel, machine: ExperimentMachine, settings: ExperimentSettings
) -> Proposal | None:
    """Play every experiment on both fitted models and keep the one that separates them most; None if none can run.

    One model plays the truth, without noise; the other is refitted to what it shows, the starts of all windows
    included, and what it still misses counts: min over both roles of √Σ (residual/σ)². After the first steps of all
    refits, those that still miss most are gone on with, until one misses more in the end than the next one now.
    """
    names = chosen.model.effects[-1].label, rival.model.effects[-1].label
    played = [
        _Played(excitation, commands, [_refit(*roles, commands, machine, settings) for roles in _roles(chosen, rival)])
        for excitation, commands in _experiments(machine, settings)
    ]
    played.sort(key=lambda each: -each.most)
    best: Proposal | None = None
    for each in played[: settings.refitted]:
        if best is not None and best.sigma >= each.most:
            break
        sigma = each.missed()
        if np.isfinite(sigma) and (best is None or sigma > best.sigma):
            best = Proposal(names, sigma, each.excitation, each.commands)
    return best


def _roles(
    chosen: FittedModel, rival: FittedModel
) -> tuple[tuple[FittedModel, FittedModel], tuple[FittedModel, FittedModel]]:
    """Who plays the truth, and who is refitted."""
    return (chosen, rival), (rival, chosen)


def _experiments(machine: ExperimentMachine, settings: ExperimentSettings) -> Iterator[tuple[str, dict[str, Signal]]]:
    """Commands within the actuators' limits."""
    time = np.arange(0.0, settings.duration, 1 / settings.command_rate)
    for name, shape in settings.excitations.items():
        for share in settings.shares:
            for draw in range(settings.draws):
                commands = {}
                for actuator, (low, high) in machine.limits.items():
                    generator = stream(settings.seed, name, str(draw), actuator)
                    wish = (low + high) / 2 + shape.command(time, share * (high - low) / 2, generator)
                    value = np.clip(wish, low, high)  # against rounding
                    commands[actuator] = Signal(actuator, "", time, value)
                yield name, commands


@dataclass(frozen=True)
class _Refit:
    """A model about to be refitted to what another one showed.

    Attributes:
        fitter: over the windows of the experiment.
        begun: the fit after its first steps.
    """

    fitter: Fitter
    begun: Fit

    @property
    def most(self) -> float:
        """What it misses at most after the refit, in σ: what it misses after the first steps."""
        return _sigma(self.begun)

    def missed(self) -> float:
        """What it misses after the refit, in σ."""
        return _sigma(self.fitter.run(self.begun.z, self.begun.delta))


@dataclass(frozen=True)
class _Played:
    """One experiment, played on both models; no refit where it cannot be played on one of them."""

    excitation: str
    commands: Mapping[str, Signal]
    refits: Sequence[_Refit | None]

    @property
    def most(self) -> float:
        """What the wrong model misses at most, whichever is the wrong one."""
        return min(-np.inf if refit is None else refit.most for refit in self.refits)

    def missed(self) -> float:
        """What it misses after refits."""
        return min(-np.inf if refit is None else refit.missed() for refit in self.refits)


def _sigma(fit: Fit) -> float:
    """√Σ (residual/σ)² of a fit; −∞ where a window diverges."""
    return -np.inf if fit.infeasible.any() else float(np.sqrt(max(fit.cost, 0.0)))


def _refit(
    truth: FittedModel,
    other: FittedModel,
    commands: Mapping[str, Signal],
    machine: ExperimentMachine,
    settings: ExperimentSettings,
) -> _Refit | None:
    """The other model with a few steps of a fit to what the truth showed; None where that cannot run."""
    time = np.arange(0.0, settings.duration, 1 / settings.sample_rate)
    try:
        shown = readings(truth.model, truth.fit.z, machine.start, commands, list(machine.noise), time)
    except ModelError:
        return None
    outputs = {n: Signal(n, machine.noise[n].unit, time, v[:, 0] if v.shape[1] == 1 else v) for n, v in shown.items()}
    log, gaps = Log("next_experiment", outputs, commands), dict.fromkeys(outputs, np.inf)
    measured = MeasurementSet("next_experiment", (log,), (), machine.noise, gaps)
    windows = cut([log], measured, other.model.nominal(), machine.windows)
    fitter = Fitter(Replay(other.model, windows, machine.threads), machine.solver)
    return _Refit(fitter, fitter.run(other.fit.z, iterations=machine.solver.start_iterations))
