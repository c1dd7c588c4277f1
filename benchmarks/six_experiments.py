"""The six random experiments of which the best was proposed before: the baseline of `next_experiment.py`."""

from itertools import product

import numpy as np

from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.next_experiment.trial import tried
from dr_lab.plants.excitation import SinesAndSteps
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

SIX = {  # the experiments that were tried before: shape, share of the largest command
    "slow": SinesAndSteps(3, 0.1, 1.0, 0.0, (0.5, 1.0), None),
    "fast": SinesAndSteps(5, 1.0, 10.0, 0.0, (0.5, 1.0), None),
    "steps": SinesAndSteps(1, 0.5, 2.0, 5.0, (0.1, 0.6), None),
}
SHRUNK = 0.9 ** np.arange(0, 40, 4)  # about the hold, until the limits are kept


def six(machine: ExperimentMachine, duration: float, seed: int) -> Array:
    """Commands of the six experiments, shape (6, m, k)."""
    times, bounds = machine.command_times(duration), machine.bounds
    made = []
    for (name, shape), share in product(SIX.items(), (0.2, 1.0)):
        rows = [
            np.clip(
                (low + high) / 2 + shape.command(times, share * (high - low) / 2, stream(seed, name, "0", actuator)),
                low,
                high,
            )
            for actuator, low, high in zip(machine.names, bounds.low, bounds.high, strict=True)
        ]
        made.append(np.stack(rows))
    return np.stack(made)


def gentle(values: Array, machine: ExperimentMachine, one: Contender, settings: ExperimentSettings) -> Array | None:
    """One of the six, shrunk about the commands that hold the machine until it keeps the limits; None if never."""
    hold = machine.bounds.hold[:, None]
    ramp = np.clip(np.arange(values.shape[1]) / machine.command_rate / settings.family.ramp, 0.0, 1.0)
    tries = np.stack([hold + scale * ramp * (values - hold) for scale in SHRUNK])
    times = np.arange(values.shape[1]) / machine.command_rate
    trial = tried(one, one.z[None], machine.signals(tries, times), machine, 0.02)
    kept = np.flatnonzero(trial.excess <= 1)
    return tries[kept[0]] if len(kept) else None
