"""Points in a plane that are to be brought to goals they cannot see: tasks for tests of adaptation."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Interface
from dr_lab.collectors.collector import Collector, Policy
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

REACH = 0.1  # x' = x + clip(a, ±REACH), reward −|x' − goal|, from x = 0
GOALS = ContextSpace((Parameter("goal_x", "m", 0.0, -0.5, 0.5), Parameter("goal_y", "m", 0.0, -0.5, 0.5)))
INTERFACE = Interface(2, np.full(2, -REACH), np.full(2, REACH))


class GoalCollector(Collector):
    """n points, whose goals are given.

    With `fatal`, an episode whose goal lies right of it is infeasible: it ends at its first step.
    """

    def __init__(self, policy: Policy, n: int, limit: int, fatal: float = np.inf) -> None:
        super().__init__(policy)
        self.limit, self.fatal = limit, fatal
        self.x, self.goal, self.age = np.zeros((n, 2)), np.zeros((n, 2)), np.zeros(n, int)

    def _collect(self) -> TensorDict:
        steps = [self._step() for _ in range(self.limit)]
        return torch.stack(steps, 1)  # pyright: ignore[reportReturnType,reportCallIssue,reportArgumentType]

    def _step(self) -> TensorDict:
        before, context = _single(self.x), _single(self.goal)
        action = self._policy(before)
        self.x = self.x + action.double().numpy().clip(-REACH, REACH)
        self.age += 1
        infeasible = self.goal[:, 0] > self.fatal
        truncated = (self.age >= self.limit) & ~infeasible
        reward = -np.linalg.norm(self.x - self.goal, axis=1)
        after = {"observation": _single(self.x), "context": context, "reward": _single(reward[:, None])}
        flags = {"terminated": infeasible, "truncated": truncated, "infeasible": infeasible}
        flags["done"] = done = infeasible | truncated
        after |= {key: torch.from_numpy(flag.copy())[:, None] for key, flag in flags.items()}
        self.x[done], self.age[done] = 0.0, 0
        size = [len(done)]
        now = {"observation": before, "context": context, "action": action, "next": TensorDict(after, batch_size=size)}
        return TensorDict(now, batch_size=size)

    def begin(self, z: Array | None) -> None:
        assert z is not None
        self.x, self.goal, self.age = np.zeros_like(self.x), np.array(z), np.zeros_like(self.age)

    def state_dict(self) -> dict[str, Any]:
        return {"x": self.x, "goal": self.goal, "age": self.age}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        self.x, self.goal, self.age = (np.array(state[key]) for key in ("x", "goal", "age"))


def _single(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values.astype(np.float32))
