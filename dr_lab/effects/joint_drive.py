"""What the actuators of one joint give it."""

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.activations import left_in_filters, settle_filters
from dr_lab.physics.compiled_contexts import distinct
from dr_lab.trajectory import Array

_STEP = 1e-4  # of controls, rad, m, rad/s and m/s; actuators are affine but for their limits
_LIMITS = ("actuator_ctrl", "actuator_force", "actuator_act", "jnt_actfrc", "tendon_actfrc")


@dataclass(frozen=True)
class JointDrive:
    """tau = constant + by_control · u + by_position q + by_velocity v within limits, as every memoryless actuator.

    The cogging of motors comes on top. Three things are left out:

    1. limits of voltages and activations, and those of forces where actuators act through more than joints;
    2. delays and activations other than filters' (`filtered`): a late command counts from the moment it is given;
    3. bounded forces without a command, as of friction that falls with speed: they stay with the link.

    Attributes:
        address: of the joint's position in qpos.
        dof: of the joint.
        constant: generalised force of n simulations at rest at the origin without a command, N·m or N, shape (n,).
        by_control: of each control, shape (n, nu).
        by_position: N·m/rad or N/m, shape (n,).
        by_velocity: N·m·s/rad or N·s/m, shape (n,).
        low: least force, −∞ where there is no limit, N·m or N, shape (n,).
        high: largest force, shape (n,).
        least: of each control, −∞ where there is no limit, shape (n, nu).
        largest: of each control, shape (n, nu).
        left: shares of what filters held before a step in what they give and hold then, shape (2, n, nu).
        cogging: amplitude in N·m or N, periods in 1/rad or 1/m and phase in rad of k motors, shape (3, n, k).
        at_link: generalised force by each output of an actuator, of those that stay with the link, shape (n, nout).
    """

    address: int
    dof: int
    constant: Array
    by_control: Array
    by_position: Array
    by_velocity: Array
    low: Array
    high: Array
    least: Array
    largest: Array
    left: Array
    cogging: Array
    at_link: Array

    @classmethod
    def of(cls, models: Sequence[mujoco.MjModel], joint: str) -> "JointDrive":
        """The drive of a hinge or slide joint in n models of one layout, by differences about their initial states."""
        unique, which = distinct(models)
        row, data = unique[0].joint(joint).id, mujoco.MjData(unique[0])
        lines = np.array([_line(model, data, row) for model in unique])[which]
        address, dof = int(unique[0].jnt_qposadr[row]), int(unique[0].jnt_dofadr[row])
        low, high = np.array([_limits(model, row) for model in unique])[which].T
        least, largest = np.array([_command_limits(model) for model in unique])[which].swapaxes(0, 1)
        line = lines[:, 0], lines[:, 3:], lines[:, 1], lines[:, 2]
        left = np.array([left_in_filters(model) for model in unique])[which].swapaxes(0, 1)
        cogging = np.array([_cogging(model, row) for model in unique])[which].swapaxes(0, 1)
        at_link = np.array([_at_link(model, row) for model in unique])[which]
        return cls(address, dof, *line, low, high, least, largest, left, cogging, at_link)

    def force(self, qpos: Array, qvel: Array, control: Array) -> Array:
        """Generalised force in N·m or N of n simulations, shape (n,); arguments of shape (n, nq), (n, nv), (n, nu)."""
        moving = self.by_position * qpos[:, self.address] + self.by_velocity * qvel[:, self.dof]
        asked = self.constant + np.einsum("nu,nu->n", self._taken(control), self.by_control) + moving
        found = np.minimum(np.maximum(asked, self.low), self.high) if self._limited else asked
        if self.cogging.size:
            amplitude, periods, phase = self.cogging
            found += (amplitude * np.sin(periods * qpos[:, self.address, None] + phase)).sum(axis=1)
        return found

    def _taken(self, control: Array) -> Array:
        """Controls within their limits."""
        return np.minimum(np.maximum(control, self.least), self.largest) if self._commands_limited else control

    @cached_property
    def _limited(self) -> bool:
        """Whether some force has a limit; to keep to limits takes longer than all else."""
        return bool(np.isfinite(self.low).any() or np.isfinite(self.high).any())

    @cached_property
    def _commands_limited(self) -> bool:
        """Whether some control has a limit."""
        return bool(np.isfinite(self.least).any() or np.isfinite(self.largest).any())

    @cached_property
    def filters(self) -> bool:
        """Whether some control goes through a filter."""
        return bool(self.left.any())

    def filtered(self, control: Array, held: Array, known: NDArray[np.bool_]) -> tuple[Array, Array]:
        """What filters give through a step and hold after it, shape (n, nu).

        Args:
            control: of the step, shape (n, nu).
            held: before it, shape (n, nu).
            known: in which simulations that is so; in the others they have had the control for long, shape (n,).
        """
        taken = self._taken(control)
        given, after = taken + self.left * np.where(known[:, None], held - taken, 0.0)
        return given, after

    def staying(self, outputs: Array) -> Array:
        """Generalised force that stays with the link, of all outputs of actuators (n, nout), shape (n,)."""
        return np.einsum("no,no->n", outputs, self.at_link)


