"""Typical magnitudes of a machine in its logs; they size the bounds of effects."""

from collections.abc import Sequence

import mujoco
import numpy as np

from dr_lab.diagnosis.channels import available
from dr_lab.effects.effect import Scales
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.trajectory import Array, Log

_SAMPLES_PER_LOG = 200
_FAST = 95.0  # percentile that stands for a joint's speed


def machine_scales(model: mujoco.MjModel, logs: Sequence[Log], smoother: float) -> Scales:
    """Ranges, speeds and generalised forces of the measured motion.

    A joint's force scale is sqrt(mean (M q̈)² + mean bias²) at the smoothed states, the bias holding gravity and
    Coriolis forces; it does not vanish on unactuated joints.

    Args:
        model: compiled nominal model.
        logs: logs to look at.
        smoother: half-width of the smoother, s.
    """
    states = [_states(model, log, smoother) for log in logs]
    qpos, qvel, qacc = (np.concatenate([s[i] for s in states]) for i in range(3))
    force = _forces(model, qpos, qvel, qacc)
    joints = [c for c in available(model).values() if c.kind == "position"]
    names = [c.name.removesuffix(".position") for c in joints]
    return Scales(
        lowest={n: float(qpos[:, c.address].min()) for n, c in zip(names, joints, strict=True)},
        highest={n: float(qpos[:, c.address].max()) for n, c in zip(names, joints, strict=True)},
        speed={n: float(np.percentile(np.abs(qvel[:, c.dof]), _FAST)) for n, c in zip(names, joints, strict=True)},
        torque={n: float(force[c.dof]) for n, c in zip(names, joints, strict=True)},
        command=_commands(model, logs),
    )


def _states(model: mujoco.MjModel, log: Log, smoother: float) -> tuple[Array, Array, Array]:
    """Smoothed positions, velocities and accelerations at evenly spread times of a log."""
    qpos = np.tile(model.qpos0, (_SAMPLES_PER_LOG, 1))
    qvel, qacc = np.zeros((2, _SAMPLES_PER_LOG, model.nv))
    for name, signal in log.outputs.items():
        channel = available(model)[name]
        alone = channel.kind == "velocity" and name.removesuffix("velocity") + "position" not in log.outputs
        if channel.kind == "position" or alone:
            times = np.linspace(signal.time[0], signal.time[-1], _SAMPLES_PER_LOG + 2)[1:-1]
            motion = local_polynomial(signal, times, smoother)
            if alone:
                qvel[:, channel.dof], qacc[:, channel.dof] = motion[:2]
            else:
                qpos[:, channel.address], qvel[:, channel.dof], qacc[:, channel.dof] = motion[:3]
    return qpos, qvel, qacc


def _forces(model: mujoco.MjModel, qpos: Array, qvel: Array, qacc: Array) -> Array:
    """Root mean square of inertial and bias forces by degree of freedom, shape (nv,)."""
    data, total, product = mujoco.MjData(model), np.zeros(model.nv), np.zeros(model.nv)
    for q, v, a in zip(qpos, qvel, qacc, strict=True):
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_mulM(model, data, product, a)
        total += product**2 + data.qfrc_bias**2
    return np.sqrt(total / len(qpos))


def _commands(model: mujoco.MjModel, logs: Sequence[Log]) -> dict[str, float]:
    names = [model.actuator(i).name for i in range(model.nactuator)]
    return {
        n: max((float(np.abs(log.commands[n].value).max()) for log in logs if n in log.commands), default=0.0)
        for n in names
    }
