"""The equation of motion tested on measured motion: what force it asks for, what the actuators gave, in weak form.

For any twice differentiable motion and test function φ the model demands, at each degree of freedom,

    ∫ φ (M(q) q'' + c(q, q') − f_passive − f_constraint) dt  =  ∫ φ f_actuator dt  +  ∫ φ f_missing dt.

Every force is one array over the grid of a `Motion`; `Weak.project` turns it into generalised impulses, one a test
function, so that effects which are linear in their parameters become columns of one regression, and a changed
parameter a difference of two models' demands. No model is simulated.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.smoothed_motion import EquationErrorSettings, Index, Mask, Motion
from dr_lab.physics.activations import resting
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Demand:
    """Generalised force that a model needs beside its passive and constraint forces to move as measured.

    Attributes:
        force: N·m or N, shape (n, nv).
        gravity: share of it that holds the machine against gravity, shape (n, nv).
        inertia: share of it that accelerates the machine, M(q) q'', shape (n, nv).
        touching: times at which the model makes contact, shape (n,).
    """

    force: Array
    gravity: Array
    inertia: Array
    touching: Mask


@dataclass(frozen=True)
class Actuation:
    """Generalised force of the actuators at the measured motion.

    Attributes:
        idle: what all of them do at control 0 (back-EMF, the pull of a position servo towards 0), shape (n, nv).
        driven: what each adds by its control, shape (n, actuators, nv).
    """

    idle: Array
    driven: Array

    @property
    def force(self) -> Array:
        """The whole, shape (n, nv)."""
        return self.idle + self.driven.sum(1)


@dataclass(frozen=True)
class Weak:
    """w test functions φ of ∫ φ dt = 1 on the grid of a motion, so that impulses read as mean forces.

    Attributes:
        log: log of each test function, shape (w,).
        time: its middle on the log's clock in s, shape (w,).
        index: the grid's times on which it lives, shape (w, m).
        weight: its value times the grid's step, shape (m,).
    """

    log: Index
    time: Array
    index: Index
    weight: Array

    def __len__(self) -> int:
        """Number of test functions."""
        return len(self.time)

    def project(self, values: Array) -> Array:
        """∫ φ f dt of values over the grid, shape (n, …) → (w, …)."""
        return np.tensordot(values[self.index], self.weight, axes=(1, 0))


def demand(model: mujoco.MjModel, motion: Motion) -> Demand:
    """Inverse dynamics of a compiled model at every time of a motion (`mj_inverse`)."""
    data, touching = mujoco.MjData(model), np.zeros(len(motion), bool)
    qpos, qvel, qacc, found = data.qpos, data.qvel, data.qacc, data.qfrc_inverse  # a look-up takes long
    force, gravity, inertia = np.zeros((3, len(motion), model.nv))
    rows = zip(motion.qpos, motion.qvel, motion.qacc, force, gravity, inertia, strict=True)
    for k, (place, speed, change, needed, weight, inert) in enumerate(rows):
        qpos[:], qvel[:], qacc[:] = place, speed, change
        mujoco.mj_inverse(model, data)
        needed[:], touching[k] = found, data.ncon > 0
        mujoco.mj_mulM(model, data, inert, change)
        qvel[:] = 0.0
        mujoco.mj_comVel(model, data)  # gravity is what the same place asks for at rest
        mujoco.mj_rne(model, data, 0, weight)
    return Demand(force, gravity, inertia, touching)


def actuation(model: mujoco.MjModel, motion: Motion, controls: Array) -> Actuation:
    """Forces of a compiled model's actuators at every time of a motion, its limits and activations included.

    Args:
        model: the model.
        motion: measured motion.
        controls: shape (n, nu); see `dr_lab.diagnosis.faults.smoothed_motion.controls_at`.
    """
    idle, driven = _actuator_forces(model, motion, (np.zeros_like(controls), controls))
    return Actuation(idle.sum(1), driven - idle)


def weak_form(motion: Motion, settings: EquationErrorSettings, blocked: Mask | None = None) -> Weak:
    """Test functions φ ∝ (1 − x²)³ every `hop` s, each within one log, away from gaps and from blocked times.

    Args:
        motion: gives the grid.
        settings: widths.
        blocked: times that no test function may reach, shape (n,), e.g. those in contact.
    """
    half = max(round(settings.half_width / motion.step), 1)
    hop = max(round(settings.hop / motion.step), 1)
    x = np.arange(-half, half + 1) / (half + 1)
    shape = (1 - x**2) ** 3
    starts = [
        rows[0] + np.arange(0, len(rows) - 2 * half, hop) for rows in map(np.flatnonzero, _by_log(motion)) if len(rows)
    ]
    index = np.concatenate(starts)[:, None] + np.arange(2 * half + 1) if starts else np.zeros((0, 2 * half + 1), int)
    free = motion.known if blocked is None else motion.known & ~blocked
    index = index[free[index].all(1)]
    middle = index[:, half]
    return Weak(motion.log[middle], motion.time[middle], index, shape / shape.sum())


def parameter_columns(
    compile_at: Callable[[Array], mujoco.MjModel], nominal: Array, steps: Array, motion: Motion, controls: Array
) -> Array:
    """Change of (demand − actuation) by a step of each parameter, over that step, shape (n, nv, parameters).

    Args:
        compile_at: a model's `compile`.
        nominal: context at which the forces are linearised, shape (p,).
        steps: of each parameter, in its unit, shape (p,); not 0.
        motion: measured motion.
        controls: shape (n, nu).

    Raises:
        ModelError: a context does not compile.
    """
    base = compile_at(nominal)
    before = demand(base, motion).force - actuation(base, motion, controls).force
    columns = []
    for k, step in enumerate(steps):
        z = nominal.copy()
        z[k] += step
        changed = compile_at(z)
        columns.append((demand(changed, motion).force - actuation(changed, motion, controls).force - before) / step)
    return np.stack(columns, axis=-1) if columns else np.zeros((*before.shape, 0))


def _by_log(motion: Motion) -> list[Mask]:
    return [motion.log == k for k in range(int(motion.log.max(initial=-1)) + 1)]


def _actuator_forces(model: mujoco.MjModel, motion: Motion, several: Sequence[Array]) -> Array:
    """Generalised force of each actuator under each of several controls, shape (several, n, actuators, nv).

    Activations begin every log at rest.
    """
    model, count = _undelayed(model), len(motion)
    moments, forces = np.zeros((count, model.nactuator, model.nv)), np.zeros((len(several), count, model.nactuator))
    if not model.nactuator:
        return forces[..., None] * moments
    data, activations = mujoco.MjData(model), np.zeros((len(several), model.na))
    ctrl, act, slope, strength = data.ctrl, data.act, data.act_dot, data.actuator_force  # a look-up takes long
    substeps = int(np.ceil(motion.step / model.opt.timestep)) if model.na else 0
    first = np.diff(motion.log, prepend=-1) != 0
    for k, moment in enumerate(moments):
        if first[k]:
            mujoco.mj_resetData(model, data)
            activations[:] = [resting(model, motion.qpos[k : k + 1], controls[k : k + 1])[0] for controls in several]
        data.qpos[:], data.qvel[:] = motion.qpos[k], motion.qvel[k]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mju_sparse2dense(
            moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
        )
        for force, controls, activation in zip(forces, several, activations, strict=True):
            ctrl[:], act[:] = controls[k], activation
            for _ in range(substeps):
                mujoco.mj_fwdActuation(model, data)
                act[:] += motion.step / substeps * slope
            mujoco.mj_fwdActuation(model, data)
            activation[:], force[k] = act, strength
    return forces[..., None] * moments


def _undelayed(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model, whose controls act at once: `controls_at` has delayed them."""
    if not model.actuator_delay.any():
        return model
    prompt = copy.deepcopy(model)
    prompt.actuator_delay[:] = 0.0
    return prompt
