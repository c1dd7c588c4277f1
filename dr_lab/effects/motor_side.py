"""A motor that does not turn as its joint does: the hidden half of a joint whose transmission gives way."""

from abc import abstractmethod
from dataclasses import dataclass, field, replace
from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.effects.joint_drive import JointDrive
from dr_lab.effects.joint_effect import JointEffect, driven, slides
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_FLAGS = ("_known", "_under_way", "_free")


@dataclass(frozen=True)
class MotorSideEffect(JointEffect):
    """An effect between a motor and the link that it drives, which encoders at the joint do not see directly.

    The model's joint is the link's side. The encoder sits there, unless the effect says otherwise. Of the inertia that
    the model gives the joint the share `rotor` turns with the motor, at a distance δ before the link:
    J δ'' = tau_m − T − J q'' with the actuators' torque tau_m and the torque T(δ, δ') that is passed on. Rotor and link
    together have the model's inertia, so that a transmission without play leaves the model as it is, whatever the
    rotor's share.

    Attributes:
        inertias: smallest, nominal and largest rotor inertia, in units of the joint's effective inertia in the model's
            initial position.
    """

    inertias: tuple[float, float, float]

    patience: ClassVar[int] = 3  # the states of windows that begin amid an oscillation have to follow

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints that an actuator drives."""
        return tuple(joint for joint in super().sites(model) if driven(model, joint))

    def rotor(self, model: mujoco.MjModel, site: str) -> Parameter:
        """The inertia on the motor's side."""
        dof = int(model.joint(site).dofadr[0])
        low, nominal, high = (share / float(model.dof_invweight0[dof]) for share in self.inertias)
        return Parameter("rotor", "kg" if slides(model, site) else "kg·m²", nominal, low, high)


@dataclass(frozen=True)
class FedBackEffect(MotorSideEffect):
    """One where the feedback of the actuators is the motor's, and is taken at the start of a step h.

    So the rotor is at least so heavy that the feedback stops it within the step and no sooner: J ≥ h K_v + h² K_p.
    """

    def rotor(self, model: mujoco.MjModel, site: str) -> Parameter:
        """The inertia on the motor's side."""
        rotor, drive, step = super().rotor(model, site), JointDrive.of([model], site), model.opt.timestep
        stopped = float(-step * drive.by_velocity[0] - step**2 * drive.by_position[0])
        return replace(rotor, low=float(np.clip(stopped, rotor.low, rotor.nominal)))


@dataclass(frozen=True)
class BehindLoop(FedBackEffect):
    """One between the motor of a position controller, whose own encoder closes the loop, and the joint."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints that a position controller drives."""
        return tuple(joint for joint in super().sites(model) if JointDrive.of([model], joint).by_position[0] != 0.0)


