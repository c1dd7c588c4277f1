"""An operator that makes the joints follow the wish by torques."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dr_lab.plants.machine import Vector
from dr_lab.plants.operator import Experiment
from dr_lab.plants.tracking import track
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Servo:
    """τ = stiffness (start + wish − q) − damping q' + g(q): the wish is a joint's way from its start.

    g is what holds the documented machine against gravity at q. Actuator i drives joint i, and every joint has one.

    Attributes:
        stiffness: of each joint in N·m/rad.
        damping: of each joint in N·m·s/rad.
    """

    stiffness: Mapping[str, float]
    damping: Mapping[str, float]

    def operate(self, experiment: Experiment, wish: Array) -> tuple[Array, Array]:
        """Let the controller run; the torques are what is logged."""
        documented, count = experiment.documented, len(experiment.documented.joints)
        target = wish + np.asarray(experiment.start[:count])
        stiffness = np.array([self.stiffness[joint] for joint in documented.joints])
        damping = np.array([self.damping[joint] for joint in documented.joints])
        nothing = [0.0] * count

        def controller(instant: int, position: Vector, velocity: Vector) -> Vector:
            _, weight = documented.terms(position, nothing, nothing, nothing)
            pull = stiffness * (target[instant] - np.asarray(position)) - damping * np.asarray(velocity)
            return (pull - np.asarray(weight)).tolist()

        return track(experiment, controller)
