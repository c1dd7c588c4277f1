"""What drives and what pulls at the joints along a course."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.lacking import lacking
from dr_lab.trajectory import Array

_SHARE = 1e-4  # step of derivatives


@dataclass(frozen=True)
class Forces:
    """Forces at the joints, N·m or N.

    Attributes:
        drive: of all actuators, position controllers' feedback included, shape (K, n).
        outside: of gravity and of the motion itself, shape (K, n).
        per_command: a unit of each command, shape (n, actuators).
        driven: of each actuator, all of it, shape (K, n, actuators).
        pulled: of each position controller, what its proportional gain makes, shape (K, n), by its name.
    """

    drive: Array
    outside: Array
    per_command: Array
    driven: Array
    pulled: Mapping[str, Array]

    @classmethod
    def of(cls, course: Course, command: Array, base: Array) -> "Forces":
        """The forces along a course, from what the machine without any effect lacks there."""
        machine, none = course.machine, np.zeros_like(command)
        still = replace(course, acceleration=np.zeros_like(course.acceleration))
        scaled = [
            (base - lacking(course, machine.with_drive_scaled(name, 1 + _SHARE), command)) / _SHARE
            for name in machine.actuators
        ]
        driven, idling = np.stack(scaled, axis=2), machine
        for name in machine.actuators:
            idling = idling.with_drive_scaled(name, 0.0)
        zero = [0.0] * len(machine.joints)
        idle = np.asarray(machine.terms(zero, zero, none[0].tolist(), zero)[1])
        unit = [np.asarray(machine.terms(zero, zero, one, zero)[1]) - idle for one in np.eye(none.shape[1]).tolist()]
        return cls(
            drive=driven.sum(axis=2),
            outside=machine.model.dof_damping * course.velocity - lacking(still, idling, none),
            per_command=np.stack(unit, axis=1),
            driven=driven,
            pulled={
                name: (base - lacking(course, machine.with_stiffness_scaled(name, 1 + _SHARE), command)) / _SHARE
                for name in machine.actuators
                if machine.model.actuator(name).biasprm[1] < 0
            },
        )
