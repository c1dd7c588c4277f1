"""Model-agnostic meta-learning on episodes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor, vmap

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.maml.adaptation import Adaptation
from dr_lab.algorithms.maml.adapted_policy import AdaptedPolicy
from dr_lab.algorithms.maml.loss import MAMLLoss, meta_batch
from dr_lab.algorithms.maml.played_phase import PlayedPhase, figures_of
from dr_lab.algorithms.meta_algorithm import MetaAlgorithm
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes, every_episode
from dr_lab.algorithms.trpo.policy_rows import policy_rows
from dr_lab.algorithms.trpo.policy_step import PolicyStep
from dr_lab.bounds import Count, at_least, at_most, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.errors import ConfigError
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.policy_stack import PolicyStack
from dr_lab.randomizers.context_source import Proposals
from dr_lab.seeding import derived_seed, stream


class MAML(MetaAlgorithm):
    """Learns θ, and with it what is learnt of α, so that the policies that follow from it by adaptation do well.

    An iteration draws T tasks, contexts of p(z). All slots play a whole episode, an equal share in each task; θ is
    adapted to each task on its own episodes; all slots play again in the same tasks with the policies that came of it;
    and so on up to the last update. Then θ is moved by what the last episodes say.

    A batch of one phase, as a distribution learner hears it, has the keys ``policy`` (the number of the task),
    ``proposal`` (by which the source knows it), ``updates`` (that the policies had had when they played it: 0 before
    the adaptation) and ``updates_left`` (that are still to come: 0 after it).

    Source: Finn et al. 2017, algorithm 3.

    Args:
        interface: what the policy is connected to.
        seed: of the network, actions and tasks.
        actor: makes the policy, from observation width, bounds and seed.
        baseline: gives b_t, fitted anew to the episodes of each task unless it learns.
        adaptation: makes what θ_i follows by, from the policy.
        step: makes what moves θ and α, from these.
        tasks: T.
        slots: episodes side by side, a multiple of T.
        batch_frames: control steps that are collected at once until every slot has ended an episode.
        gamma: discount per control step.
        lam: λ of the advantages; 1 is the return without the baseline's own forecasts.

    Raises:
        ConfigError: a number is out of its range, or the tasks cannot share the slots equally.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., GaussianActor],
        baseline: Baseline,
        adaptation: Callable[[GaussianActor], Adaptation],
        step: Callable[[FlatParameters], PolicyStep],
        tasks: Count,
        slots: Annotated[int, at_least(2)],
        batch_frames: Count,
        gamma: Annotated[float, at_least(0.0), at_most(1.0)],
        lam: Annotated[float, at_least(0.0), at_most(1.0)],
    ) -> None:
        self.baseline, self.tasks, self.slots, self.batch_frames = baseline, tasks, slots, batch_frames
        self.gamma, self.lam = gamma, lam
        require_bounds(self, "algorithm", MAML)
        _require_shares(tasks, slots)
        of, device = (interface.observation, interface.low, interface.high), interface.device
        each = [actor(*of, derived_seed(seed, "task", k)).to(device) for k in range(tasks)]
        self.actor = actor(*of, derived_seed(seed, "actor")).to(device)
        for one in each:
            one.normaliser = self.actor.normaliser
        baseline.begin(device)
        self.adapted_policies = PolicyStack(each)
        self.adaptation = adaptation(self.actor)
        self._like = _learnt(self.actor, self.adaptation)
        self.step = step(FlatParameters(cast(Sequence[torch.nn.Parameter], list(self._like.values()))))
        self.loss = MAMLLoss(self.adaptation, self.step.loss)
        self.rng = stream(seed, "maml")

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The stochastic policy that every adaptation begins with."""
        return {"policy": self.actor}

    @property
    def collecting(self) -> Policy:
        """The policies adapted so far, one a task."""
        return self.adapted_policies

    @property
    def deployed(self) -> Policy:
        """The most likely action of the policy that every adaptation begins with."""
        return self.actor.mean

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play new tasks, before, between and after the updates, and learn from that."""
        phases = self.adapt(experience, experience.propose(self.rng, self.tasks))
        figures = figures_of([phase.returns for phase in phases])
        figures |= self.update(meta_batch([phase.rows for phase in phases]))
        for phase in phases:
            figures |= self.baseline.learn(phase.episodes, phase.to_go)
            self.actor.normaliser.update(phase.observation)
        return figures

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """One step of θ and α; the figures are those of the policies after the adaptation.

        Args:
            batch: a meta-batch as `MAMLLoss` reads it, of the present θ and α.
        """
        policy_at = AdaptedPolicy(self.loss, self._like, batch)
        return {**self.step(policy_at, self.loss.rows_after(batch)), "std": self.actor.log_std.exp().mean().item()}

    def adapt(self, experience: Experience, tasks: Proposals) -> list[PlayedPhase]:
        """Adapt the present policy to some tasks; gives what was played before, between and after the updates.

        Args:
            experience: collects with `collecting`.
            tasks: T of them.
        """
        self.begin_adapting()
        phases = [self.adapt_once(experience, tasks, done) for done in range(self.adaptation.updates)]
        return [*phases, self._play(experience, tasks, self.adaptation.updates)]

    @torch.no_grad()
    def begin_adapting(self) -> None:
        """Let every adapted policy be the present one."""
        theta, _ = self.loss.split(self._like)
        self.adapted_policies.assign(self.adaptation.beginning(theta, self.tasks))

    @torch.no_grad()
    def adapt_once(self, experience: Experience, tasks: Proposals, done: int) -> PlayedPhase:
        """Play some tasks with the adapted policies, and update each of these by what it has played."""
        _, rates = self.loss.split(self._like)
        phase = self._play(experience, tasks, done)
        self.adapted_policies.assign(self.adaptation.updated(self.adapted_policies.stacked(), rates, phase.rows))
        return phase

    @torch.no_grad()
    def _play(self, experience: Experience, tasks: Proposals, updates: int) -> PlayedPhase:
        """One phase: a whole episode in every slot."""
        share = self.slots // self.tasks
        counts = {"updates": updates, "updates_left": self.adaptation.updates - updates}
        labels = {key: np.full(self.slots, count, np.int64) for key, count in counts.items()}
        labels["proposal"] = tasks.keys.repeat(share)
        batch = experience.collect_whole(tasks.z.repeat(share, axis=0), labels)
        first = first_episodes(batch)
        episodes = every_episode(batch, first, self.actor)
        to_go = episodes.returns_to_go(self.gamma)
        of_tasks, wanted = WholeEpisodes(*(self._by_task(field) for field in episodes)), self._by_task(to_go)
        value = vmap(self.baseline)(of_tasks, wanted).flatten(0, 1)
        advantage = self._by_task(episodes.advantages(value, self.gamma, self.lam))
        acted = self.adaptation.acting(self.adapted_policies.stacked(), of_tasks.observation.flatten(1, 2))
        return PlayedPhase(
            policy_rows(of_tasks, acted, advantage), of_tasks, wanted, cast(Tensor, batch["observation"])[first]
        )

    def _by_task(self, values: Tensor) -> Tensor:
        return values.unflatten(0, (self.tasks, -1))

    def explore_anew(self, seed: int) -> None:
        """Draw actions and tasks by other random numbers; the baseline learns by others."""
        super().explore_anew(seed)
        self.baseline.explore_anew(seed)
        self.adapted_policies.reseed(derived_seed(seed, "explore_anew", "adapted"))
        self.rng = stream(seed, "explore_anew", "maml")

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "actor": self.actor.state_dict(),
            "rate": self.adaptation.rate.state_dict(),
            "adapted_policies": self.adapted_policies.state_dict(),
            "baseline": self.baseline.state_dict(),
            "step": self.step.state_dict(),
            "rng": self.rng.bit_generator.state,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.adapted_policies.load_state_dict(state["adapted_policies"])
        self.actor.load_state_dict(state["actor"])
        self.adaptation.rate.load_state_dict(state["rate"])
        self.baseline.load_state_dict(state["baseline"])
        self.step.load_state_dict(state["step"])
        self.rng.bit_generator.state = state["rng"]


def _learnt(actor: GaussianActor, adaptation: Adaptation) -> dict[str, Tensor]:
    """Θ and what is learnt of α, as `MAMLLoss.policy` names them."""
    found = {f"actor.{name}": value for name, value in actor.named_parameters()}
    return {**found, **{f"rate.{name}": value for name, value in adaptation.rate.named_parameters()}}


def _require_shares(tasks: int, slots: int) -> None:
    if slots % tasks:
        raise ConfigError(
            f"algorithm.tasks is {tasks}, which cannot share {slots} episodes equally. Choose a multiple: "
            f"episodes={tasks}, {2 * tasks}, …, or other tasks: algorithm.tasks=…"
        )
