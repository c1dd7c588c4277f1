"""Trajectories of a target that moves by itself: recorded logs of the real machine."""

from collections.abc import Callable
from typing import Annotated, cast

from torch import Tensor

from dr_lab.bounds import at_least, require_bounds
from dr_lab.envs.environment import Environment
from dr_lab.envs.setting import Setting, require_mujoco
from dr_lab.experts.expert import Demonstrations, Expert
from dr_lab.targets.target import Target


class TargetExpert(Expert):
    """What a target did, as the task sees it.

    Args:
        environment: machine and task that are trained.
        target: makes the target of a machine and its task; it must need no policy.
        episodes: how many are taken.

    Raises:
        ConfigError: the number is below 1.
    """

    def __init__(
        self, environment: Environment, target: Callable[[Setting], Target], episodes: Annotated[int, at_least(1)]
    ) -> None:
        self._environment, self._target, self.episodes = environment, target, episodes
        require_bounds(self, "expert", TargetExpert)

    def demonstrations(self) -> Demonstrations:
        """Play them."""
        setting = require_mujoco(self._environment, "expert=logs")
        played = self._target(setting).play(None, None, self.episodes)
        courses = list[tuple[Tensor, Tensor]]()
        for row in played.unbind(0):
            steps = int(cast(Tensor, row["mask"]).sum())
            before, after = cast(Tensor, row["observation"]), cast(Tensor, row["next", "observation"])
            seen = before.new_empty(steps + 1, before.shape[-1])
            seen[:-1], seen[-1] = before[:steps], after[steps - 1]
            courses.append((seen, cast(Tensor, row["action"])[:steps]))
        return Demonstrations.of(courses)
