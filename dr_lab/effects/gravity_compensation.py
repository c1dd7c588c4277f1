"""A controller that carries the weight of its robot."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter

_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
# MuJoCo carries only bodies that a compiled model counts; a context changes by how much. So small a share moves no bit.
_COUNTED = float(np.finfo(float).tiny)
_ROUNDING = float(np.sqrt(np.finfo(float).eps))  # of a force beside the whole weight at the model's own size


@dataclass(frozen=True)
class GravityCompensation(Effect, SpecEdit, SpecPreparation):
    """A controller that adds the torques which hold the links, and does not log them with the commands.

    τ → τ + s g(q), of the links. Controllers of cobots do so: the torques that libfranka takes, and logs as desired,
    are without gravity. A motion that gravity does not bend makes every mass look wrong. A load of which the controller
    does not know (`payload` and its kind) is not carried.

    Parameters (nominal = absent): share s of the weight, 0 = absent, 1 = all of it.
    Limits: robots that stand on the ground, of two joints or more, each with an actuator: of a pole that swings freely
    no controller can carry the weight, and of a single joint more inertia is the same where the mass is free. A weight
    that is the same in every pose, as of a vertical slide, is a `constant_offset`. Where masses are free, s is a share
    of their weight, not of what the controller takes them for. What the file compensates already stays, s being added
    to it.
    Source: MuJoCo 4.0, XML reference, body/gravcomp.

    Attributes:
        largest: largest s.
    """

    largest: float

    name: ClassVar[str] = "gravity_compensation"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau -> tau + s g(q)"
    fingerprint: ClassVar[str] = "force residual that depends on where the links point, as their weight does"
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "spring", "base_tilt", "torque_scale")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """``world``, where joints that are all driven carry a weight that depends on the pose."""
        scalar = np.isin(model.jnt_type, (_HINGE, _SLIDE))
        at_joint = model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT
        driven = np.isin(np.arange(model.njnt), model.actuator_trnid[at_joint, 0])
        return ("world",) if model.njnt > 1 and (scalar & driven).all() and _weighs(model) else ()

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The share."""
        del model, site, scales
        return (Parameter("share", "1", 0.0, 0.0, self.largest),)

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Let every body count among those that are carried."""
        del site
        for body in _links(spec):
            body.gravcomp = body.gravcomp or _COUNTED

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Carry the links."""
        del site
        for body in _links(spec):
            body.gravcomp += values["share"]


def _links(spec: mujoco.MjSpec) -> list[Any]:
    """The file's own bodies; a load is named by the label of its effect."""
    return [body for body in spec.bodies[1:] if "@" not in body.name]


def _weighs(model: mujoco.MjModel) -> bool:
    """Whether the weight that a joint carries depends on the pose."""
    data, poses = mujoco.MjData(model), np.sin(np.outer((1.0, 2.0), np.arange(1, model.nq + 1)))  # of no symmetry
    forces = np.zeros((len(poses), model.nv))
    for pose, force in zip(poses, forces, strict=True):
        data.qpos[:] = model.qpos0 + pose
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_rne(model, data, 0, force)
    whole = float(model.body_mass.sum() * np.linalg.norm(model.opt.gravity) * model.stat.extent)
    return bool(np.ptp(forces, axis=0).max(initial=0.0) > _ROUNDING * whole)
