"""Force laws that no MJCF element expresses: they act on all simulations of a batch once a step."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Moment:
    """Where n simulations are in the middle of the coming step, by extrapolation, so that laws are second order in it.

    Attributes:
        step: length of the step in s.
        time: s on the log's clock, shape (n,).
        qpos: positions; of hinge and slide joints in the middle of the step, of others at its start, shape (n, nq).
        qvel: velocities in the middle of the step, shape (n, nv).
        gained: velocities gained in the last step, zero where there was none, shape (n, nv).
        actuation: generalised forces of the actuators in the last step, shape (n, nv).
        bias: gravity, centrifugal and Coriolis forces of the last step as MuJoCo signs them, shape (n, nv).
        outputs: MuJoCo's ``actuator_force`` of each actuator's output in the last step, shape (n, nout).
    """

    step: float
    time: Array
    qpos: Array
    qvel: Array
    gained: Array
    actuation: Array
    bias: Array
    outputs: Array = field(default_factory=lambda: np.empty((1, 0)))


@dataclass(frozen=True)
class History:
    """What was measured in the p steps before w windows, for laws that remember.

    Attributes:
        begin: s on the log's clock at which the windows start, shape (w,).
        qpos: positions in the middle of the steps, shape (w, p, nq).
        qvel: velocities there, shape (w, p, nv).
        controls: controls of the steps as they were recorded, before any command filter, shape (w, p, nu).
        far: mean velocities in f intervals before these steps, for laws that look far, shape (w, f, nv).
        interval: s, length of each of these.
    """

    begin: Array
    qpos: Array
    qvel: Array
    controls: Array
    far: Array = field(default_factory=lambda: np.empty((1, 0, 0)))
    interval: float = 0.0


@dataclass(frozen=True)
class Influence:
    """What acts in the coming step; laws write into its arrays.

    Attributes:
        control: controls as MuJoCo gets them, shape (n, nu).
        force: generalised forces beside the model's own, shape (n, nv).
        friction: largest dry friction, MuJoCo's ``dof_frictionloss``, shape (n, nv).
        armature: inertia beside that of the bodies, MuJoCo's ``dof_armature``, shape (n, nv).
    """

    control: Array
    force: Array
    friction: Array
    armature: Array


class Law(ABC):
    """One law with the values of n simulations, and what it remembers of them."""

    @abstractmethod
    def act(self, moment: Moment, influence: Influence) -> None:
        """Change what acts in the coming step."""

    def replay_history(self, moment: Moment, influence: Influence) -> None:
        """See a step that was measured before the simulations began; forces of then are unknown and given as zero.

        What the law writes has no effect. By default it does as in a step that is simulated.
        """
        self.act(moment, influence)

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Forget what came before in these simulations; a law without memory has nothing to forget."""
        del rows

    def read_encoders(self, qpos: Array, qvel: Array) -> None:
        """Turn positions (n, nq) and velocities (n, nv) of the joints now into what encoders read, in place.

        By default encoders sit at the joints.
        """
        del qpos, qvel

    def place_joints(self, qpos: Array, qvel: Array) -> None:
        """Turn what encoders read at a start into positions and velocities of the joints, in place."""
        del qpos, qvel

    @property
    def reads_elsewhere(self) -> bool:
        """Whether encoders read something else than the joints."""
        return type(self).read_encoders is not Law.read_encoders

    @property
    def remembers(self) -> bool:
        """Whether the law has something to forget, so that what was measured before matters to it."""
        return type(self).rest is not Law.rest

    @property
    def memory(self) -> Array:
        """What the law remembers, shape (n, k) or (1, k); a law without memory has k = 0."""
        return np.empty((1, 0))

    def remember(self, memory: Array) -> None:
        """Go on from what `memory` of an equal law was."""
        del memory


class CommandLaw(Law):
    """A law that changes commands, and so acts before the laws that go by them."""


class MotionLaw(Law):
    """A law whose memory depends on how the joints move alone, so that it can follow a measured motion at once.

    Attributes:
        looks_far: whether it follows the motion of `History.far` as well.
    """

    looks_far: ClassVar[bool] = False

    @abstractmethod
    def follow(self, qvel: Array, step: float) -> None:
        """Go along a motion before the simulations begin, as in steps that are simulated.

        Args:
            qvel: velocities in the middle of p steps, shape (n, p, nv).
            step: length of a step in s.
        """
