"""Deep deterministic policy gradient."""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, cast

import torch
from tensordict import TensorDict
from torch import Tensor, nn
from torchrl.data import LazyTensorStorage, TensorDictReplayBuffer

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.ddpg.loss import DDPGLoss, Transitions
from dr_lab.algorithms.ddpg.uniform_start import UniformStart
from dr_lab.bounds import Count, Natural, NotNegative, Positive, above, at_least, at_most, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.networks.adam import Adam
from dr_lab.networks.averaged_actor import AveragedActor
from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.seeding import derived_seed

_EPSILON = 1e-8  # torch's own; Kingma and Ba 2015
_TOGETHER = 64  # steps whose minibatches are drawn at once, which bounds the memory that they take
logging.getLogger("torchrl").setLevel(logging.WARNING)  # it tells of every buffer that is made


class DDPG(Algorithm):
    """Learns Q from a replay buffer and follows its slope (Lillicrap et al. 2016); TorchRL's buffer.

    The networks see normalised observations and actions scaled to ±1. The buffer holds observations as they are, so
    that old and new ones are normalised alike.

    Args:
        interface: what the policy is connected to.
        seed: of networks, noise and replay.
        actor: makes the policy, from observation width, bounds and seed.
        critic: makes Q, from the width of observation and action together and a seed.
        batch_frames: control steps in a batch.
        gamma: discount per control step.
        replay: control steps that the buffer holds.
        minibatch: samples in a step.
        steps_per_frame: gradient steps for each control step.
        learning_starts: control steps that are only collected, with actions that are uniform within the bounds.
        actor_rate: learning rate of the actor.
        critic_rate: learning rate of Q.
        tau: share of the networks in their slowly following targets at each step.
        saturation_cost: of the actor per square of what its tanh is given, in the reward's unit; see `DDPGLoss`.
        average_steps: steps of the actor over which the deployed policy is averaged; 1 deploys the newest.

    Raises:
        ConfigError: a number is out of its range.
    """

    _CRITICS: ClassVar[Sequence[str]] = ("critic",)

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., DeterministicActor],
        critic: Callable[..., Critic],
        batch_frames: Count,
        gamma: Annotated[float, at_least(0.0), at_most(1.0)],
        replay: Count,
        minibatch: Count,
        steps_per_frame: Positive,
        learning_starts: Natural,
        actor_rate: Positive,
        critic_rate: Positive,
        tau: Annotated[float, above(0.0), at_most(1.0)],
        saturation_cost: NotNegative,
        average_steps: Count,
    ) -> None:
        self.batch_frames, self.replay, self.minibatch = batch_frames, replay, minibatch
        self.gamma = gamma
        self.steps_per_frame, self.learning_starts = steps_per_frame, learning_starts
        self.actor_rate, self.critic_rate, self.tau = actor_rate, critic_rate, tau
        self.saturation_cost, self.average_steps = saturation_cost, average_steps
        require_bounds(self, "algorithm", DDPG)
        bounds, device = (interface.low, interface.high), interface.device
        self.actor = actor(interface.observation, *bounds, derived_seed(seed, "actor")).to(device)
        self.explorer = UniformStart(self.actor)
        self.explorer.follows.fill_(learning_starts == 0)
        self.average = AveragedActor(self.actor, average_steps)
        width = interface.observation + len(interface.low)
        self.critics = nn.ModuleList(critic(width, derived_seed(seed, name)) for name in self._CRITICS).to(device)
        self.generator = torch.Generator().manual_seed(derived_seed(seed, "replay"))
        self.loss = self._made_loss(cast(Sequence[Critic], self.critics))
        self.actor_adam = Adam(self.loss.actor_parameters, _EPSILON)
        self.critic_adam = Adam(self.loss.critic_parameters, _EPSILON)
        self.buffer = TensorDictReplayBuffer(
            storage=LazyTensorStorage(replay, device=device),
        )
        self.frames = 0

    def _made_loss(self, critics: Sequence[Critic]) -> DDPGLoss:
        return DDPGLoss(self.actor, critics, self.gamma, self.saturation_cost)

    @property
    def policies(self) -> Mapping[str, Policy]:
        """Uniform actions at first, then the policy with noise; and its mean over the last steps, which is deployed."""
        return {"policy": self.explorer, "average": self.average}

    @property
    def first(self) -> int:
        """Those that are only collected."""
        return self.learning_starts

    @property
    def deployed(self) -> Policy:
        """The policy without noise, the mean over its last steps."""
        return self.average

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Put the batch into the normaliser's statistics and the buffer, and take the steps that it earns.

        Control steps at which an infeasible context ended an episode are left out. Figures are NaN where no step is
        taken: before `learning_starts`, or after a batch of few control steps.
        """
        self.actor.normaliser.update(batch["observation"])
        rows = batch.reshape(-1)
        rows = rows[~rows["next", "infeasible"].squeeze(-1)]  # no action leads to such an end
        if len(rows):
            self.buffer.extend(self._transitions(rows))
        before, self.frames = self.frames, self.frames + batch.numel()
        self.explorer.follows |= self.frames >= self.learning_starts
        steps = int(self.frames * self.steps_per_frame) - int(before * self.steps_per_frame)
        if self.frames < self.learning_starts or steps == 0 or not len(self.buffer):
            return {"critic_loss": torch.nan, "q": torch.nan}
        terms = [self._step(each) for each in self._samples(steps)]
        critic_loss, value = torch.stack(terms).mean(0).tolist()
        return {"critic_loss": critic_loss, "q": value}

    def _transitions(self, rows: TensorDict) -> TensorDict:
        flags = {key: rows["next", key] for key in ("reward", "done", "terminated")}
        after = {"observation": rows["next", "observation"], **flags}
        now = {
            "observation": rows["observation"],
            "action": self.actor.unit(rows["action"]).clamp(-1.0, 1.0),
            "next": TensorDict(after, batch_size=rows.batch_size),
        }
        return TensorDict(now, batch_size=rows.batch_size)

    def _samples(self, steps: int) -> Iterator[Transitions]:
        """A minibatch for each of so many steps; drawn some at once, since a draw takes as long as a small network."""
        normaliser = self.actor.normaliser
        rows = torch.randint(len(self.buffer), (steps * self.minibatch,), generator=self.generator)
        for part in rows.to(self.actor.reach.device).split(_TOGETHER * self.minibatch):
            drawn = self.buffer[part]
            together = Transitions(
                normaliser(drawn["observation"]),
                drawn["action"],
                drawn["next", "reward"],
                normaliser(drawn["next", "observation"]),
                drawn["next", "terminated"],
            )
            for each in zip(*(field.split(self.minibatch) for field in together), strict=True):
                yield Transitions(*each)

    def _step(self, batch: Transitions) -> Tensor:
        """One step of both networks and their targets; gives the loss of Q and its mean."""
        critic_loss, value = self.loss.differentiate_critics(batch)
        self.critic_adam.step(self.critic_rate)
        self._step_actor(batch.observation)
        return torch.stack([critic_loss, value])

    def _step_actor(self, observation: Tensor) -> None:
        """A step up the slope of Q as it is by now, which the actor's mean and the targets follow."""
        self.loss.differentiate_actor(observation)
        self.actor_adam.step(self.actor_rate)
        self.average.take(self.loss.actor_parameters.vector)
        self.loss.follow(self.tau)

    def begin_schedules(self) -> None:
        """Experience is collected anew, `learning_starts` control steps of it before the next gradient step.

        The deployed policy collects it and is what learns on.
        """
        self.loss.actor_parameters.vector.copy_(self.average.vector)
        self.buffer.empty()
        self.frames = 0
        self.explorer.follows.fill_(True)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs, the buffer included."""
        return {
            "explorer": self.explorer.state_dict(),
            "average": self.average.state_dict(),
            "critics": self.critics.state_dict(),
            "targets": self.loss.state_dict(),
            "actor_adam": self.actor_adam.state_dict(),
            "critic_adam": self.critic_adam.state_dict(),
            "buffer": self._held(),
            "generator": self.generator.get_state(),
            "frames": self.frames,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        parts = {"explorer": self.explorer, "average": self.average, "critics": self.critics, "targets": self.loss}
        for name, part in parts.items():
            part.load_state_dict(state[name])
        self.actor_adam.load_state_dict(state["actor_adam"])
        self.critic_adam.load_state_dict(state["critic_adam"])
        self._hold(state["buffer"])
        self.generator.set_state(state["generator"])
        self.frames = state["frames"]

    def _held(self) -> dict[str, Any]:
        """The buffer's state without the rows that are still empty."""
        state = self.buffer.state_dict()
        if len(self.buffer):
            # A copy, as a file would hold all that a slice is cut from.
            state["_storage"]["_storage"] = self.buffer.storage[:].clone().cpu().state_dict()
        return state

    def _hold(self, state: Mapping[str, Any]) -> None:
        """Fill the buffer, which has room for all rows again, and go on writing where that stopped."""
        self.buffer.empty()
        held = state["_storage"]
        if held["_len"]:
            self.buffer.extend(TensorDict().load_state_dict(held["_storage"], strict=False)[: held["_len"]])
        self.buffer.writer.load_state_dict(state["_writer"])
