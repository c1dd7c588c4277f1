"""Points that move alike in one half of the contexts and otherwise in the other: a world whose hard contexts are known.

x′ = x + a, beyond z = ½ x′ = x + 2a; z < 0.05 is infeasible. Episodes have LENGTH steps and begin anew at random.
"""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import torch
from pretended_experience import PretendedExperience
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Collector
from dr_lab.envs.slots import Starts
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array

SPACE = ContextSpace((Parameter("gain", "1", 0.2, 0.0, 1.0),))
LENGTH = 3
HARD, INFEASIBLE = 0.5, 0.05


def noise(observation: Tensor) -> Tensor:
    """A policy."""
    return torch.randn_like(observation)


def moved(x: Array, action: Array, z: Array) -> Array:
    return x + np.where(z > HARD, 2.0, 1.0) * action


class DifferingCollector(Collector):
    """n slots whose contexts come from a source."""

    def __init__(self, source: ContextSource, n: int = 12, steps: int = 4, seed: int = 0) -> None:
        super().__init__(noise)
        self.source, self.steps = source, steps
        self.rngs = [np.random.default_rng([seed, slot]) for slot in range(n)]
        self.x, self.z, self.age = np.zeros(n), np.zeros(n), np.zeros(n, int)
        self.keys = np.zeros(n, np.int64)
        self._begin(np.arange(n))

    def _begin(self, rows: np.ndarray) -> None:
        drawn = self.source.propose([self.rngs[row] for row in rows], rows)
        self.z[rows], self.keys[rows], self.age[rows] = drawn.z[:, 0], drawn.keys, 0
        self.x[rows] = [self.rngs[row].uniform(-1.0, 1.0) for row in rows]

    def _collect(self) -> TensorDict:
        return cast(TensorDict, torch.stack([self._step() for _ in range(self.steps)], 1))

    def _step(self) -> TensorDict:
        action = np.array([rng.standard_normal() for rng in self.rngs])
        before, context, keys = self.x, self.z.copy(), self.keys.copy()
        self.x = moved(before, action, context)
        self.age += 1
        infeasible = context < INFEASIBLE
        truncated = self.age >= LENGTH
        done = infeasible | truncated
        flags = {"done": done, "terminated": infeasible, "truncated": truncated, "infeasible": infeasible}
        batch = row(before, action, self.x, context, flags)
        batch["proposal"] = torch.from_numpy(keys)
        self._begin(np.flatnonzero(done))
        return batch

    def begin(self, z: Array | None) -> None:
        assert z is None

    def state_dict(self) -> dict[str, Any]:
        parts = {"x": self.x, "z": self.z, "age": self.age, "keys": self.keys}
        rngs = [rng.bit_generator.state for rng in self.rngs]
        return {**{name: part.copy() for name, part in parts.items()}, "rngs": rngs}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        self.x, self.z, self.age, self.keys = (state[name].copy() for name in ("x", "z", "age", "keys"))
        for rng, each in zip(self.rngs, state["rngs"], strict=True):
            rng.bit_generator.state = each


class DifferingExperience(PretendedExperience):
    """Whole episodes in the same world, all of LENGTH steps."""

    def __init__(self, collector: DifferingCollector, seed: int = 0) -> None:
        super().__init__(lambda z: z[:, 0], collector)
        self.rng = np.random.default_rng([seed, 99])
        self.contexts_played: list[Array] = []

    def play(self, drive: Any, z: Array, starts: Starts | None = None) -> TensorDict:  # noqa: ANN401
        del drive, starts
        self.contexts_played.append(z)
        action = self.rng.standard_normal((len(z), LENGTH))
        x, rows = self.rng.uniform(-1.0, 1.0, len(z)), list[TensorDict]()
        for t in range(LENGTH):
            after = moved(x, action[:, t], z[:, 0])
            rows.append(row(x, action[:, t], after, z[:, 0], {"infeasible": np.zeros(len(z), bool)}))
            x = after
        played = cast(TensorDict, torch.stack(cast(list[Tensor], rows), 1))
        return played.set("mask", torch.ones(len(z), LENGTH, dtype=torch.bool))


def row(before: Array, action: Array, after: Array, context: Array, flags: Mapping[str, np.ndarray]) -> TensorDict:
    """One step of n slots."""
    shape = [len(before)]
    then = {"observation": column(after)} | {name: torch.from_numpy(flag)[:, None] for name, flag in flags.items()}
    now = {"observation": column(before), "action": column(action), "context": column(context)}
    return TensorDict({**now, "next": TensorDict(then, batch_size=shape)}, batch_size=shape)


def column(values: Array) -> Tensor:
    return torch.from_numpy(values.astype(np.float32))[:, None]
