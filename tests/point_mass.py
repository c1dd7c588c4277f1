"""A point on a line that is to be brought to the origin: a machine for tests of algorithms, with a known optimum."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.reward_scale import RunningRewardScale
from dr_lab.collectors.collector import Collector, Policy
from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser, Normaliser, RunningNormaliser
from dr_lab.trajectory import Array

STEP = 0.2  # x' = x + STEP·z·a, reward 1 − x'²
LIMIT = 15  # steps after which an episode is cut; |x| > 2 terminates it
INTERFACE = Interface(1, np.array([-1.0]), np.array([1.0]))
ASKEW = Interface(1, np.array([-3.0]), np.array([1.0]))  # bounds that are not their own unit


class PointCollector(Collector):
    """n points, whose gain z is uniform over [0.5, 1.5]."""

    def __init__(self, policy: Policy, n: int = 16, steps: int = 30, seed: int = 0) -> None:
        super().__init__(policy)
        self.steps = steps
        self.rng = np.random.default_rng(seed)
        self.x, self.z, self.age = np.zeros(n), np.ones(n), np.zeros(n, int)
        self.given: Array | None = None
        self._begin(np.ones(n, bool))

    def _begin(self, rows: np.ndarray) -> None:
        self.x[rows] = self.rng.uniform(-1.0, 1.0, rows.sum())
        self.z[rows] = self.rng.uniform(0.5, 1.5, rows.sum()) if self.given is None else self.given[rows]
        self.age[rows] = 0

    def _collect(self) -> TensorDict:
        return cast(TensorDict, torch.stack([self._step() for _ in range(self.steps)], 1))

    def _step(self) -> TensorDict:
        before, context = column(self.x), column(self.z)
        action = self._policy(before)
        self.x = self.x + STEP * self.z * action[:, 0].double().numpy().clip(-1.0, 1.0)
        self.age += 1
        terminated, truncated = np.abs(self.x) > 2.0, self.age >= LIMIT
        done = terminated | truncated
        after = {"observation": column(self.x), "context": context, "reward": column(1.0 - self.x**2)}
        flags = {"terminated": terminated, "truncated": truncated, "done": done, "infeasible": np.zeros_like(done)}
        after |= {key: torch.from_numpy(flag.copy())[:, None] for key, flag in flags.items()}
        self._begin(done)
        shape = [len(done)]
        now = {"observation": before, "context": context, "action": action, "next": TensorDict(after, batch_size=shape)}
        return TensorDict(now, batch_size=shape)

    def begin(self, z: Array | None) -> None:
        self.given = None if z is None else z[:, 0]
        self._begin(np.ones(len(self.x), bool))

    def state_dict(self) -> dict[str, Any]:
        return {"x": self.x, "z": self.z, "age": self.age, "rng": self.rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        self.x, self.z, self.age = (np.array(state[key]) for key in ("x", "z", "age"))
        self.rng.bit_generator.state = state["rng"]


def column(values: np.ndarray) -> Tensor:
    return torch.from_numpy(values.astype(np.float32))[:, None]


def mean_reward(policy: Policy) -> float:
    """Mean reward of a policy over many episodes."""
    return next(PointCollector(policy, n=200, steps=LIMIT, seed=9))["next", "reward"].mean().item()


def best(observation: Tensor) -> Tensor:
    """The optimum for the mean gain."""
    return (-observation / STEP).clamp(-1.0, 1.0)


def actor() -> partial[GaussianActor]:
    normaliser = partial(RunningNormaliser, clip=10.0)
    return partial(GaussianActor, normaliser=normaliser, hidden=[16, 16], activation="tanh", log_std=-0.5)


def critic() -> partial[Critic]:
    return partial(Critic, hidden=[16, 16], activation="tanh")


def ppo_arguments(seed: int = 0, **changes: Any) -> dict[str, Any]:  # noqa: ANN401
    """Arguments of PPO that solve the task."""
    return {
        "interface": INTERFACE,
        "seed": seed,
        "actor": actor(),
        "critic": critic(),
        "surrogate": partial(ExplicitSurrogate, clip=0.2, entropy_weight=0.0, critic_weight=0.5),
        "reward_scale": partial(RunningRewardScale, clip=10.0),
        "batch_frames": 480,
        "gamma": 0.9,
        "lam": 0.95,
        "epochs": 8,
        "minibatch": 60,
        "actor_rate": 3e-3,
        "critic_rate": 3e-3,
        "anneal_frames": None,
        "further_share": 1.0,
        "max_kl": None,
        "max_gradient": 0.5,
        "adam_epsilon": 1e-5,
    } | changes


def replaying_arguments(normaliser: Callable[[int], Normaliser] = NoNormaliser) -> dict[str, Any]:
    """Arguments of DDPG that solve the task, and of what derives from it."""
    return {
        "actor": partial(DeterministicActor, normaliser=normaliser, hidden=[16], activation="relu", noise=0.3),
        "critic": partial(Critic, hidden=[32], activation="relu"),
        "batch_frames": 64,
        "gamma": 0.9,
        "replay": 2000,
        "minibatch": 64,
        "steps_per_frame": 0.25,
        "learning_starts": 200,
        "actor_rate": 3e-3,
        "critic_rate": 3e-3,
        "tau": 0.02,
        "saturation_cost": 0.0,
        "average_steps": 1,
    }


def ppo(seed: int = 0) -> PPO:
    return PPO(**ppo_arguments(seed))
