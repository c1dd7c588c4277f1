"""How far the logs of a machine reach together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.forces import Forces
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Extent:
    """Largest magnitudes over all logs, of which the shapes of rivals are shares.

    One effect acts alike in every log: a limit is so many N·m, whichever log it is. Shares of each log's own largest
    command would be another limit in each of them.

    Attributes:
        lowest: position of each joint, rad or m, shape (n,).
        highest: the same.
        speed: largest |q'| of each joint, rad/s or m/s, shape (n,).
        command: largest |command| to each actuator, in its unit, shape (m,).
        force: largest of each actuator at any joint, N·m or N, shape (m,).
    """

    lowest: Array
    highest: Array
    speed: Array
    command: Array
    force: Array

    @classmethod
    def of(cls, courses: Sequence[Course], forces: Sequence[Forces]) -> "Extent":
        """That of some logs with the forces along each."""
        return cls(
            lowest=np.min([course.position.min(axis=0) for course in courses], axis=0),
            highest=np.max([course.position.max(axis=0) for course in courses], axis=0),
            speed=np.max([np.abs(course.velocity).max(axis=0) for course in courses], axis=0),
            command=np.max([[np.abs(sent.value).max() for sent in course.sent] for course in courses], axis=0),
            force=np.max([np.abs(each.driven).max(axis=(0, 1)) for each in forces], axis=0),
        )

    @property
    def travel(self) -> Array:
        """Range of each joint, rad or m, shape (n,)."""
        return self.highest - self.lowest
