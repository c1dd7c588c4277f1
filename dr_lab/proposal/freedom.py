"""Which masses and dampings are free, and between which bounds."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.equation_error import parameter_columns
from dr_lab.physics.inertial import KEY
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.target import Target
from dr_lab.proposal.output import Positions
from dr_lab.proposal.positions import unhindered
from dr_lab.proposal.robot import Robot
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.trajectory import Array

Entry = dict[str, str | float] | list[str]  # of a parameter; or the bodies whose inertia is free

_STEP = 0.01  # share of a mass, for its influence
_WIDER = 4.0  # times the documented damping, at least
_QUICK = 10.0  # 1/s; a damping that stops a joint in a tenth of a second, where no motion tells more
_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


@dataclass(frozen=True)
class Freedom:
    """What of a model's physics may be wrong.

    Attributes:
        parameters: as a model's yaml declares them.
        notes: what stays as documented, and why.
    """

    parameters: Mapping[str, Entry]
    notes: tuple[str, ...]


def free_parameters(robot: Robot, spec: mujoco.MjSpec, found: Positions, settings: ProposalSettings) -> Freedom:
    """Masses of the bodies that move by a joint of their own, inertias of free ones, and dampings of the joints.

    A mass stays as documented where the motion hardly shows it, or where other parameters do what it does. That of a
    free body that nothing drives cancels. Of one that is driven, and carries nothing, all ten inertial parameters are
    free.

    Args:
        robot: as described.
        spec: with the actuators that were added; it is not changed.
        found: what is known of the motion.
        settings: bounds and thresholds.
    """
    model = from_spec(robot.name, spec, {}).nominal()
    masses = {
        f"{name}.mass": _mass(name, float(model.body(name).mass[0]), settings)
        for name in (model.body(i).name for i in range(1, model.nbody) if model.body_dofnum[i] > 0)
        if model.body(name).mass[0] > mujoco.mjMINVAL
    }
    loose = [
        model.body(int(model.jnt_bodyid[i])).name
        for i in range(model.njnt)
        if int(model.jnt_type[i]) == int(mujoco.mjtJoint.mjJNT_FREE)
    ]
    inertias = {f"{name}.inertia_scale": _inertia(name, settings) for name in loose if f"{name}.mass" in masses}
    if len(masses) == len(inertias) == 1:
        return Freedom({KEY: loose} if model.nu else inertias, ())
    dampings = {
        f"{joint}.damping": _damping(model, spec, joint, found)
        for joint in (model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in _SCALAR)
    }
    if found.trial is None or found.found is None:
        return Freedom(masses | inertias | dampings, ())
    seen, notes = _seen(from_spec(robot.name, spec, masses), found, settings)
    return Freedom({name: entry for name, entry in masses.items() if name in seen} | dampings, notes)


def _mass(body: str, mass: float, settings: ProposalSettings) -> Entry:
    return {
        "target": f"body.{body}.mass",
        "unit": "kg",
        "low": _rounded(mass / settings.spread),
        "high": _rounded(mass * settings.spread),
    }


def _inertia(body: str, settings: ProposalSettings) -> Entry:
    target = f"body.{body}.inertia_scale"
    return {"target": target, "unit": "1", "low": _rounded(1 / settings.spread), "high": settings.spread}


def _damping(model: mujoco.MjModel, spec: mujoco.MjSpec, joint: str, found: Positions) -> Entry:
    """From none to a damping that takes all that the joint needs at its usual speed."""
    row = model.joint(joint)
    dof = int(row.dofadr[0])
    target = f"joint.{joint}.damping"
    nominal = Target.parse(target).read(spec)
    inertia = np.zeros((model.nv, model.nv))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    high = _QUICK * float(inertia[dof, dof])
    if found.found is not None:
        outcome = found.found.outcome
        need, speed = (float(np.sqrt((part[:, dof] ** 2).mean())) for part in (outcome.need, outcome.speed))
        high = need / speed if speed > 0 and need > 0 else high
    unit = "N·s/m" if int(row.type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE) else "N·m·s/rad"
    return {"target": target, "unit": unit, "low": 0.0, "high": _rounded(max(high, _WIDER * nominal))}


def _seen(model: Model, found: Positions, settings: ProposalSettings) -> tuple[set[str], tuple[str, ...]]:
    """The masses that the motion shows, each apart from the others and from what brakes."""
    assert found.trial is not None
    assert found.found is not None
    motion, weak = found.trial.motion(found.found.readings), found.trial.grid.weak
    space = model.space
    if not space.names:
        return set(), ()
    controls = np.zeros((len(motion), model.nominal().nu))
    columns = parameter_columns(
        lambda z: unhindered(model.compile(z)), space.nominal, _STEP * space.nominal, motion, controls
    )
    need = found.found.outcome.need
    size = np.sqrt((need**2).mean(0))
    size[size == 0.0] = 1.0
    moved = (weak.project(columns) * space.nominal / size[:, None]).reshape(-1, len(space.names))
    brakes = _brakes(weak.project(motion.qvel), weak.project(np.tanh(motion.qvel / _slow(motion.qvel))))
    return _chosen(space.names, moved, brakes, settings)


def _chosen(
    names: tuple[str, ...], moved: Array, brakes: Array, settings: ProposalSettings
) -> tuple[set[str], tuple[str, ...]]:
    felt = np.sqrt((moved**2).mean(0))
    basis = np.linalg.qr(brakes)[0]
    seen, weak, alike = set(), [], []
    for k in np.argsort(-felt):
        rest = moved[:, k] - basis @ (basis.T @ moved[:, k])
        if felt[k] < settings.felt:
            weak.append(names[k])
        elif np.linalg.norm(rest) < settings.distinct * np.linalg.norm(moved[:, k]):
            alike.append(names[k])
        else:
            seen.add(names[k])
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
    notes = []
    if weak:
        notes.append(f"{', '.join(weak)} stay as documented: they move less than {settings.felt:.0%} of the forces.")
    if alike:
        notes.append(
            f"{', '.join(alike)} stay as documented: in these logs the other free parameters do what they would."
        )
    return seen, tuple(notes)


def _brakes(speed: Array, direction: Array) -> Array:
    """Columns of each joint's own viscous and dry friction, rows as those of the masses."""
    count, nv = speed.shape
    columns = np.zeros((count, nv, 2 * nv))
    for j in range(nv):
        columns[:, j, j], columns[:, j, nv + j] = speed[:, j], direction[:, j]
    return columns.reshape(count * nv, 2 * nv)


def _slow(speed: Array) -> Array:
    usual = 0.05 * np.sqrt((speed**2).mean(0))
    return np.where(usual > 0, usual, 1.0)


def _rounded(value: float) -> float:
    """Two digits."""
    return float(f"{value:.2g}") if value > 0 and math.isfinite(value) else value
