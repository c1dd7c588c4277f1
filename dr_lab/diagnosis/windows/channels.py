"""Measured channels as functions of a rollout: joint states and any MuJoCo sensor, at any time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.physics.sensor_axes import AXES, sensor_axes
from dr_lab.trajectory import Array, Log

Index = NDArray[np.intp]
_SCALAR_JOINTS = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_QUATERNION_SENSORS = (int(mujoco.mjtSensor.mjSENS_FRAMEQUAT), int(mujoco.mjtSensor.mjSENS_BALLQUAT))


@dataclass(frozen=True)
class Channel:
    """One measured channel and where the simulator shows it.

    Attributes:
        name: ``"<joint>.position"``, ``"<joint>.velocity"``, ``"sensor.<name>"`` or one axis of that,
            ``"sensor.<name>.x"``.
        kind: ``position``, ``velocity``, ``sensor`` or ``orientation``.
        address: first entry in qpos, qvel or sensordata.
        dof: the joint's degree of freedom, −1 for sensors.
        size: number of residual components (an orientation has 3).
    """

    name: str
    kind: str
    address: int
    dof: int
    size: int

    @property
    def numbers(self) -> int:
        """How many numbers a reading has: 4 of an orientation, which is a quaternion."""
        return 4 if self.kind == "orientation" else self.size


def resolve(model: mujoco.MjModel, names: Sequence[str]) -> tuple[Channel, ...]:
    """Find the named channels in the model.

    Raises:
        UnknownNameError: the model has no such channel; the message lists those it has.
    """
    known = available(model)
    for name in names:
        if name not in known:
            raise UnknownNameError("output", name, known, "the model (joint states and sensors)")
    return tuple(known[name] for name in names)


def require_numbers(channel: Channel, log: Log) -> None:
    """Check that a log's samples of a channel have as many numbers as the model's.

    Raises:
        DataError: they have not.
    """
    value = log.outputs[channel.name].value
    found = 1 if value.ndim == 1 else value.shape[1]
    if found == channel.numbers:
        return
    vector = channel.kind == "sensor" and channel.numbers == len(AXES)
    one = f" Of one axis the name is {channel.name}.x, .y or .z." if vector else ""
    raise DataError(
        f"Log {log.name!r}: a sample of the model's {channel.name} has {channel.numbers} numbers, one of the log "
        f"{found}. Name as many columns or fields.{one}"
    )


def available(model: mujoco.MjModel) -> dict[str, Channel]:
    """Every channel that the model can show, by name."""
    channels = []
    for i in range(model.njnt):
        if int(model.jnt_type[i]) in _SCALAR_JOINTS:
            name, qpos, dof = model.joint(i).name, int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i])
            channels.append(Channel(f"{name}.position", "position", qpos, dof, 1))
            channels.append(Channel(f"{name}.velocity", "velocity", dof, dof, 1))
    for i in range(model.nsensor):
        address, size = int(model.sensor_adr[i]), int(model.sensor_dim[i])
        quaternion = int(model.sensor_type[i]) in _QUATERNION_SENSORS
        kind = "orientation" if quaternion else "sensor"
        channels.append(Channel(f"sensor.{model.sensor(i).name}", kind, address, -1, 3 if quaternion else size))
    for name, (i, axis) in sensor_axes(model).items():
        channels.append(Channel(f"sensor.{name}", "sensor", int(model.sensor_adr[i]) + axis, -1, 1))
    return {channel.name: channel for channel in channels}


def unmeasured_joints(model: mujoco.MjModel, names: Sequence[str]) -> tuple[str, ...]:
    """Hinge and slide joints of which the named channels show neither the position nor the velocity."""
    joints = (model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in _SCALAR_JOINTS)
    return tuple(name for name in joints if not {f"{name}.position", f"{name}.velocity"} & set(names))


@dataclass(frozen=True)
class Tape:
    """Rollouts laid out for reading: c contexts × w windows × s steps of length `step`.

    Attributes:
        qpos: shape (c, w, s + 1, nq).
        qvel: shape (c, w, s + 1, nv).
        sensordata: shape (c, w, s, nsensordata).
        start: integration state of each simulation's start, shape (c, w, nstate).
        controls: controls as MuJoCo got them, shape (c, w, s, nu).
        step: s.
    """

    qpos: Array
    qvel: Array
    sensordata: Array
    start: Array
    controls: Array
    step: float

    def pick(self, rows: Index) -> "Tape":
        """The rollouts of some windows."""
        names = ("qpos", "qvel", "sensordata", "start", "controls")
        return replace(self, **{name: getattr(self, name)[:, rows] for name in names})

    def read(self, channel: Channel, time: Array) -> Array:
        """Values of a channel at times after the start, shape (c or 1, w, m) → (c, w, m, size of the raw value).

        Positions are cubic Hermite interpolants through positions and velocities, so a millisecond step adds no
        visible error; velocities and sensors are linear between steps. Beyond its ends the motion rests.
        """
        if channel.kind == "position":
            return self._hermite(channel, time)[..., None]
        if channel.kind == "velocity":
            return self._linear(self.qvel[..., channel.address : channel.address + 1], time)
        return self._linear(self.sensordata[..., channel.address : channel.address + channel.numbers], time)

    def _hermite(self, channel: Channel, time: Array) -> Array:
        k, f = self._cell(time, self.qpos.shape[2])
        q, v = self.qpos[..., channel.address], self.qvel[..., channel.dof] * self.step
        q0, q1, v0, v1 = (_gather(q, k), _gather(q, k + 1), _gather(v, k), _gather(v, k + 1))
        jump = q1 - q0
        return q0 + f * (v0 + f * (3 * jump - 2 * v0 - v1 + f * (v0 + v1 - 2 * jump)))

    def _linear(self, values: Array, time: Array) -> Array:
        k, f = self._cell(time, values.shape[2])
        low, high = _gather(values, k), _gather(values, k + 1)
        return low + f[..., None] * (high - low)

    def _cell(self, time: Array, points: int) -> tuple[Index, Array]:
        position = time / self.step
        k = np.clip(np.floor(position), 0, points - 2).astype(np.intp)
        return k, np.clip(position - k, 0.0, 1.0)


def residual(channel: Channel, simulated: Array, measured: Array) -> Array:
    """Measured − simulated, in the channel's unit; for orientations the rotation vector of sim⁻¹ · meas in rad.

    Args:
        channel: the channel.
        simulated: shape (c, w, m, raw size).
        measured: shape (w, m, raw size).

    Returns:
        Residuals, shape (c, w, m, channel.size).
    """
    if channel.kind != "orientation":
        return measured - simulated
    sim = Rotation.from_quat(simulated.reshape(-1, 4), scalar_first=True)
    meas = Rotation.from_quat(np.broadcast_to(measured, simulated.shape).reshape(-1, 4), scalar_first=True)
    return (sim.inv() * meas).as_rotvec().reshape(*simulated.shape[:-1], 3)


def _gather(values: Array, k: Index) -> Array:
    """Pick step k[c or 1, w, m] of values (c, w, s, …)."""
    contexts, windows = values.shape[:2]
    c, w = np.arange(contexts)[:, None, None], np.arange(windows)[None, :, None]
    return values[c, w, k]
