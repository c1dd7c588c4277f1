"""Where an experiment starts: a pose at which the machine stands, and the commands that hold it there."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.bounds import Positive, require_bounds
from dr_lab.physics.activations import resting
from dr_lab.trajectory import Array, Log


@dataclass(frozen=True)
class Stillness:
    """When a machine stands, and how it is brought to that.

    Attributes:
        acceleration: rad/s² or m/s², below which it stands.
        speed: rad/s or m/s, below which it has settled.
        longest: s that it may take to settle.
        brake: 1/s, damping by which it is braked meanwhile, times its inertia.
    """

    acceleration: Positive
    speed: Positive
    longest: Positive
    brake: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment.stillness")


@dataclass(frozen=True)
class Standing:
    """A machine that stands.

    Attributes:
        qpos: its pose, shape (nq,).
        hold: commands that keep it there, by actuator; controls where a model's filters are not considered.
        rests: whether it does stand; else it starts to move by itself.
    """

    qpos: Array
    hold: Mapping[str, float]
    rests: bool


def first_pose(model: mujoco.MjModel, logs: Sequence[Log]) -> Array:
    """The pose in which logs begin: the median first position of each measured joint, else the model's own."""
    qpos = model.qpos0.copy()
    for joint in range(model.njnt):
        name = f"{model.joint(joint).name}.position"
        begun = [float(log.outputs[name].value.ravel()[0]) for log in logs if name in log.outputs]
        if begun:
            qpos[model.jnt_qposadr[joint]] = np.median(begun)
    return qpos


def standing(
    model: mujoco.MjModel, qpos: Array, limits: Mapping[str, tuple[float, float]], stillness: Stillness
) -> Standing:
    """How a machine stands that is put at a pose and held by its commands as far as these can.

    The commands solve q̈(q, 0, u) = 0 in least squares, for which q̈ is taken as linear in u; the machine comes to rest
    from there, braked, where that leaves a motion, as of a pole that no actuator moves.

    Args:
        model: compiled model.
        qpos: the pose, shape (nq,).
        limits: lowest and highest command by actuator; other actuators have the command 0.
        stillness: when it stands.
    """
    held = _held(model, qpos, limits)
    if np.abs(_acceleration(model, qpos, held)).max(initial=0.0) > stillness.acceleration:
        qpos = _settled(model, qpos, held, stillness)
    still = np.abs(_acceleration(model, qpos, held)).max(initial=0.0) <= stillness.acceleration
    columns = {name: int(model.actuator_ctrladr[model.actuator(name).id]) for name in limits}
    return Standing(qpos, {name: float(held[column]) for name, column in columns.items()}, still)


def _held(model: mujoco.MjModel, qpos: Array, limits: Mapping[str, tuple[float, float]]) -> Array:
    columns = [int(model.actuator_ctrladr[model.actuator(name).id]) for name in limits]
    low, high = np.array(list(limits.values())).T
    controls = np.zeros(model.nu)
    controls[columns] = np.clip(0.0, low, high)
    for _ in range(2):  # once more where a limit was met
        now = _acceleration(model, qpos, controls, free=True)
        step = np.maximum((high - low) * 1e-3, np.finfo(float).tiny)
        slopes = np.empty((model.nv, len(columns)))
        for k, column in enumerate(columns):
            moved = controls.copy()
            moved[column] += step[k] if moved[column] + step[k] <= high[k] else -step[k]
            slopes[:, k] = (_acceleration(model, qpos, moved, free=True) - now) / (moved[column] - controls[column])
        asked = controls[columns] - np.linalg.lstsq(slopes, now, rcond=1e-9)[0]
        controls[columns] = np.clip(asked, low, high)
    return controls


def _acceleration(model: mujoco.MjModel, qpos: Array, controls: Array, *, free: bool = False) -> Array:
    """Accelerations from rest, shape (nv,); without the forces of constraints where the machine is to be `free`."""
    data = _resting(model, qpos, controls)
    mujoco.mj_forward(model, data)
    return (data.qacc_smooth if free else data.qacc).copy()


def _resting(model: mujoco.MjModel, qpos: Array, controls: Array) -> mujoco.MjData:
    """A machine at rest whose actuators have had their commands for long."""
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = qpos, controls
    if model.na:
        data.act[:] = resting(model, qpos[None], controls[None])[0]
    for i in range(model.nactuator):
        samples = int(model.actuator_history[i, 0])
        if samples:
            times = np.arange(-samples, 0) * model.opt.timestep
            held = np.full(samples, controls[model.actuator_ctrladr[i]])
            mujoco.mj_initCtrlHistory(model, data, i, times, held)
    return data


def _settled(model: mujoco.MjModel, qpos: Array, controls: Array, stillness: Stillness) -> Array:
    """Where a braked machine comes to rest under held commands."""
    data, inertia = _resting(model, qpos, controls), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    braked = copy(model)
    braked.dof_damping[:] += stillness.brake * np.diag(inertia)
    for _ in range(int(stillness.longest / model.opt.timestep)):
        mujoco.mj_step(braked, data)
        if np.abs(data.qvel).max() < stillness.speed and np.abs(data.qacc).max() < stillness.acceleration / 2:
            break
    return data.qpos.copy()
