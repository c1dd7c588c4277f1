"""Generative adversarial imitation learning, on top of an algorithm that learns from rewards."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.gail.discriminator import ImitationDiscriminator
from dr_lab.collectors.collector import Policy
from dr_lab.errors import ConfigError
from dr_lab.experts.expert import Demonstrations, Expert
from dr_lab.seeding import derived_seed


class GAIL(Algorithm):
    """Imitates an expert: learns from the reward −log(1 − D(o, a)) in place of the task's.

    D, the probability that a control step is the expert's, learns from every batch before it is rewarded, and the
    batch then goes to another algorithm. The task's rewards are recorded, and nothing learns from them; nor do they
    choose which policy is deployed, which is the last.

    Source: Ho and Ermon, Generative Adversarial Imitation Learning, 2016, algorithm 1.

    Limits: rewards are never negative, so that ending an episode early is never worth it; with a replay buffer, a
    reward is that of the time at which its step was collected.

    Args:
        interface: what the policy is connected to.
        seed: of everything that is random.
        learner: makes the algorithm that learns the policy from batches, such as PPO or DDPG.
        expert: whom to imitate.
        discriminator: makes D, from the widths of observation and action, a seed and a device.

    Raises:
        ConfigError: the algorithm collects in its own way, so that it cannot be given rewards.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        learner: Callable[[Interface, int], Algorithm],
        expert: Expert,
        discriminator: Callable[..., ImitationDiscriminator],
    ) -> None:
        self.learner = learner(interface, seed)
        if type(self.learner).iterate is not Algorithm.iterate:
            raise ConfigError(
                f"algorithm=gail gives rewards to the batches of another algorithm, and {self.learner.name} collects "
                "in its own way. Take one that learns from batches as they come: algorithm@algorithm.learner=ppo or "
                "ddpg."
            )
        self.batch_frames = self.learner.batch_frames
        self._expert, self._known = expert, None
        self._device, bounds = interface.device, (interface.low, interface.high)
        self._low, self._high = (torch.from_numpy(each).float().to(self._device) for each in bounds)
        self._widths = (interface.observation, len(interface.low))
        self.discriminator = discriminator(*self._widths, derived_seed(seed, "discriminator"), device=self._device)

    @property
    def policies(self) -> Mapping[str, Policy]:
        """Those of the learner."""
        return self.learner.policies

    @property
    def first(self) -> int:
        """As the learner says."""
        return self.learner.first

    @property
    def judged_by_return(self) -> bool:
        """No: what the task pays for may be something else than what the expert does."""
        return False

    @property
    def deployed(self) -> Policy:
        """That of the learner."""
        return self.learner.deployed

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Let D learn from the batch, reward its control steps, and let the learner have them."""
        observation, action = cast(Tensor, batch["observation"]), self._unit(cast(Tensor, batch["action"]))
        rows, expert = (observation.flatten(0, 1), action.flatten(0, 1)), self._demonstrations()
        figures = {
            "discriminator_loss": self.discriminator.learn(expert, *rows),
            "discriminator_accuracy": self.discriminator.accuracy(expert, *rows),
        }
        reward = self.discriminator.reward(observation, action)
        rewarded = batch.copy()
        rewarded["next"] = cast(TensorDict, batch["next"]).copy().set("reward", reward)
        return {**figures, "imitation_reward": float(reward.mean()), **self.learner.update(rewarded)}

    def begin_schedules(self) -> None:
        """Those of the learner."""
        self.learner.begin_schedules()

    def forget_episodes(self) -> None:
        """Those of the learner."""
        self.learner.forget_episodes()

    def explore_anew(self, seed: int) -> None:
        """As the learner does; D learns by other random numbers, too."""
        self.learner.explore_anew(seed)
        self.discriminator.explore_anew(seed)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs, the trajectories apart, which are read again."""
        return {"learner": self.learner.state_dict(), "discriminator": self.discriminator.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.learner.load_state_dict(state["learner"])
        self.discriminator.load_state_dict(state["discriminator"])

    def _demonstrations(self) -> Demonstrations:
        """The expert's, with actions scaled to ±1; read once, as a policy can be played without them."""
        if self._known is None:
            found = self._expert.demonstrations()
            found.require_widths(*self._widths, "algorithm=gail")
            seen, done = found.observation.to(self._device), found.action.to(self._device)
            self._known = replace(found, observation=seen, action=self._unit(done))
        return self._known

    def _unit(self, action: Tensor) -> Tensor:
        """What the machine does of an action, scaled to ±1."""
        centre, reach = (self._high + self._low) / 2, (self._high - self._low) / 2
        return ((action - centre) / reach).clamp(-1.0, 1.0)
