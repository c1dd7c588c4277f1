"""What the algorithms share that train one policy in each of several domains."""

from collections.abc import Callable, Mapping
from typing import Any

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.teachers.teachers import Teachers
from dr_lab.collectors.experience import Experience
from dr_lab.trajectory import Array


class Taught(Algorithm):
    """Trains N teachers, each in one domain; a subclass says what it makes of them.

    Every iteration collects a whole episode in each slot.

    Args:
        interface: what the policies are connected to.
        seed: of the teachers and their domains.
        teachers: makes the teachers, from interface and seed.
    """

    def __init__(self, interface: Interface, seed: int, teachers: Callable[[Interface, int], Teachers]) -> None:
        self.teachers = teachers(interface, seed)

    @property
    def domains(self) -> Array | None:
        """The contexts that the teachers are trained in, shape (N, n); None before they are drawn."""
        return self.teachers.domains

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play a whole episode in each slot, and learn from it."""
        return self.update(experience.collect_whole(self.teachers.slot_contexts(experience)))

    def begin_schedules(self) -> None:
        """Those of the teachers."""
        self.teachers.begin_schedules()

    def forget_episodes(self) -> None:
        """Those of the teachers."""
        self.teachers.forget_episodes()

    def explore_anew(self, seed: int) -> None:
        """Explore by other random numbers, and so do the teachers."""
        super().explore_anew(seed)
        self.teachers.explore_anew(seed)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"teachers": self.teachers.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.teachers.load_state_dict(state["teachers"])
