"""Some of the windows, so that what is over in the others costs no simulation."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.windows import Windows


def subset(windows: Windows, rows: NDArray[np.intp]) -> Windows:
    """The windows at these places, of the same logs.

    Args:
        windows: w windows.
        rows: places, shape (k,).
    """
    before, prior = windows.before, windows.prior
    return replace(
        windows,
        log=windows.log[rows],
        begin=windows.begin[rows],
        samples=tuple(
            replace(s, time=s.time[rows], value=s.value[rows], fitted=s.fitted[rows], scored=s.scored[rows])
            for s in windows.samples
        ),
        controls=windows.controls[rows],
        past=windows.past[rows],
        before=replace(before, qpos=before.qpos[rows], qvel=before.qvel[rows], controls=before.controls[rows]),
        prior=replace(prior, qpos=prior.qpos[rows], qvel=prior.qvel[rows], qacc=prior.qacc[rows]),
    )
