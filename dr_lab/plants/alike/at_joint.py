"""One joint of a machine along a course, as its rivals see it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.extent import Extent
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice, linear, pushing
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class AtJoint:
    """A joint, where it moves, and what is tried there.

    Attributes:
        course: where the machine moves.
        grids: shapes that are tried.
        extent: how far all logs reach, this one among them.
        row: place of the joint.
        borne: what a hidden dry friction bears at each joint while it holds it, N·m or N, shape (K, n); else 0.
    """

    course: Course
    grids: Grids
    extent: Extent
    row: int
    borne: Array

    @property
    def name(self) -> str:
        """The joint's name."""
        return self.course.machine.joints[self.row]

    @property
    def q(self) -> Array:
        """Its positions, rad or m, shape (K,)."""
        return self.course.position[:, self.row]

    @property
    def v(self) -> Array:
        """Its velocities, rad/s or m/s, shape (K,)."""
        return self.course.velocity[:, self.row]

    @property
    def joints(self) -> int:
        """Number of the machine's joints."""
        return self.course.position.shape[1]

    @property
    def slides(self) -> bool:
        """Whether it is a slide."""
        joint = self.course.machine.model.joint(self.name)
        return int(joint.type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)

    @property
    def controlled(self) -> bool:
        """Whether a position controller moves it."""
        model = self.course.machine.model
        pulls = model.actuator_biasprm[model.actuator_trnid[:, 0] == model.joint(self.name).id, 1]
        return bool((pulls < 0).any())

    def speeds(self, shares: Sequence[float]) -> Array:
        """Shares of its largest speed, rad/s or m/s."""
        return self.extent.speed[self.row] * np.asarray(shares)

    def ways(self, shares: Sequence[float]) -> Array:
        """Shares of its range, rad or m."""
        return self.extent.travel[self.row] * np.asarray(shares)

    def pushed(self, shape: Array) -> Signature:
        """A force at it, shape (K,)."""
        return pushing(shape, self.row, self.joints)

    def linear(self, *shapes: Array, positive: Sequence[bool] | bool = False) -> tuple[Choice]:
        """Forces at it, each of any size."""
        return linear(*map(self.pushed, shapes), positive=positive)

    def dry(self, *shapes: Array, positive: Sequence[bool] | bool = True) -> tuple[Choice, ...]:
        """Dry frictions of any size; one that is large enough also bears what holds the joint.

        Where another dry friction does that already, it bears nothing; so both are tried.
        """
        (sliding,) = self.linear(*shapes, positive=positive)
        if not any(joint == self.row for joint, _ in self.course.true_body.frictions):
            return (sliding,)
        return (replace(sliding, fixed=self.pushed(self.borne[:, self.row])), sliding)
