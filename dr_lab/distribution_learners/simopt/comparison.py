"""A target's episode beside what the model does of the same, for pictures."""

from collections.abc import Sequence

import numpy as np
from tensordict import TensorDict

from dr_lab.distribution_learners.simopt.discrepancy import courses
from dr_lab.distribution_learners.simopt.quantity import Quantity
from dr_lab.recorders.training import Comparison

_MOST = 200  # samples of a course; a screen shows no more


def comparisons(
    measured: Sequence[Quantity], seconds: float, real: TensorDict, simulated: TensorDict
) -> Sequence[Comparison]:
    """One entry for every quantity that is measured.

    Args:
        measured: the quantities.
        seconds: length of a control step.
        real: an episode of the target, size [T].
        simulated: the same in the model, size [1 + m, t], at the mean of the distribution first.
    """
    steps = int(real["mask"].sum())
    rows = np.unique(np.linspace(0, steps - 1, min(steps, _MOST)).astype(int))
    seen = courses(measured, real[None], steps)[0, rows]
    found = courses(measured, simulated, steps)[:, rows]
    time = (rows + 1) * seconds
    return [
        Comparison(each.name, each.unit, time, seen[:, c], found[0, :, c], found[1:, :, c])
        for c, each in enumerate(measured)
    ]
