"""An actuator, or several that share what they lack, along a course, as rivals see them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from dr_lab.plants.alike.course import Course, mean_held
from dr_lab.plants.alike.extent import Extent
from dr_lab.plants.alike.forces import Forces
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import lacked
from dr_lab.trajectory import Array

ALL_ACTUATORS = "all_actuators"
_LAW = ("gaintype", "gainprm", "biastype", "biasprm", "dyntype", "dynprm", "forcerange", "trntype")


@dataclass(frozen=True)
class AtDrives:
    """Actuators that share an effect with the same numbers, and what is tried there.

    Attributes:
        course: where the machine moves.
        grids: shapes that are tried.
        extent: how far all logs reach, this one among them.
        forces: along the course.
        rows: places of the actuators.
    """

    course: Course
    grids: Grids
    extent: Extent
    forces: Forces
    rows: tuple[int, ...]

    @property
    def site(self) -> str:
        """The actuator's name, or what stands for all of them."""
        return self.course.machine.actuators[self.rows[0]] if len(self.rows) == 1 else ALL_ACTUATORS

    @property
    def largest(self) -> float:
        """Largest command to any, in its unit."""
        return float(self.extent.command[list(self.rows)].max())

    @property
    def strongest(self) -> float:
        """Largest force of any, N·m or N."""
        return float(self.extent.force[list(self.rows)].max())

    @cached_property
    def means(self) -> dict[int, Array]:
        """Mean commands over each interval, by place, each of shape (K,)."""
        return {row: mean_held(self.course.sent[row], self.course.edge) for row in self.rows}

    def whole(self, row: int) -> Array:
        """All force of one of them at each joint, N·m or N, shape (K, n)."""
        return self.forces.driven[:, :, row]

    def joint(self, row: int) -> int:
        """Place of the joint that one of them drives."""
        return int(np.abs(self.forces.per_command[:, row]).argmax())

    def acting(self, shape: Callable[[int], Array]) -> Signature:
        """What commands, of shape (K,) by place, give beside those that are sent."""
        return self.added(lambda row: np.outer(shape(row), self.forces.per_command[:, row]))

    def changed(self, shape: Callable[[int], Array]) -> Signature:
        """What other commands, of shape (K,) by place, give in the place of those that are sent."""
        return self.acting(lambda row: shape(row) - self.means[row])

    def added(self, force: Callable[[int], Array]) -> Signature:
        """What further forces at the joints give, of shape (K, n) by place."""
        return lacked(-np.sum([force(row) for row in self.rows], axis=0))


def groups(course: Course, rows: Sequence[int], *, sizeless: bool) -> Iterator[tuple[int, ...]]:
    """Each of some actuators by itself, then all together where they can share what they lack.

    Drives of one make share it; drives of unlike sizes share times and factors alone (`sizeless`).
    """
    yield from ((row,) for row in rows)
    if len(rows) > 1 and (sizeless or _of_one_make(course.machine.model, rows)):
        yield tuple(rows)


def _of_one_make(model: mujoco.MjModel, rows: Sequence[int]) -> bool:
    """Whether the forces of drives follow the same law of command and motion."""
    first, *others = (
        np.concatenate(
            [
                *(np.atleast_1d(getattr(model, f"actuator_{name}")[row]) for name in _LAW),
                np.abs(model.actuator_gear[row]),
                [model.jnt_type[model.actuator_trnid[row, 0]]],
            ]
        )
        for row in rows
    )
    return all(np.array_equal(first, other) for other in others)
