"""A force of a joint's position, as a free curve."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.diagnosis.law_settings import LawSettings
from dr_lab.diagnosis.search.free_law import FreeLaw, curve
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FreePosition(FreeLaw, ForceLaw):
    """tau = f(q), f piecewise linear over the positions in the logs and held beyond them.

    Attributes:
        knots: of f [rad, slide: m], shape (k,).
    """

    knots: Array

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        joint = models[0].joint(site)
        heights = np.array([values[p.name] for p in self.own])
        return _Curve(int(joint.qposadr[0]), int(joint.dofadr[0]), self.knots, heights)


def free_position(joint: str, compiled: mujoco.MjModel, scales: Scales, settings: LawSettings) -> FreePosition | None:
    """The free law of a joint's position; None where it did not move, or nothing drove it.

    Args:
        joint: name of a hinge or slide joint.
        compiled: the compiled nominal model.
        scales: give place and size of the curve.
        settings: number of knots and factor on the size.
    """
    label, span = f"free_position@{joint}", scales.position.get(joint, 0.0)
    largest = settings.factor * scales.torque.get(joint, 0.0)
    if not (span > 0 and largest > 0):
        return None
    knots = scales.lowest[joint] + span * np.linspace(0, 1, 2 * settings.knots)
    unit = "N" if slides(compiled, joint) else "N·m"
    heights = tuple(Parameter(f"{label}.at_{k}", unit, 0.0, -largest, largest) for k in range(1, len(knots) + 1))
    return FreePosition(label, joint, heights, heights, knots)


@dataclass(frozen=True)
class _Curve(Law):
    """The curve's force; heights of shape (k, n)."""

    address: int
    dof: int
    knots: Array
    heights: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        influence.force[:, self.dof] += curve(moment.qpos[:, self.address], self.knots, self.heights)
