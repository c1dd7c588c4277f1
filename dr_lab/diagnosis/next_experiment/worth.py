"""What experiments are worth: how far they separate two models, how well they would tell parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal

_PLAIN = 1e9  # robust standard deviations: no residual of a motion without noise is an outlier


@dataclass(frozen=True)
class Shots:
    """What n experiments show, without noise.

    Attributes:
        commands: by actuator, n of them.
        outputs: by channel, shape (n, m, raw size).
        duration: s.
    """

    commands: Sequence[Mapping[str, Signal]]
    outputs: Mapping[str, Array]
    duration: float

    def pick(self, rows: Sequence[int]) -> "Shots":
        """Some of the experiments."""
        kept = {name: value[list(rows)] for name, value in self.outputs.items()}
        return Shots([self.commands[row] for row in rows], kept, self.duration)


def apart(one: Shots, other: Shots, machine: ExperimentMachine) -> Array:
    """√Σ (difference/σ)² of what two models show, shape (n,), less a straight line in each window.

    A line is what a window's own start takes up of a difference, at the least.
    """
    count = max(1, round(machine.cutting(one.duration).length * machine.sample_rate))
    total = np.zeros(len(one.commands))
    for name, noise in machine.noise.items():
        difference = (one.outputs[name] - other.outputs[name]) / noise.std
        whole = difference.shape[1] // count * count
        parts = difference[:, :whole].reshape(len(total), -1, count, difference.shape[2])
        line = np.linspace(-1.0, 1.0, count)
        basis = np.linalg.qr(np.stack([np.ones(count), line], axis=1))[0]
        taken = np.einsum("ab,nwbc->nwac", basis @ basis.T, parts)
        total += ((parts - taken) ** 2).sum(axis=(1, 2, 3))
    return np.sqrt(total)


def told(shots: Shots, model: Contender, machine: ExperimentMachine, seconds: float) -> Array:
    """Information about a model's parameters in each experiment, in the unit cube, shape (n, p, p) by a linear step.

    Only some seconds of each are simulated; the result is scaled to the whole.
    """
    fit, of = _linear(shots, model, machine, seconds)
    every = fit.equations.window_information()[0]
    every[fit.infeasible] = 0.0
    scale = shots.duration / min(seconds, shots.duration)
    return scale * np.stack([every[rows].sum(0) for rows in of])


def missed(truth: Shots, other: Contender, machine: ExperimentMachine) -> float:
    """√Δχ² that a model misses of what the truth shows in one experiment after a refit; −∞ where a window diverges.

    The refit ends where a step gains less than the solver's rough tolerance of the cost.
    """
    fitter = _fitter(truth, other, machine.cutting(truth.duration), machine.solver, machine, rough=True)
    return _missed(fitter.run(other.z))


def missed_at_most(
    truth: Shots, other: Contender, machine: ExperimentMachine, seconds: float, iterations: int
) -> float:
    """The same after the first steps of a refit, by some seconds of the experiment, scaled to the whole.

    A single linear step foretells little: of 14 experiments on the demo's pendulum it gave 2 to 1300 σ where refits
    left 0.3 to 480; six steps are within a few per cent of them where they leave much.
    """
    windows = machine.seconds(truth.duration, seconds, 1)
    fitter = _fitter(truth, other, windows, replace(machine.solver, huber=_PLAIN), machine, rough=True)
    share = min(seconds, truth.duration) / truth.duration
    return _missed(fitter.run(other.z, iterations=iterations)) / share**0.5


def _missed(fit: Fit) -> float:
    return -np.inf if fit.infeasible.any() else float(np.sqrt(max(fit.cost, 0.0)))


def _linear(
    shots: Shots, model: Contender, machine: ExperimentMachine, seconds: float
) -> tuple[Fit, Sequence[np.ndarray]]:
    """A fit that is only linearised, of all experiments at once, and the windows of each."""
    windows = machine.seconds(shots.duration, seconds, len(shots.commands))
    fitter = _fitter(shots, model, windows, replace(machine.solver, huber=_PLAIN), machine)
    cutted = fitter.replay.windows
    return fitter.run(model.z, iterations=0), [np.flatnonzero(cutted.log == k) for k in range(len(shots.commands))]


def _fitter(
    shots: Shots,
    model: Contender,
    windows: WindowSettings,
    solver: SolverSettings,
    machine: ExperimentMachine,
    *,
    rough: bool = False,
) -> Fitter:
    time = machine.sample_times(shots.duration)
    logs = [
        Log(f"experiment {k}", {n: _signal(n, v[k], time, machine) for n, v in shots.outputs.items()}, commands)
        for k, commands in enumerate(shots.commands)
    ]
    gaps = dict.fromkeys(shots.outputs, np.inf)
    measured = MeasurementSet("next_experiment", tuple(logs), (), machine.noise, gaps)
    pieces = cut(logs, measured, model.model.nominal(), windows)
    return Fitter(Replay(model.model, pieces, machine.threads), solver, rough=rough)


def _signal(name: str, value: Array, time: Array, machine: ExperimentMachine) -> Signal:
    return Signal(name, machine.noise[name].unit, time, value[:, 0] if value.shape[1] == 1 else value)
