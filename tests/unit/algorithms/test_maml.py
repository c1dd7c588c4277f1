"""MAML on points with hidden goals: one update learns to help, tasks keep to themselves, and it continues exactly."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from continuing import iterating, learn_whole_and_in_parts
from point_goals import GOALS, INTERFACE, GoalCollector
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.maml.adaptation import Adaptation
from dr_lab.algorithms.maml.inner_loss import ClippedLoss, ScoreLoss
from dr_lab.algorithms.maml.inner_rate import FixedRate, LearnedRate
from dr_lab.algorithms.maml.maml import MAML
from dr_lab.algorithms.maml.played_phase import figures_of
from dr_lab.algorithms.reinforce.critic_baseline import CriticBaseline
from dr_lab.algorithms.reinforce.linear_baseline import LinearBaseline
from dr_lab.algorithms.reinforce.mean_baseline import MeanBaseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.algorithms.trpo.clipped_step import ClippedStep
from dr_lab.algorithms.trpo.trust_region import TrustRegion
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.errors import ConfigError
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser, RunningNormaliser
from dr_lab.networks.policy_stack import GaussianPolicyStack
from dr_lab.randomizers.context_source import Proposals
from dr_lab.randomizers.uniform import UniformRandomizer

TASKS, SHARE, LIMIT = 8, 10, 15
REGION = {"max_kl": 0.01, "iterations": 10, "tolerance": 1e-5, "damping": 1e-5}
REGION |= {"hessian_every": 1, "trials": 15, "shrink": 0.8}
CLIPPED = {"clip": 0.3, "epochs": 5, "rate": 3e-3, "max_gradient": 0.5, "max_kl": None, "adam_epsilon": 1e-8}


def maml(seed: int = 0, updates: int = 1, order: int = 2, normaliser: Any = NoNormaliser, **changes: Any) -> MAML:  # noqa: ANN401
    actor = partial(GaussianActor, normaliser=normaliser, hidden=[16], activation="tanh", log_std=0.0)
    rate = partial(FixedRate, rate=0.2)
    parts: dict[str, Any] = {
        "actor": actor,
        "baseline": LinearBaseline(ridge=1e-5, horizon=100.0),
        "adaptation": partial(Adaptation, loss=ScoreLoss(), rate=rate, updates=updates, order=order),
        "step": partial(TrustRegion, **REGION),
        "tasks": TASKS,
        "slots": TASKS * SHARE,
        "batch_frames": TASKS * SHARE * LIMIT,
        "gamma": 0.99,
        "lam": 1.0,
    }
    return MAML(INTERFACE, seed, **parts | changes)


def experience(algorithm: MAML, fatal: float = np.inf) -> Experience:
    collector = GoalCollector(algorithm.collecting, algorithm.slots, LIMIT, fatal)
    return Experience(collector, algorithm.policies["policy"], cast(Any, None), UniformRandomizer(GOALS, {}))


def tasks(seed: int = 0) -> Proposals:
    rng = np.random.default_rng(seed)
    return Proposals(rng.uniform(-0.5, 0.5, (TASKS, 2)), np.arange(100, 100 + TASKS))


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 5])
def test_an_update_learns_to_help(every: int) -> None:
    algorithm = maml(step=partial(TrustRegion, **REGION | {"hessian_every": every}))
    played = experience(algorithm)
    figures = [algorithm.iterate(played) for _ in range(40)]
    first, last = (
        {key: np.mean([each[key] for each in part]) for key in ("gain", "return_after_0", "return_after_1")}
        for part in (figures[:5], figures[-5:])
    )
    assert last["gain"] > 1.0
    assert last["gain"] > first["gain"] + 0.5
    assert last["return_after_1"] > first["return_after_1"] + 2.0
    assert all(each["kl"] <= 0.01 for each in figures)


def critic() -> CriticBaseline:
    make = partial(Critic, hidden=[16], activation="tanh")
    return CriticBaseline(make, 0, epochs=2, minibatch=64, rate=1e-3, adam_epsilon=1e-8)


META_SGD = partial(Adaptation, loss=ClippedLoss(0.3), rate=partial(LearnedRate, rate=0.2), updates=1, order=2)
KINDS: dict[str, Callable[..., MAML]] = {
    "ppo": partial(maml, step=partial(ClippedStep, **CLIPPED)),
    "first order": partial(maml, baseline=MeanBaseline(), order=1),
    "two updates": partial(maml, updates=2, normaliser=partial(RunningNormaliser, clip=10.0)),
    "critic": lambda seed=0: maml(seed, baseline=critic(), adaptation=META_SGD),
}


@pytest.mark.parametrize("kind", KINDS)
def test_continues_exactly(kind: str, tmp_path: Path) -> None:
    make = KINDS[kind]
    whole, first, second = make(), make(), make(seed=3)
    learning = [iterating(each, experience(each)) for each in (whole, first, second)]
    figures = cast(dict[str, float], learn_whole_and_in_parts(learning, (2, 2), tmp_path)[-1])
    assert torch.equal(whole.step.parameters.vector, second.step.parameters.vector)
    assert figures["tasks_learnt"] == TASKS
    assert np.isfinite(list(figures.values())).all()


def test_every_phase_is_played_in_the_same_tasks_and_told_apart() -> None:
    algorithm = maml(updates=2)
    played, heard = experience(algorithm), list[TensorDict]()
    played.listen(heard.append)
    phases = algorithm.adapt(played, tasks())
    assert [batch["updates"].unique().tolist() for batch in heard] == [[0], [1], [2]]
    assert sum(batch.numel() for batch in heard) == 3 * TASKS * SHARE * LIMIT
    for batch, phase in zip(heard, phases, strict=True):
        assert torch.equal(batch["policy"][:, 0], torch.arange(TASKS).repeat_interleave(SHARE))
        assert torch.equal(batch["proposal"], batch["policy"] + 100)
        torch.testing.assert_close(batch["context"][::SHARE, 0], torch.from_numpy(tasks().z).float())
        assert torch.equal(phase.rows.observation, batch["observation"].reshape(TASKS, SHARE * LIMIT, 2))
        returns = cast(Tensor, batch["next", "reward"]).sum((1, 2)).reshape(TASKS, SHARE).mean(1)
        torch.testing.assert_close(phase.returns, returns)


def test_the_policies_that_played_are_those_that_the_rows_say() -> None:
    algorithm = maml(updates=2)
    played, heard = experience(algorithm), list[TensorDict]()
    played.listen(heard.append)
    phases = algorithm.adapt(played, tasks())
    members = cast(list[GaussianActor], list(algorithm.adapted_policies.policies))
    stack = GaussianPolicyStack(members)  # as they were last
    wanted = stack.log_prob(heard[-1]["observation"], heard[-1]["action"]).reshape(TASKS, -1)
    rows = phases[-1].rows
    found = rows.acted.log_prob(rows.action) - algorithm.actor.reach.log().sum()
    torch.testing.assert_close(found, wanted, rtol=1e-4, atol=1e-4)
    assert (phases[0].rows.log_std == phases[0].rows.log_std[:1]).all()
    assert (rows.log_std != rows.log_std[:1]).any()


def test_a_tasks_adaptation_depends_on_its_own_episodes_alone() -> None:
    algorithm = maml()
    rows = algorithm.adapt(experience(algorithm), tasks())[0].rows
    theta, rates = algorithm.loss.split(algorithm.loss.functional_parameters())
    begin = algorithm.adaptation.beginning(theta, TASKS)
    together = algorithm.adaptation.updated(begin, rates, rows)
    changed = rows.advantage.clone()
    changed[3] *= 2.0
    other = algorithm.adaptation.updated(begin, rates, rows._replace(advantage=changed))
    for name, value in together.items():
        moved = (other[name] != value).flatten(1).any(1)
        assert moved.tolist() == [k == 3 for k in range(TASKS)], name
        step, twice = value - begin[name], other[name] - begin[name]
        torch.testing.assert_close(twice[3], 2.0 * step[3])


def test_baselines_are_fitted_to_each_task_alone() -> None:
    baseline = LinearBaseline(ridge=1e-5, horizon=100.0)
    algorithm = maml(baseline=baseline)
    phase = algorithm.adapt(experience(algorithm), tasks())[0]
    for k in range(TASKS):
        episodes = WholeEpisodes(*(field[k] for field in phase.episodes))
        advantage = phase.to_go[k] - baseline(episodes, phase.to_go[k])
        wanted = (advantage - advantage.mean()) / advantage.std(correction=0)
        torch.testing.assert_close(phase.rows.advantage[k], wanted.flatten(), rtol=1e-3, atol=1e-3)


def test_infeasible_tasks_leave_the_policy_as_it_is_and_are_not_counted() -> None:
    algorithm = maml()
    played, heard = experience(algorithm, fatal=0.0), list[TensorDict]()
    played.listen(heard.append)
    given = tasks()
    fatal = given.z[:, 0] > 0.0
    assert 0 < fatal.sum() < TASKS
    phases = algorithm.adapt(played, given)
    assert phases[0].returns.isnan().tolist() == fatal.tolist()
    assert first_episodes(heard[0]).sum(1).reshape(TASKS, SHARE)[torch.from_numpy(fatal)].unique().tolist() == [1]
    kept = phases[-1].rows.log_std[:, 0] == algorithm.actor.log_std
    assert kept.all(1).tolist() == fatal.tolist()
    figures = algorithm.iterate(played)
    assert figures["tasks_learnt"] < TASKS
    assert np.isfinite(list(figures.values())).all()


def test_nothing_is_learnt_where_every_task_is_infeasible() -> None:
    algorithm = maml()
    before = algorithm.step.parameters.vector.clone()
    figures = algorithm.iterate(experience(algorithm, fatal=-1.0))
    assert figures["tasks_learnt"] == 0.0
    assert torch.equal(algorithm.step.parameters.vector, before)


def test_gains_are_told_by_hand() -> None:
    found = figures_of([torch.tensor([1.0, 5.0, np.nan]), torch.tensor([4.0, 4.0, 7.0])])
    assert found == {
        "tasks_learnt": 2.0, "return_after_0": 3.0, "return_after_1": 4.0, "gain": 1.0, "negative_adaptation": 0.5
    }  # fmt: skip


def test_training_on_draws_other_tasks_actions_and_samples_of_the_critic() -> None:
    seen = []
    for seed in (0, 0, 1):
        algorithm = maml(baseline=critic())
        algorithm.explore_anew(seed)
        phase = algorithm.adapt(experience(algorithm), experience(algorithm).propose(algorithm.rng, TASKS))[0]
        order = algorithm.baseline.state_dict()["generator"].tolist()
        seen.append((cast(Tensor, phase.rows.action).flatten()[:5].tolist(), order))
    assert seen[0] == seen[1]
    assert all(one != other for one, other in zip(seen[0], seen[2], strict=True))


def test_tasks_that_cannot_share_the_slots_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.tasks is 8, which cannot share 81 episodes equally"):
        maml(slots=81)
