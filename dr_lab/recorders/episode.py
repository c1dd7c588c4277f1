"""One episode of a policy, as recordings show it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import mujoco

from dr_lab.errors import DataError
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Episode:
    """An episode from its start to its end, t control steps.

    Attributes:
        name: short, unique among those that are recorded together.
        context: z, value and unit by parameter; empty where it is not known, as of a real machine.
        geometry: the machine in this context.
        time: s since the start, shape (t + 1,).
        qpos: positions before the first and after every control step, shape (t + 1, nq).
        qvel: velocities likewise, shape (t + 1, nv).
        observation: what the policy saw before the first control step and would see after every one, shape (t + 1, o).
        action: what the policy did within its bounds, held until the next, shape (t, nu).
        reward: of each control step, shape (t,).
        ended: why there is no further step; ``infeasible`` where the context does not compile or diverged.

    Raises:
        DataError: an array has another shape than the above.
    """

    name: str
    context: Mapping[str, tuple[float, str]]
    geometry: mujoco.MjModel
    time: Array
    qpos: Array
    qvel: Array
    observation: Array
    action: Array
    reward: Array
    ended: Literal["terminated", "truncated", "infeasible"]

    def __post_init__(self) -> None:
        steps, model = len(self.reward), self.geometry
        expected = {
            "time": (steps + 1,),
            "qpos": (steps + 1, model.nq),
            "qvel": (steps + 1, model.nv),
            "observation": (steps + 1, *self.observation.shape[1:]),
            "action": (steps, model.nu),
            "reward": (steps,),
        }
        for name, shape in expected.items():
            given = getattr(self, name).shape
            if given != shape:
                raise DataError(f"Episode {self.name!r}: {name} has shape {given}, expected {shape}.")

    @property
    def undiscounted(self) -> float:
        """The return, Σ reward."""
        return float(self.reward.sum())
