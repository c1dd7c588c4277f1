"""Bristles that bend before they slip, as the state of a friction law."""

from dataclasses import dataclass, field

import numpy as np

from dr_lab.effects.internal_state import InternalState
from dr_lab.physics.law import Influence, Moment
from dr_lab.trajectory import Array

_TINY = 1e-12  # steady bend at which v is nothing; rad or m, a way that is none


@dataclass
class Bristles(InternalState):
    """Bristles of a degree of freedom, whose bend b is the state; values of shape (n,) or (1,).

    tau = −torque (b + retardation b') with b' = (v − |v/g(v)| b)/way and g(v) = tanh(v/creep), to which b settles at a
    steady v. The equation is linear in b and is solved exactly over a step at the velocity of its middle; the force is
    that of the means of b and b' over the step. How it changes with the velocity that the step adds is put beside the
    inertia, so that bristles need no finer steps.

    Attributes:
        dof: degree of freedom.
        torque: where b is 1, N·m or N.
        way: over which b builds up, rad or m.
        creep: speed below which they slip slowly under any load, rad/s or m/s.
        retardation: damping of the bristles over their stiffness, s.
    """

    dof: int
    torque: Array
    way: Array
    creep: Array
    retardation: Array = field(default_factory=lambda: np.zeros(1), kw_only=True)

    def settled(self, speed: Array) -> tuple[Array, Array]:
        """The bend g to which they settle at a steady speed, and dg/dv where g grows with the speed."""
        bend = np.tanh(speed / self.creep)
        return bend, (1.0 - bend**2) / self.creep

    def follow(self, qvel: Array, step: float) -> None:
        """Bend along a motion."""
        bend = self.of(len(qvel))
        steady, _, turns = self._course(np.ascontiguousarray(qvel[:, :, self.dof].T), step)
        for end, left in zip(steady, np.exp(-turns), strict=True):
            bend = end + (bend - end) * left
        self.state = bend

    def _course(self, speed: Array, step: float) -> tuple[Array, Array, Array]:
        """What `settled` gives at speeds, and the number of time constants in a step."""
        steady, slope = self.settled(speed)
        fast = np.abs(speed) / np.maximum(np.abs(steady), _TINY)  # large where nothing holds them at high speed
        slipped = np.where(speed == 0.0, self.creep, fast)
        return steady, slope, slipped * step / np.maximum(self.way, _TINY)

    def act(self, moment: Moment, influence: Influence) -> None:
        """Add the force of a step, and go on to its end."""
        bend = self.of(len(moment.qvel))
        speed, step = moment.qvel[:, self.dof], moment.step
        steady, slope, turns = self._course(speed, step)
        way, left = np.maximum(self.way, _TINY), np.exp(-turns)
        share = (1.0 - left) / turns  # of the bend at the start in the step's mean
        mean = steady + (bend - steady) * share
        # ∂mean/∂v; the mean's share falls with the way gone in the step
        grip = slope * (1.0 - share)
        grip += np.abs(steady - bend) * (share - left) / turns * step / way
        after = steady + (bend - steady) * left
        retarded = self.retardation / step
        grip += retarded * (slope * (1.0 - left) + np.abs(steady - bend) * left * step / way)
        added = self.torque * grip * step / 2
        pull = mean + retarded * (after - bend)
        influence.armature[:, self.dof] += added
        influence.force[:, self.dof] += added * moment.gained[:, self.dof] / step - self.torque * pull
        self.state = after
