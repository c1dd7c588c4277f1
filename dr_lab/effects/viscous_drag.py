"""Drag on a body that flies or floats, proportional to its speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import body_of, moving_bodies
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.joint_effect import add_passive_force
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

_FREE = mujoco.mjtJoint.mjJNT_FREE
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class ViscousDrag(Effect, SpecEdit):
    """What slows a body that flies or floats in proportion to its speed: the drag of rotors, or of a viscous medium.

    F = −c v at the origin of the body's frame, v its velocity in the world, and T = −d w, w its angular velocity.

    Parameters (nominal = absent): translation c ≥ 0 [N·s/m], rotation d ≥ 0 [N·m·s/rad].
    Limits: bodies with a free joint; the same along and about every axis; in still air. Rotors drag along their disc
    more than along their axis.
    Source: Faessler, Franchi and Scaramuzza, RA-L 3 (2018), section III (rotor drag); Fossen, Handbook of Marine Craft
    Hydrodynamics and Motion Control (2011), chapter 6 (linear viscous damping).

    Attributes:
        fastest: time constant with which the drag alone would slow the body at the upper bounds [s].
    """

    fastest: float

    name: ClassVar[str] = "viscous_drag"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "F = -c v, T = -d w"
    fingerprint: ClassVar[str] = "force residual against the body's velocity, proportional to it, in every direction"
    confused_with: ClassVar[tuple[str, ...]] = ("air_drag",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the bodies that a free joint moves."""
        free = {int(model.jnt_bodyid[k]) for k in np.flatnonzero(model.jnt_type == int(_FREE))}
        return tuple(name for name in moving_bodies(model) if model.body(name).id in free)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The two coefficients, sized by the mass and the inertia that they slow."""
        del scales
        body = model.body(site)
        mass, inertia = float(body.subtreemass[0]), float(np.min(body.inertia))
        return (
            Parameter("translation", "N·s/m", 0.0, 0.0, mass / self.fastest),
            Parameter("rotation", "N·m·s/rad", 0.0, 0.0, inertia / self.fastest),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add a passive force along, and a passive torque about, each axis of the free joint."""
        joint = next(joint for joint in body_of(spec, site).joints if joint.type == _FREE)
        joint.name = joint.name or f"{self.name}@{site}"
        for k, name in enumerate(("translation", "rotation")):
            for axis, direction in zip(_AXES, np.eye(6)[3 * k : 3 * k + 3], strict=True):
                damper = add_passive_force(spec, joint.name, f"{self.name}@{site}.{name}.{axis}")
                damper.gear = direction
                damper.biasprm[2] = -values[name]
