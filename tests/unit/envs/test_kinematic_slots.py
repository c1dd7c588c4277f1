"""Episodes without MuJoCo fulfil the contract: a point in the plane that moves as it is told, towards its goal."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import pytest
import torch
from torch import Tensor

from dr_lab.collectors.collector import Collector
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.play import undiscounted
from dr_lab.collectors.torchrl import TorchRLCollector
from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.envs.slots import Rows, Starts, StepOutcome
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

LIMIT, REACH = 12, 0.1
SPACE = ContextSpace(tuple(Parameter(f"goal.{axis}", "m", 0.0, -0.5, 0.5) for axis in "xy"))


class Plane:
    """x' = x + a, |a| ≤ 0.1 m; −‖x' − goal‖² is rewarded (Finn et al. 2017, §5.3)."""

    def __init__(self, source: ContextSource | None, n: int, seed: int) -> None:
        self.source, self.space = source, SPACE
        self.low, self.high = -REACH * np.ones(2), REACH * np.ones(2)
        self._streams, self._given = [stream(seed, "episode", slot) for slot in range(n)], None
        self._age, self.observation = np.zeros(n, int), np.zeros((n, 2))
        self.contexts, self.proposals = np.zeros((n, 2)), np.full(n, -1, np.int64)
        self.begin(np.arange(n))

    @property
    def nsim(self) -> int:
        return len(self._age)

    @property
    def state(self) -> tuple[Array, Array]:
        return self.observation.copy(), np.zeros_like(self.observation)

    def give_contexts(self, z: Array | None) -> None:
        self._given = z

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        self.contexts, self.observation = self.contexts.copy(), self.observation.copy()
        if self._given is not None:
            self.contexts[rows] = self._given[rows]
        elif self.source is not None:
            self.contexts[rows] = self.source.propose([self._streams[row] for row in rows], rows).z
        self.observation[rows] = 0.0 if starts is None else starts[0]
        self._age[rows] = 0

    def step(self, action: Array) -> StepOutcome:
        self.observation = self.observation + np.clip(action, self.low, self.high)
        self._age += 1
        away = np.square(self.observation - self.contexts).sum(1)
        never = np.zeros(self.nsim, bool)
        return StepOutcome(self.observation, -away, away < 1e-4, self._age >= LIMIT, never)

    def state_dict(self) -> dict[str, Any]:
        streams = [rng.bit_generator.state for rng in self._streams]
        return {"age": self._age.copy(), "x": self.observation, "z": self.contexts, "streams": streams}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        self._age, self.observation, self.contexts = state["age"].copy(), state["x"], state["z"]
        for rng, remembered in zip(self._streams, state["streams"], strict=True):
            rng.bit_generator.state = remembered


def right(observation: Tensor) -> Tensor:
    return torch.tensor([1.0, 0.0]).expand(len(observation), 2)


def plane(kind: type[Collector], n: int = 3) -> Experience:
    collector = cast(Any, kind)(BatchedEnv(Plane(UniformRandomizer(SPACE, {}), n, seed=0)), right, 30)
    return Experience(collector, right, Plane(None, 2, seed=1))


@pytest.mark.parametrize("kind", [LeanCollector, TorchRLCollector])
def test_training_collects_and_plays_it(kind: type[Collector]) -> None:
    experience = plane(kind)
    batch = experience.collect()
    steps = np.tile(np.arange(1, LIMIT + 1), 3)[:30] * REACH
    goal = batch["context"].double()
    away = (torch.from_numpy(steps) - goal[..., 0]) ** 2 + goal[..., 1] ** 2
    torch.testing.assert_close(-batch["next", "reward"][..., 0].double(), away, atol=1e-6, rtol=0)
    assert batch["next", "truncated"][0, :, 0].nonzero().flatten().tolist() == [11, 23]
    goals: Sequence[Sequence[float]] = [[0.5, 0.0], [0.2, 0.0], [0.0, 0.5]]
    played = experience.play(right, np.array(goals))
    assert played["mask"].sum(1).tolist() == [5, 2, LIMIT]  # pyright: ignore[reportOptionalMemberAccess]
    assert undiscounted(played)[1] == pytest.approx(-0.01)
    experience.close()


def test_it_goes_on_where_it_stopped() -> None:
    whole, cut = plane(LeanCollector), plane(LeanCollector)
    whole.collect()
    cut.load_state_dict(whole.state_dict())
    first, second = whole.collect(), cut.collect()
    assert torch.equal(first["context"], second["context"])
    assert torch.equal(first["observation"], second["observation"])