def _line(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> list[float]:
    """Constant and slopes by position, velocity and each control; `data` of a model of this layout is overwritten."""
    address, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    at_link, model = _at_link(model, joint), _unlimited(model)

    def force(**changed: int) -> float:
        mujoco.mj_resetData(model, data)
        for field, entry in changed.items():
            getattr(data, field)[entry] += _STEP
        _hold_commands(model, data)
        mujoco.mj_forward(model, data)
        return float(data.qfrc_actuator[dof] - data.actuator_force @ at_link)

    still = force()
    slopes = [(force(**{field: entry}) - still) / _STEP for field, entry in (("qpos", address), ("qvel", dof))]
    by_control = [(force(ctrl=column) - still) / _STEP for column in range(model.nu)]
    return [still - slopes[0] * float(model.qpos0[address]), *slopes, *by_control]


def _unlimited(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model whose actuators give what they are asked for, without cogging: so all that they give is a line."""
    found = copy.copy(model)
    found.actuator_biasprm[_cogs(model), 0] = 0.0
    for name in _LIMITS:
        getattr(found, f"{name}limited")[:] = False
    return found


def _command_limits(model: mujoco.MjModel) -> Array:
    """Least and largest of each control, shape (2, nu)."""
    return np.where(model.actuator_ctrllimited, model.actuator_ctrlrange.T, [[-np.inf], [np.inf]])


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    """Least and largest force that the actuators give the joint together: of each of them, and of the joint."""
    least, largest = model.jnt_actfrcrange[joint] if model.jnt_actfrclimited[joint] else (-np.inf, np.inf)
    if (model.actuator_trntype != int(mujoco.mjtTrn.mjTRN_JOINT)).any():
        return float(least), float(largest)
    beside = _bounded(model, joint) | (_cogs(model) & (model.actuator_ctrlnum == 0))
    straight = np.flatnonzero(_at(model, joint) & ~beside)
    ends = np.sort(model.actuator_forcerange[straight] * model.actuator_gear[straight, :1], axis=1)
    ends = np.where(model.actuator_forcelimited[straight, None].astype(bool), ends, [-np.inf, np.inf])
    low, high = np.clip(ends.sum(axis=0), least, largest)
    return float(low), float(high)


def _at(model: mujoco.MjModel, joint: int) -> NDArray[np.bool_]:
    """Which actuators act at the joint."""
    return (model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)) & (model.actuator_trnid[:, 0] == joint)


def _bounded(model: mujoco.MjModel, joint: int) -> NDArray[np.bool_]:
    """Which actuators at the joint take no command and have a bounded force."""
    return _at(model, joint) & (model.actuator_ctrlnum == 0) & model.actuator_forcelimited


def _cogs(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Which actuators may cog."""
    return model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_DCMOTOR)


def _cogging(model: mujoco.MjModel, joint: int) -> Array:
    """Amplitude, periods and phase of the motors at the joint that may cog, shape (3, k)."""
    motors = np.flatnonzero(_at(model, joint) & _cogs(model) & ~_bounded(model, joint))
    amplitude, periods, phase = model.actuator_biasprm[motors, :3].T
    gear = model.actuator_gear[motors, 0]
    return np.stack([gear * amplitude, gear * periods, phase])


def _at_link(model: mujoco.MjModel, joint: int) -> Array:
    """What a unit of each actuator's output gives the joint where it is bounded without a command, shape (nout,)."""
    bounded, found = _bounded(model, joint), np.zeros(model.nout)
    found[model.actuator_outadr[bounded]] = model.actuator_gear[bounded, 0]
    return found


def passive(model: mujoco.MjModel, joint: int) -> Array:
    """What a unit of each actuator's output gives the joint where it takes no command and does not cog, (nout,)."""
    which, found = _at(model, joint) & (model.actuator_ctrlnum == 0) & ~_cogs(model), np.zeros(model.nout)
    found[model.actuator_outadr[which]] = model.actuator_gear[which, 0]
    return found


def _hold_commands(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Let actuators that remember commands have had the present ones all along."""
    for actuator in np.flatnonzero(model.actuator_history[:, 0]):
        samples = int(model.actuator_history[actuator, 0])
        times = np.arange(-samples, 0) * model.opt.timestep
        values = np.full(samples, data.ctrl[model.actuator_ctrladr[actuator]])
        mujoco.mj_initCtrlHistory(model, data, int(actuator), times, values)
    settle_filters(model, data)