@dataclass
class MotorSide(Law):
    """The rotor of n simulations, as seen from the link.

    With the rotor glued to it the link would feel all of tau_m and carry J. What it feels differs by −J δ'':

    1. Through one step tau_m and q'' are taken as constant. The change of the rate δ' is then
       kick + share h (tau_m − J q'')/J; `plan` says what kick and share are.
    2. The part with q'' takes inertia off the joint. So the coupling is implicit, and it stays stable for a rotor that
       outweighs its link. The rest is an applied force.
    3. If tau_m turns out to have been another (a clipped or late command), the next step makes up for the difference.
    4. MuJoCo's actuators see the link. Where they have the motor's encoder, what they would give more is applied, too.

    Attributes:
        drive: what the joint's actuators give.
        step: s.
        inertia: J, kg·m² or kg, shape (n,) or (1,).
        offset: δ, rad or m, shape (n,).
        rate: δ', rad/s or m/s, shape (n,).
        kept: names of what the next step depends on.
    """

    drive: JointDrive
    step: float
    inertia: Array
    offset: Array = field(default_factory=lambda: np.zeros(0), init=False)
    rate: Array = field(default_factory=lambda: np.zeros(0), init=False)
    kept: ClassVar[tuple[str, ...]] = (
        "offset",
        "rate",
        "_known",
        "_under_way",
        "_asked",
        "_expected",
        "_share",
        "_beside",
    )
    _known: NDArray[np.bool_] = field(init=False)
    _under_way: NDArray[np.bool_] = field(init=False)
    _asked: Array = field(init=False)
    _expected: Array = field(init=False)
    _share: Array = field(init=False)
    _beside: Array = field(init=False)
    _held: Array = field(init=False)

    @abstractmethod
    def balance(self, load: Array) -> Array:
        """δ where the rotor rests under a load tau_m − J q'', shape (n,)."""

    @abstractmethod
    def plan(self, load: Array) -> tuple[Array, Array]:
        """Share and kick of the coming step, which is expected to bear this load, shapes (n,) or (1,)."""

    @abstractmethod
    def advance(self, load: Array) -> None:
        """Move offset and rate to the end of the planned step, which has borne this load."""

    def act(self, moment: Moment, influence: Influence) -> None:
        """End the last step with what it turned out to bear, and plan the coming one."""
        dof, control = self.drive.dof, self._arriving(influence.control)
        asked, inertial = self.drive.force(moment.qpos, moment.qvel, control), self._inertial(moment)
        at_link = moment.actuation[:, dof] - self.drive.staying(moment.outputs)
        given = at_link + self._beside
        self._meet(given - inertial)
        self._go(given - inertial, self._under_way)
        late = np.where(self._under_way, self._share * (given - self._expected), 0.0)
        beside = self.fed_back(moment, control, asked)
        expected = at_link + beside + np.where(self._under_way, asked - self._asked, 0.0)
        share, kick = self.plan(expected - inertial)
        influence.armature[:, dof] -= share * self.inertia
        influence.force[:, dof] += beside - (share * expected + self.inertia * kick / self.step + late)
        self._asked, self._expected, self._share, self._beside = asked, expected, share, beside
        self._under_way = np.ones(len(asked), bool)

    def fed_back(self, moment: Moment, control: Array, asked: Array) -> Array:
        """What actuators give beside what they ask for at the link's position and velocity, shape (n,): nothing."""
        del moment, control
        return np.zeros(len(asked))

    def replay_history(self, moment: Moment, influence: Influence) -> None:
        """Follow the measured motion under what the actuators give at its commands."""
        control = self._arriving(influence.control)
        asked = self.drive.force(moment.qpos, moment.qvel, control)
        load = asked + self.fed_back(moment, control, asked) - self._inertial(moment)
        self._meet(load)
        self.plan(load)
        self._go(load, self._known)

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Forget where the motor is; it begins in balance."""
        if len(self.offset) > rows.max(initial=0):
            self._known[rows] = self._under_way[rows] = False
            self._beside[rows] = 0.0

    @property
    def memory(self) -> Array:
        """Where the motors are, what the step under way was planned for, and what filters of commands hold."""
        count = len(self.offset)
        if count == 0:
            return np.empty((1, 0))
        own = np.stack([np.broadcast_to(getattr(self, name), count) for name in self.kept], axis=1)
        return np.concatenate([own, self._held], axis=1, dtype=float)

    def remember(self, memory: Array) -> None:
        """Go on from the `memory` of an equal law."""
        if memory.shape[1]:
            for name, column in zip(self.kept, memory.T[: len(self.kept)], strict=True):
                setattr(self, name, column.astype(bool) if name in _FLAGS else column.copy())
            self._held = memory[:, len(self.kept) :].copy()

    def _arriving(self, control: Array) -> Array:
        """Commands of the coming step as the filters of the actuators pass them on."""
        self._size(len(control))
        if self.drive.filters:
            control, self._held = self.drive.filtered(control, self._held, self._known)
        return control

    def _inertial(self, moment: Moment) -> Array:
        """J q'' in the last step."""
        return self.inertia * moment.gained[:, self.drive.dof] / self.step

    def _go(self, load: Array, rows: NDArray[np.bool_]) -> None:
        """Advance where a step has passed."""
        before = self.offset, self.rate
        self.advance(load)
        after = self.offset, self.rate
        self.offset, self.rate = (np.where(rows, *pair) for pair in zip(after, before, strict=True))

    def _size(self, count: int) -> None:
        """Know nothing of so many simulations, where it was not as many before."""
        if len(self.offset) != count:
            self.offset, self.rate, self._asked, self._expected, self._share, self._beside = np.zeros((6, count))
            self._known, self._under_way = np.zeros((2, count), bool)
            self._held = np.zeros((count, self.drive.left.shape[2] if self.drive.filters else 0))

    def _meet(self, load: Array) -> None:
        """Let simulations of which nothing is known begin at rest under their load."""
        if not self._known.all():
            self.offset = np.where(self._known, self.offset, self.balance(load))
            self.rate = np.where(self._known, self.rate, 0.0)
            self.plan(load)
            self._known = np.ones(len(load), bool)


class FedBackAtMotor(MotorSide):
    """The same where the actuators' feedback is the motor's position and velocity."""

    def fed_back(self, moment: Moment, control: Array, asked: Array) -> Array:
        """What actuators give more for the motor's position and velocity than for the link's."""
        qpos, qvel = moment.qpos.copy(), moment.qvel.copy()
        qpos[:, self.drive.address] += self.offset + 0.5 * self.step * self.rate
        qvel[:, self.drive.dof] += self.rate
        return self.drive.force(qpos, qvel, control) - asked
