"""Servos whose setpoint is the integral of a velocity command begin where their joint stands."""

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray


class Setpoints:
    """Setpoints of the integrated velocity servos (``intvelocity``) at joints, as parts of the activations.

    MuJoCo begins with every activation at 0, which would draw the joints to their zero at once.

    Source: MuJoCo 4.0, XML reference, actuator/intvelocity (dyntype integrator, force kp (act - length) - kv velocity).

    Args:
        batch: the simulations.
    """

    def __init__(self, batch: Batch) -> None:
        model = batch.model
        integrated = model.actuator_dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR
        servo = (model.actuator_biasprm[:, 1] != 0.0) & (model.actuator_biasprm[:, 1] == -model.actuator_gainprm[:, 0])
        self._servos = np.flatnonzero(integrated & servo & (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT))
        self._activation = model.actuator_actadr[self._servos]
        self._joint = model.jnt_qposadr[model.actuator_trnid[self._servos, 0]]
        self._gear = model.actuator_gear[self._servos, 0]
        self._act, self._qpos = batch.bind("act"), batch.bind("qpos")

    def follow(self, rows: NDArray[np.intp]) -> None:
        """Set them to where the joints of these simulations stand."""
        if len(self._servos):
            self._act[rows[:, None], self._activation] = self._gear * self._qpos[rows[:, None], self._joint]
