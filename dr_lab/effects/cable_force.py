"""A cable, hose or tether that pulls a link towards a fixed point."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.bare_tendon import add_bare_tendon
from dr_lab.effects.body_effect import body_of, moving_bodies
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.generalised_forces import pulls
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_AXES: tuple[str, ...] = ("x", "y", "z")
_NAMES = tuple(f"anchor_{axis}" for axis in _AXES)


@dataclass(frozen=True)
class CableForce(Effect, SpecPreparation, SpecEdit):
    """An elastic cable between a point of the world and a link, such as a hose, a dress pack or a balancer's rope.

    It pulls the link's centre of mass p, where the model file has it, towards its anchor a, and slackens where it is
    shorter than its length L: F = k max(0, |a − p| − L) (a − p) / |a − p|. It is MuJoCo's spatial tendon
    ``cable_force@<body>`` with springlength (0, L). With L = 0 it is a spring, F = k (a − p), linear in k and k a.

    Parameters (nominal = absent): stiffness k ≥ 0 [N/m]; anchor_x, anchor_y, anchor_z [m] in the world, and length
    L ≥ 0 [m], which act only where k > 0 (fits start away from absent, with a cable that is never slack). The anchor
    lies in the plane of a planar machine: it has no coordinate along an axis in which no pull moves a joint.
    Limits: bodies that a hinge turns; to one that only slides it is a spring. The cable has no mass and no friction,
    and touches nothing.
    Source: Hooke's law; MuJoCo 4.0, XML reference, tendon/spatial/springlength.

    Attributes:
        factor: largest k, in units of the largest torque of a joint before the body over the reach squared (of a
            slide's force over the reach).
        least: smallest upper bound of k, for joints that hardly move [N/m].
        around: how far the anchor may lie from the centre in the reference pose along each axis, in reaches.
        start: k of the fits that start away from absent, share of its upper bound.
        start_anchors: anchors of these fits, from the centre in the reference pose, in reaches.
        sensitive: a direction counts as felt above this share of the force of an equal pull in the worst direction,
            and of its torque at a lever of the model's size.
        poses: number of states in which that is looked for.
    """

    factor: float
    least: float
    around: float
    start: float
    start_anchors: tuple[tuple[float, float, float], ...]
    sensitive: float
    poses: int

    name: ClassVar[str] = "cable_force"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "F = k max(0, |a - p| - L) (a - p) / |a - p|"
    fingerprint: ClassVar[str] = (
        "force residual at several joints at once, towards one point, perhaps in some poses alone"
    )
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "constant_offset", "payload", "base_tilt", "end_stop")
    shapes: ClassVar[tuple[str, ...]] = (*_NAMES, "length")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the moving bodies with mass that a hinge turns, and at whose centre a pull moves a joint."""
        turned = (b for b in moving_bodies(model) if any(kind == _HINGE for _, kind in _joints(model, b)))
        return tuple(body for body in turned if self._felt(model, body))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Stiffness, anchor and length."""
        reach, centre = _reach(model, site), dict(zip(_AXES, _centre(model, site).tolist(), strict=True))
        largest = max(
            scales.torque.get(model.joint(joint).name, 0.0) / (reach if kind == _SLIDE else reach**2)
            for joint, kind in _joints(model, site)
        )
        far = self.around * reach
        return (
            Parameter("stiffness", "N/m", 0.0, 0.0, max(self.factor * largest, self.least)),
            *(
                Parameter(f"anchor_{axis}", "m", centre[axis], centre[axis] - far, centre[axis] + far)
                for axis in self._felt(model, site)
            ),
            Parameter("length", "m", 0.0, 0.0, far),
        )

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Add the cable without stiffness."""
        compiled, label = spec.copy().compile(), f"{self.name}@{site}"
        body_of(spec, site).add_site(name=f"{label}.end", pos=compiled.body(site).ipos)
        spec.worldbody.add_site(name=f"{label}.anchor", pos=_centre(compiled, site))
        tendon = add_bare_tendon(spec, label)
        tendon.wrap_site(f"{label}.anchor")
        tendon.wrap_site(f"{label}.end")

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Write its numbers."""
        label = f"{self.name}@{site}"
        tendon = spec.tendon(label)
        tendon.stiffness, tendon.springlength = [values["stiffness"], 0.0, 0.0], [0.0, values["length"]]
        anchor = spec.site(f"{label}.anchor")
        anchor.pos = [values.get(f"anchor_{axis}", own) for axis, own in zip(_AXES, anchor.pos, strict=True)]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A light spring towards several anchors: from each one linear step leads to any other."""
        stiffness, *anchor, _ = parameters
        light = {"stiffness": self.start * stiffness.high}
        shares = [
            dict(zip(_NAMES, (np.asarray(row) / self.around).tolist(), strict=True)) for row in self.start_anchors
        ]
        placed = [{p.name: p.nominal + row[p.name] * p.span / 2 for p in anchor} for row in shares]
        return tuple(light | row for k, row in enumerate(placed) if row not in placed[:k])

    def _felt(self, model: mujoco.MjModel, site: str) -> tuple[str, ...]:
        """Axes along which a pull at the centre moves a joint in some pose; none where it lies on all hinges' axes."""
        force = np.abs(pulls(model, model.body(site).id, self.poses)).max(axis=(0, 2))
        least = self.sensitive * max(float(force.max()), model.stat.extent)
        return tuple(axis for axis, each in zip(_AXES, force, strict=True) if each > least)


def _joints(model: mujoco.MjModel, body: str) -> Iterator[tuple[int, int]]:
    """Hinges and slides between a body and the world, with their kinds."""
    place = model.body(body).id
    while place:
        first = int(model.body_jntadr[place])
        for joint in range(first, first + int(model.body_jntnum[place])):
            if int(model.jnt_type[joint]) in (_HINGE, _SLIDE):
                yield joint, int(model.jnt_type[joint])
        place = int(model.body_parentid[place])


def _reach(model: mujoco.MjModel, body: str) -> float:
    """Length of the chain from the first body that moves to a body's centre of mass, m."""
    place = model.body(body).id
    length = float(np.linalg.norm(model.body_ipos[place]))
    while model.body_weldid[model.body_parentid[place]]:
        length += float(np.linalg.norm(model.body_pos[place]))
        place = int(model.body_parentid[place])
    return length or float(model.stat.extent)


def _centre(model: mujoco.MjModel, body: str) -> Array:
    """A body's centre of mass in the reference pose, in the world, shape (3,)."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data.xipos[model.body(body).id].copy()
