"""What an actuator does at each joint by its control alone, for what no log needs to show."""

import copy

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.equation_error import actuation
from dr_lab.diagnosis.faults.smoothed_motion import Motion
from dr_lab.proposal.drives import integrates
from dr_lab.trajectory import Array

_PROBED = 50  # times at which an actuator's force per control is looked at


def made_up_motion(model: mujoco.MjModel) -> Motion:
    """Places about the reference, each with some velocity and acceleration, for what no log needs to show."""
    rng = np.random.default_rng(0)
    moving = rng.normal(scale=0.1, size=(3, _PROBED, model.nv))
    places = np.tile(model.qpos0, (_PROBED, 1))
    for place, move in zip(places, moving[0], strict=True):
        mujoco.mj_integratePos(model, place, move, 1.0)
    log, time, known = np.zeros(_PROBED, np.intp), np.arange(_PROBED, dtype=np.float64), np.ones(_PROBED, bool)
    return Motion(log, time, places, moving[1], moving[2], known, 0.1)


def per_control(model: mujoco.MjModel) -> tuple[Array, bool]:
    """Force of each actuator at each degree of freedom per unit of control, shape (nu, nv); whether any acts at 0.

    Activations are given time to settle. Of an actuator that integrates its control it is the force per unit of that
    integral.
    """
    model, motion = _integrated(model), made_up_motion(model)
    found = np.zeros((model.nu, model.nv))
    idle = np.zeros((_PROBED, model.nv))
    for k in range(model.nu):
        controls = np.zeros((_PROBED, model.nu))
        controls[:, k] = 1.0
        acting = actuation(model, motion, controls)
        found[k], idle = np.median(acting.driven.sum(1)[_PROBED // 2 :], axis=0), acting.idle
    return found, bool(np.abs(idle).max(initial=0.0) > 0)


def _integrated(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model, the controls of whose integrating actuators are the integrals themselves."""
    which = integrates(model)
    if not which.any():
        return model
    model = copy.deepcopy(model)
    model.actuator_dyntype[which], model.actuator_actadr[which] = int(mujoco.mjtDyn.mjDYN_NONE), -1
    model.actuator_actnum[which] = 0
    return model
