"""Typical magnitudes of a machine in its logs; they size the bounds of effects."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.diagnosis.windows.channels import Channel, available
from dr_lab.diagnosis.windows.commands import actuator_columns
from dr_lab.effects.effect import Scales
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.physics.activations import settle_filters
from dr_lab.trajectory import Array, Log

_SAMPLES_PER_LOG = 200
_FAST = 95.0  # percentile that stands for a joint's speed
_RESTING = 1e-9  # rad/s or m/s; rounding


def machine_scales(model: mujoco.MjModel, logs: Sequence[Log], smoother: float) -> Scales:
    """Ranges, speeds and generalised forces of the measured motion.

    A joint's force scale is the larger of two root mean squares at the smoothed states:

    1. sqrt(mean (M q̈)² + mean bias²), the bias holding gravity and Coriolis forces, which does not vanish on
       unactuated joints;
    2. what the actuators give by the logged commands. A light joint that moves slowly against what the model lacks, or
       a wheel on the ground, is as strong as its motor, of which its own inertia tells nothing.

    Joints without a channel rest at the model's reference.

    Args:
        model: compiled nominal model.
        logs: logs to look at.
        smoother: half-width of the smoother, s.
    """
    states = [(*_states(model, log, smoother), _controls(model, log)) for log in logs]
    qpos, qvel, qacc, controls = (np.concatenate([s[i] for s in states]) for i in range(4))
    measured = {name for log in logs for name in log.outputs}
    unmeasured = frozenset(joint for joint, c in _joints(model).items() if c.name not in measured)
    names = {model.actuator(row).name for row in range(model.nactuator)}
    return replace(
        _scales(model, (qpos, qvel, qacc), controls),
        command=_commands(model, logs),
        uncommanded=frozenset(names - {name for log in logs for name in log.commands}),
        unmeasured=unmeasured,
    )


def with_replay(found: Scales, replay: Replay, fit: StateFit) -> Scales:
    """The scales with those of the joints that no channel measures, from how the nominal model moves in the logs.

    Where the velocity alone is measured, the range alone is the model's.

    Args:
        found: scales of the measured motion.
        replay: windows of the logs under the model.
        fit: start states at the nominal context, which the measured channels tell.
    """
    seen = {samples.channel.name for samples in replay.windows.samples}
    blind = [joint for joint in found.unmeasured if f"{joint}.velocity" not in seen]
    if fit.infeasible.all():
        return replace(found, unknown=found.unmeasured)
    states, controls = _replayed(replay, fit)
    own = _scales(replay.compiled, states, controls)
    return replace(
        found,
        lowest={**found.lowest, **{joint: own.lowest[joint] for joint in found.unmeasured}},
        highest={**found.highest, **{joint: own.highest[joint] for joint in found.unmeasured}},
        speed={**found.speed, **{joint: own.speed[joint] for joint in blind}},
        torque={**found.torque, **{joint: own.torque[joint] for joint in blind}},
        unknown=frozenset(joint for joint in blind if own.speed[joint] < _RESTING),
    )


def _joints(model: mujoco.MjModel) -> dict[str, Channel]:
    """Position channel of every hinge and slide joint."""
    positions = (c for c in available(model).values() if c.kind == "position")
    return {c.name.removesuffix(".position"): c for c in positions}


def _scales(model: mujoco.MjModel, states: tuple[Array, Array, Array], controls: Array) -> Scales:
    """Scales of states (k, nq), (k, nv), (k, nv) under controls (k, nu), without those of commands."""
    joints, (qpos, qvel, _) = _joints(model), states
    force = np.maximum(_forces(model, *states), _driven(model, qpos, qvel, controls))
    return Scales(
        lowest={n: float(qpos[:, c.address].min()) for n, c in joints.items()},
        highest={n: float(qpos[:, c.address].max()) for n, c in joints.items()},
        speed={n: float(np.percentile(np.abs(qvel[:, c.dof]), _FAST)) for n, c in joints.items()},
        torque={n: float(force[c.dof]) for n, c in joints.items()},
        command={},
    )


def _replayed(replay: Replay, fit: StateFit) -> tuple[tuple[Array, Array, Array], Array]:
    """Positions, velocities and accelerations, and controls, at evenly spread steps of windows that do not diverge."""
    tape, _ = replay.simulate(fit.z[None], fit.delta[None])
    qpos, qvel, controls = (rows[0][~fit.infeasible] for rows in (tape.qpos, tape.qvel, tape.controls))
    qacc = np.diff(qvel, axis=1) / tape.step
    count = qacc.shape[0] * qacc.shape[1]
    rows = [rows.reshape(count, rows.shape[2]) for rows in (qpos[:, :-1], qvel[:, :-1], qacc, controls)]
    most = _SAMPLES_PER_LOG * len(replay.windows.logs)
    pick = spread(count, most)
    qpos, qvel, qacc, controls = (each[pick] for each in rows)
    return (qpos, qvel, qacc), controls


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


def _controls(model: mujoco.MjModel, log: Log) -> Array:
    """What was sent last, at evenly spread times of a log, shape (k, nu); 0 where nothing was."""
    first = next(iter(log.outputs.values())).time
    times = np.linspace(first[0], first[-1], _SAMPLES_PER_LOG + 2)[1:-1]
    controls = np.zeros((_SAMPLES_PER_LOG, model.nu))
    for name, column in actuator_columns(model, [log]).items():
        sent = log.commands[name]
        controls[:, column] = sent.value[np.maximum(np.searchsorted(sent.time, times, side="right") - 1, 0)]
    return controls


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


def _driven(model: mujoco.MjModel, qpos: Array, qvel: Array, controls: Array) -> Array:
    """Root mean square of the actuators' forces by degree of freedom, shape (nv,); filters have settled."""
    data, total = mujoco.MjData(model), np.zeros(model.nv)
    for q, v, u in zip(qpos, qvel, controls, strict=True):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
        settle_filters(model, data)
        mujoco.mj_forward(model, data)
        total += data.qfrc_actuator**2
    return np.sqrt(total / max(len(qpos), 1))


def _commands(model: mujoco.MjModel, logs: Sequence[Log]) -> dict[str, float]:
    names = [model.actuator(i).name for i in range(model.nactuator)]
    return {
        n: max((float(np.abs(log.commands[n].value).max()) for log in logs if n in log.commands), default=0.0)
        for n in names
    }
