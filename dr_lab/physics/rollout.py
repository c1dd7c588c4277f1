"""What simulations of windows give."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Rollout:
    """What `Simulator.replay` returns; n simulations, s steps.

    Attributes:
        qpos: positions at t = 0, dt, …, s·dt, shape (n, s + 1, nq).
        qvel: velocities at the same times, shape (n, s + 1, nv).
        sensordata: sensors at t = 0 … (s − 1)·dt (MuJoCo evaluates them before each step), shape (n, s, nsensordata).
        start: integration state (`mjSTATE_INTEGRATION`) from which each simulation began, shape (n, nstate).
        controls: controls as MuJoCo got them, behind the effects' command transforms and laws, shape (n, s, nu).
        infeasible: simulations that diverged or whose context does not compile, shape (n,).
    """

    qpos: Array
    qvel: Array
    sensordata: Array
    start: Array
    controls: Array
    infeasible: NDArray[np.bool_]
