"""Which masses and dampings are free, and between which bounds."""

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.physics.inertial import KEY
from dr_lab.physics.model import from_spec
from dr_lab.physics.target import Target
from dr_lab.proposal.armatures import armatures
from dr_lab.proposal.drives import Command
from dr_lab.proposal.output import Positions
from dr_lab.proposal.robot import Robot
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.shown import shown
from dr_lab.proposal.unscaled import Unscaled, beside_hinge, unscaled

Entry = dict[str, str | float] | list[str]  # of a parameter; or the bodies whose inertia is free

_WIDER = 4.0  # times the documented damping, at least
_QUICK = 10.0  # 1/s; a damping that stops a joint in a tenth of a second, where no motion tells more
_COORDINATE = 9  # digits of a bound that counts from a frame's origin, which may lie far from the hinge
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


def free_parameters(
    robot: Robot, spec: mujoco.MjSpec, found: Positions, commands: Sequence[Command], settings: ProposalSettings
) -> Freedom:
    """Masses of the bodies that move by a joint of their own, inertias of free ones, and dampings of the joints.

    A mass stays as documented where the motion hardly shows it, or where other parameters do what it does. Of bodies
    that no known force drives, the heaviest keeps its mass, and what sets the period may be free: centres of mass and
    inertias. Where a command's gain is off beside a mass that is hardly seen, its joint's armature is free. Of a free
    body that is driven, and carries nothing, all ten inertial parameters are free.

    Args:
        robot: as described.
        spec: with the actuators that were added; it is not changed.
        found: what is known of the motion.
        commands: what drives the robot.
        settings: bounds and thresholds.
    """
    model = from_spec(robot.name, spec, {}).nominal()
    masses, loose = _masses(model, settings), _loose(model)
    inertias = {f"{name}.inertia_scale": _inertia(name, settings) for name in loose if f"{name}.mass" in masses}
    if len(masses) == len(inertias) == 1:
        return Freedom({KEY: loose} if model.nu else inertias, ())
    joints = (model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in _SCALAR)
    dampings = {f"{joint}.damping": _damping(model, spec, joint, found) for joint in joints}
    undriven = unscaled(from_spec(robot.name, spec, masses), found, commands, settings)
    kept = {name: entry for name, entry in masses.items() if name not in {each.mass for each in undriven}}
    if found.trial is None or found.found is None:
        centres = _centres(model, [each.heaviest for each in undriven], settings)
        return Freedom(kept | centres | inertias | dampings, tuple(_anchored(undriven, centres)))
    bodies = [body for each in undriven for body in each.bodies]
    others = _centres(model, bodies, settings) | {f"{b}.inertia_scale": _inertia(b, settings) for b in bodies}
    most = [(each, each.most(from_spec(robot.name, spec, masses | others))) for each in undriven]
    motion = shown(from_spec(robot.name, spec, kept | others), found, most, settings)
    free = {name: entry for name, entry in (kept | others).items() if name in motion.seen}
    kept_back = {*motion.faint, *(each.mass for each in undriven)}
    rotors = [*armatures(model, _as_documented(kept_back, free), found, commands, settings)]
    driven = {each.body for each in rotors}
    anchored = _anchored([each for each in undriven if not driven & {*each.bodies}], free)
    inertial = {f"{each.joint}.armature": each.entry for each in rotors}
    return Freedom(free | inertial | dampings, (*motion.notes, *(each.note for each in rotors), *anchored))


def _as_documented(kept_back: Set[str], free: Mapping[str, Entry]) -> set[str]:
    """Bodies whose mass is kept back, and whose inertia is not free either."""
    bodies = {name.removesuffix(".mass") for name in kept_back if name.endswith(".mass")}
    return {body for body in bodies if f"{body}.inertia_scale" not in free}


def _masses(model: mujoco.MjModel, settings: ProposalSettings) -> dict[str, Entry]:
    """Masses of the bodies that move by a joint of their own."""
    names = (model.body(i).name for i in range(1, model.nbody) if model.body_dofnum[i] > 0)
    known = {name: float(model.body(name).mass[0]) for name in names}
    return {f"{name}.mass": _mass(name, mass, settings) for name, mass in known.items() if mass > mujoco.mjMINVAL}


def _loose(model: mujoco.MjModel) -> list[str]:
    """Bodies on free joints."""
    free = (i for i in range(model.njnt) if int(model.jnt_type[i]) == int(mujoco.mjtJoint.mjJNT_FREE))
    return [model.body(int(model.jnt_bodyid[i])).name for i in free]


def _anchored(undriven: Sequence[Unscaled], free: Mapping[str, Entry]) -> Iterator[str]:
    """Which mass gives other forces their scale, and what is free in its place."""
    for each in undriven:
        place = [name for name in free if name.rsplit(".", 1)[0] in each.bodies]
        instead = f" Free in its place is what sets the period: {', '.join(place)}." if place else ""
        yield (
            f"{each.mass} stays as documented. No known force drives {', '.join(each.bodies)}, and one factor on all "
            f"masses and dampings leaves such a motion as it is.{instead}"
        )


def _centres(model: mujoco.MjModel, bodies: Sequence[str], settings: ProposalSettings) -> dict[str, Entry]:
    """How far centres of mass lie from the axes of their bodies' hinges, along the bodies' own axes."""
    found: dict[str, Entry] = {}
    for body in bodies:
        offset = beside_hinge(model, body)
        axis = int(np.argmax(np.abs(offset)))
        if offset[axis] == 0.0:
            continue
        start = float(model.body(body).ipos[axis] - offset[axis])
        ends = (_rounded(float(offset[axis]) * factor) for factor in (1 / settings.spread, settings.spread))
        low, high = sorted(float(f"{start + end:.{_COORDINATE}g}") for end in ends)
        found[f"{body}.com"] = {"target": f"body.{body}.ipos[{axis}]", "unit": "m", "low": low, "high": high}
    return found


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
    """From none to a damping that takes all the force of the joint's motion at its usual speed.

    A servo of the model gives more than that where friction takes it, so that a damping which stops the joint quickly
    is within the bounds, too.
    """
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
        force, speed = (float(np.sqrt((part[:, dof] ** 2).mean())) for part in (outcome.whole, outcome.speed))
        taken = force / speed if speed > 0 and force > 0 else high
        servo = bool((outcome.whole[:, dof] != outcome.need[:, dof]).any())
        high = max(taken, high) if servo else taken
    unit = "N·s/m" if int(row.type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE) else "N·m·s/rad"
    return {"target": target, "unit": unit, "low": 0.0, "high": _rounded(max(high, _WIDER * nominal))}


def _rounded(value: float) -> float:
    """Two digits."""
    return float(f"{value:.2g}") if math.isfinite(value) else value
