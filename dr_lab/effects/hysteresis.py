"""A transmission that gives way before it slips."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.internal_state import InternalState
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Hysteresis(JointEffect, ForceLaw):
    """Elasto-plastic resistance of cables, harmonic drives and preloaded bearings: a spring that yields.

    tau = −tau_y b/x_y; the displacement b follows the joint within ±x_y: b' = v, but 0 where that would leave ±x_y.
    For x_y → 0 it is dry friction; for small motions a spring. The force of a step is that of its middle.
    Before a window's start b follows the measured motion of ``windows.memory`` seconds, from b = 0.
    MuJoCo's ``springyield`` has no such past: a window would begin at a place where the spring has not yielded yet.

    Parameters (nominal = absent): torque tau_y ≥ 0 [N·m, slide: N]; displacement x_y > 0 [rad, slide: m], which acts
    only where tau_y > 0 (fits start away from absent).
    Limits: hinge and slide joints; a stiffness tau_y/x_y that the step cannot follow diverges.
    Source: Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968), as its limit of an ideal plastic
    yield; Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2 (presliding displacement).

    Attributes:
        factor: largest tau_y, in units of the joint's torque in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m or N].
        displacements: smallest, nominal and largest x_y, in units of the joint's range in the logs.
        least_range: smallest range that is believed [rad or m].
        start_torque: tau_y of the fits that start away from absent, share of its upper bound.
        start_displacements: x_y of these fits, shares of the joint's range.
    """

    factor: float
    least: float
    displacements: tuple[float, float, float]
    least_range: float
    start_torque: float
    start_displacements: tuple[float, ...]

    name: ClassVar[str] = "hysteresis"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "tau = -tau_y b/x_y, b follows the joint within +-x_y"
    fingerprint: ClassVar[str] = "force residual that rises after every reversal over a fixed way, then stays"
    confused_with: ClassVar[tuple[str, ...]] = (
        "presliding_friction",
        "coulomb_friction",
        "spring",
        "backlash",
        "joint_elasticity",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "coulomb_friction": SpecialCase(("displacement",), {"torque": "torque"})
    }
    shapes: ClassVar[tuple[str, ...]] = ("displacement",)
    divisors: ClassVar[tuple[str, ...]] = ("displacement",)
    lacks: ClassVar[str] = "the spring that yields, whose displacement goes on from step to step"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque at which it yields, and the way to there."""
        torque, angle = ("N", "m") if slides(model, site) else ("N·m", "rad")
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        moved = max(scales.position.get(site, 0.0), self.least_range)
        low, nominal, far = (share * moved for share in self.displacements)
        return (Parameter("torque", torque, 0.0, 0.0, high), Parameter("displacement", angle, nominal, low, far))

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        return _Yielding(int(models[0].joint(site).dofadr[0]), values["torque"], values["displacement"])

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little resistance that yields after several ways."""
        torque, way = parameters
        share = way.high / self.displacements[2]
        return tuple(
            {"torque": self.start_torque * torque.high, "displacement": at * share} for at in self.start_displacements
        )


@dataclass
class _Yielding(InternalState):
    """Spring, whose stretch is the state, to a place that it drags along; torque and way of shape (n,) or (1,)."""

    dof: int
    torque: Array
    way: Array

    def follow(self, qvel: Array, step: float) -> None:
        stretch = self.of(len(qvel))
        for way in step * qvel[:, :, self.dof].T:
            stretch = self._slipping(stretch + way)
        self.state = stretch

    def act(self, moment: Moment, influence: Influence) -> None:
        stretch = self.of(len(moment.qvel))
        half = moment.step / 2 * moment.qvel[:, self.dof]
        middle = self._slipping(stretch + half)
        self.state = self._slipping(stretch + 2 * half)
        influence.force[:, self.dof] -= self.torque * middle / self.way

    def _slipping(self, stretch: Array) -> Array:
        """A stretch, as far as the spring bears it; `np.clip` does the same in three times the time."""
        return np.minimum(np.maximum(stretch, -self.way), self.way)
