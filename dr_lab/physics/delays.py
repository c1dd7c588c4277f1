"""What delayed actuators and sensors remember of the time before a simulation starts."""

import mujoco
import numpy as np
from mujoco.batch import Batch

from dr_lab.physics.law import History
from dr_lab.trajectory import Array


def remembered_controls(model: mujoco.MjModel, past: Array, now: float = 0.0) -> Array:
    """History rows of a model whose actuators are delayed; its sensors remember zeros.

    Args:
        model: compiled model.
        past: controls of the steps before, oldest first, shape (w, p, nu); before them the first held.
        now: s.

    Returns:
        One row for each window, shape (w, nhistory).
    """
    data, rows = mujoco.MjData(model), np.empty((len(past), model.nhistory))
    for window, controls in enumerate(past):
        for actuator in range(model.nactuator):
            samples = int(model.actuator_history[actuator, 0])
            if samples:
                values = controls[-samples:, model.actuator_ctrladr[actuator]]
                values = np.concatenate([np.full(samples - len(values), values[0]), values])
                time = now + np.arange(-samples, 0) * model.opt.timestep
                mujoco.mj_initCtrlHistory(model, data, actuator, time, values)
        rows[window] = data.history
    return rows


def remember_readings(
    batch: Batch, model: mujoco.MjModel, history: History | None, controls: Array, before: int
) -> None:
    """Fill the memories of delayed and of slow sensors with what they read on the way to the present state.

    MuJoCo steps the batch, and before every step it is put where it was (`_way`), with its present activations. When a
    slow sensor reads next is not known: it does as after a reset.

    Args:
        batch: n simulations at their starts, at time 0, their actuators' memories filled.
        model: their model.
        history: what was measured before w starts; simulation i takes that of start i mod w. None for nothing.
        controls: controls of the steps around the start, shape (n, s, nu).
        before: how many of these steps lie before it.
    """
    kept = np.flatnonzero(model.sensor_history[:, 0])
    if not len(kept):
        return
    step, first = model.opt.timestep, int(model.sensor_historyadr[kept].min())  # actuators' memories come first
    apart = np.maximum(model.sensor_interval[kept, 0], step)
    steps = int(np.ceil((model.sensor_history[kept, 0] * apart).max() / step)) + 1
    start, act = batch.state.copy(), batch.bind("act").copy()
    qpos, qvel = _way(model, batch.bind("qpos").copy(), batch.bind("qvel").copy(), history, steps)
    memory, names = batch.bind("history"), ("qpos", "qvel", "act", "ctrl", "time")
    memory[:] = remembered_controls(model, controls[:, : max(before - steps, 1)], -steps * step)
    _set_back(model, memory, steps)
    place, speed, activation, control, clock = (batch.bind(name) for name in names)
    for k in range(steps):
        place[:], speed[:], activation[:], clock[:] = qpos[:, k], qvel[:, k], act, (k - steps) * step
        control[:] = controls[:, max(before - steps + k, 0)]
        batch.step()
    read = memory[:, first:].copy()
    batch.state[:], batch.warning[:] = start, 0
    due = memory[:, model.sensor_historyadr[kept]]
    memory[:, first:] = read
    memory[:, model.sensor_historyadr[kept]] = due


def _set_back(model: mujoco.MjModel, memory: Array, steps: int) -> None:
    """Let sensors' memories of a reset end at least so many steps earlier, by whole periods of theirs."""
    data, step = mujoco.MjData(model), model.opt.timestep
    for sensor in np.flatnonzero(model.sensor_history[:, 0]):
        samples, period = int(model.sensor_history[sensor, 0]), float(model.sensor_interval[sensor, 0])
        by = np.ceil(steps * step / (period or step)) * (period or step)
        first = int(model.sensor_historyadr[sensor])
        times = data.history[first + 2 : first + 2 + samples] - by  # behind the last computation and a cursor
        values = np.zeros((samples, int(model.sensor_dim[sensor])))
        mujoco.mj_initSensorHistory(model, data, sensor, times, values, data.history[first] - by)
        after = slice(first, first + 2 + samples + values.size)
        memory[:, after] = data.history[after]


def _way(model: mujoco.MjModel, qpos: Array, qvel: Array, history: History | None, steps: int) -> tuple[Array, Array]:
    """Positions (n, steps, nq) and velocities (n, steps, nv) at the beginnings of the steps that end at a start.

    Velocities are the measured ones, all changed by as much as the start's differs; before what was measured, the first
    of them lasts, and where nothing was measured, the start's.
    """
    step, known = model.opt.timestep, np.zeros((1, 0, model.nv)) if history is None else history.qvel[:, -steps:]
    middle = np.tile(qvel[:, None], (1, steps, 1))
    count = known.shape[1]
    if count:
        seen = np.concatenate([np.repeat(known[:, :1], steps - count, axis=1), known], axis=1)
        end = seen[:, -1] + (seen[:, -1] - seen[:, -2]) / 2
        middle += np.tile(seen - end[:, None], (len(qvel) // len(seen), 1, 1))
    ago = -step * np.cumsum(middle[:, ::-1], axis=1)[:, ::-1]
    speed = np.concatenate([middle[:, :1], (middle[:, 1:] + middle[:, :-1]) / 2], axis=1)
    place = np.repeat(qpos[:, None], steps, axis=1)
    if model.nq == model.nv:
        return place + ago, speed
    for index in np.ndindex(place.shape[:2]):
        mujoco.mj_integratePos(model, place[index], ago[index], 1.0)
    return place, speed
