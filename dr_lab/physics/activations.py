"""Activations of actuators: how long each remembers, and where it is while the machine rests."""

import mujoco
import numpy as np

from dr_lab.trajectory import Array

_FILTERS = (int(mujoco.mjtDyn.mjDYN_FILTER), int(mujoco.mjtDyn.mjDYN_FILTEREXACT))
_INTEGRATOR, _MUSCLE, _MOTOR = (
    int(kind) for kind in (mujoco.mjtDyn.mjDYN_INTEGRATOR, mujoco.mjtDyn.mjDYN_MUSCLE, mujoco.mjtDyn.mjDYN_DCMOTOR)
)
_RK4 = int(mujoco.mjtIntegrator.mjINT_RK4)
_SLOWEST_MUSCLE = 2.0  # MuJoCo scales the two time constants by 0.5 + 1.5 a or its inverse, a from 0 to 1
_FIXED = int(mujoco.mjtGain.mjGAIN_FIXED)
_AFFINE = int(mujoco.mjtBias.mjBIAS_AFFINE)


def time_constants(model: mujoco.MjModel) -> Array:
    """Time in s in which each activation forgets all but 1/e of what it was, infinite where it never does, shape (na,).

    Filters and pressures forget in their time constant, muscles at the latest in twice the longer of theirs, and the
    current of a motor, its last activation, in L/R. Integrals, slewed setpoints, windings' temperatures and bristles,
    and what the compiled model does not tell (callbacks, plugins), do not forget with time.
    Source: MuJoCo, Computation, Stateful actuators; XML reference, dcmotor and pid.
    """
    found = np.full(model.na, np.inf)
    for i in range(model.nactuator):
        first, count = int(model.actuator_actadr[i]), int(model.actuator_actnum[i])
        kind, values = int(model.actuator_dyntype[i]), model.actuator_dynprm[i]
        if not count or model.actuator_plugin[i] >= 0:
            continue
        if kind in _FILTERS and count == 1:
            found[first] = values[0]
        elif kind == _MUSCLE:
            found[first] = _SLOWEST_MUSCLE * max(values[0], values[1])
        elif kind == _MOTOR and values[0] > 0:
            found[first + count - 1] = values[0]
    return found


def settle_filters(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Let filters have had the present controls all along."""
    if not model.na:  # asked for often
        return
    filters = np.flatnonzero(np.isin(model.actuator_dyntype, _FILTERS))
    data.act[model.actuator_actadr[filters]] = data.ctrl[model.actuator_ctrladr[filters]]


def left_in_filters(model: mujoco.MjModel) -> Array:
    """Shares of what a filter held before a step in what it gives through it and holds after it, shape (2, nu).

    By its control; 0 for controls that no filter takes.
    """
    filters, shares = np.flatnonzero(np.isin(model.actuator_dyntype, _FILTERS)), np.zeros((2, model.nu))
    gone = model.opt.timestep / np.maximum(model.actuator_dynprm[filters, 0], mujoco.mjMINVAL)
    linear = (model.actuator_dyntype[filters] == _FILTERS[0]) & (model.opt.integrator != _RK4)
    left = np.where(linear, 1.0 - gone, np.exp(-gone))
    given = np.where(model.actuator_actearly[filters], left, 1.0)
    shares[:, model.actuator_ctrladr[filters]] = given, left
    return shares


def holders(model: mujoco.MjModel) -> tuple[str, ...]:
    """The name of the actuator that each activation belongs to, shape (na,)."""
    names = [""] * model.na
    for i in range(model.nactuator):
        first, count = int(model.actuator_actadr[i]), int(model.actuator_actnum[i])
        names[first : first + count] = [model.actuator(i).name] * count
    return tuple(names)


def resting(model: mujoco.MjModel, qpos: Array, controls: Array) -> Array:
    """Activations after a long rest under held controls, those that never end where they would push with no force.

    A filter or muscle is at its control; an integrator whose force falls with its length (a servo that holds the
    integral of its commands) is where that force is zero; all others are 0, as after MuJoCo's reset.

    Args:
        model: compiled model.
        qpos: positions of n machines at rest, shape (n, nq).
        controls: their controls, shape (n, nu).

    Returns:
        Shape (n, na).
    """
    act, data = np.zeros((len(qpos), model.na)), mujoco.MjData(model)
    for row, q, u in zip(act, qpos, controls, strict=True):
        data.qpos[:] = q
        mujoco.mj_fwdPosition(model, data)
        for i in (int(each) for each in np.flatnonzero(model.actuator_actnum == 1)):
            row[model.actuator_actadr[i]] = _resting(model, i, u, float(data.actuator_length[model.actuator_outadr[i]]))
    return act


def _resting(model: mujoco.MjModel, actuator: int, controls: Array, length: float) -> float:
    kind, column, value = int(model.actuator_dyntype[actuator]), int(model.actuator_ctrladr[actuator]), 0.0
    if kind in (*_FILTERS, _MUSCLE) and model.actuator_ctrlnum[actuator] == 1:
        value = float(controls[column])
        if model.actuator_ctrllimited[column]:
            value = float(np.clip(value, *model.actuator_ctrlrange[column]))
        value = min(max(value, 0.0), 1.0) if kind == _MUSCLE else value
    elif kind == _INTEGRATOR and int(model.actuator_gaintype[actuator]) == _FIXED:
        gain, bias = float(model.actuator_gainprm[actuator, 0]), model.actuator_biasprm[actuator]
        if gain and int(model.actuator_biastype[actuator]) == _AFFINE:
            value = -float(bias[0] + bias[1] * length) / gain
    if model.actuator_actlimited[actuator]:
        value = float(np.clip(value, *model.actuator_actrange[actuator]))
    return value
