"""The six random experiments of which the best was proposed before: the baseline of `next_experiment.py`."""

from collections.abc import Sequence
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
SHRUNK = 0.9 ** np.arange(0, 40, 2)  # about the hold, until the limits are kept

LOOK = 0.004  # s between two looks at the distances of parts


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


def gentle(
    values: Array, machine: ExperimentMachine, models: Sequence[Contender], settings: ExperimentSettings
) -> Array | None:
    """One of the six, shrunk about the commands that hold the machine until it keeps the limits; None if never.

    They are the limits that a proposal keeps: by both models, in contexts that are drawn from what their fits do not
    know. The experiment also starts and ends as softly.
    """
    hold, times = machine.bounds.hold[:, None], np.arange(values.shape[1]) / machine.command_rate
    ramp = np.clip(np.minimum(times, times[-1] - times) / settings.family.ramp, 0.0, 1.0)
    tries = machine.signals(np.stack([hold + scale * ramp * (values - hold) for scale in SHRUNK]), times)
    excess, generator = np.zeros(len(SHRUNK)), stream(settings.seed, "six")
    for model in models:
        z = model.drawn(settings.safety.draws, settings.safety.spread, generator)
        excess = np.maximum(excess, tried(model, z, tries, machine, LOOK).excess)
    kept = np.flatnonzero(excess <= 1)
    return hold + SHRUNK[kept[0]] * ramp * (values - hold) if len(kept) else None
