"""REINFORCE: its gradient is that of the expected return, it finds a linear optimum, and it continues exactly."""

from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from continuing import iterating, learn_whole_and_in_parts
from point_mass import INTERFACE, LIMIT, PointCollector, best, mean_reward
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.linear_baseline import LinearBaseline
from dr_lab.algorithms.reinforce.mean_baseline import MeanBaseline
from dr_lab.algorithms.reinforce.reinforce import Reinforce
from dr_lab.algorithms.reinforce.score_function import episode_gradients, score
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes, whole_episodes
from dr_lab.collectors.experience import Experience
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser, RunningNormaliser
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.uniform import UniformRandomizer

STEP, STEPS = 0.3, 4  # x' = x + STEP·a, reward −x'², from x = 1
SLOTS = 16
MEAN, LINEAR = MeanBaseline(), LinearBaseline(ridge=1e-5, horizon=100.0)
GAIN = ContextSpace((Parameter("gain", "1", 1.0, 0.5, 1.5),))


def linear_actor(weight: float = 0.0, bias: float = 0.0, log_std: float = -0.7) -> GaussianActor:
    actor = GaussianActor(1, np.array([-1.0]), np.array([1.0]), 0, NoNormaliser, [], "tanh", log_std)
    with torch.no_grad():
        actor.body.weights[0].fill_(weight)
        actor.body.biases[0].fill_(bias)
    return actor


def noise(*shape: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(1))


def integrators(actor: GaussianActor, count: int) -> WholeEpisodes:
    """Episodes of the integrator, whose state is what is observed."""
    x, course = torch.ones(count, 1), list[tuple[Tensor, Tensor, Tensor]]()
    for draw in noise(STEPS, count, 1):
        action = actor.act(x, draw)
        after = x + STEP * action
        course.append((x, action, -(after[:, 0] ** 2)))
        x = after
    observation, action, reward = (torch.stack(part, 1) for part in zip(*course, strict=True))
    return WholeEpisodes(observation, action, reward, torch.ones_like(reward))


def expected_return(weight: float, bias: float, log_std: float) -> float:
    """E[Σ −x²], from the mean and the variance of x, which are linear in each other."""
    mean, variance, total = 1.0, 0.0, 0.0
    for _ in range(STEPS):
        mean, variance = mean + STEP * (weight * mean + bias), (1 + STEP * weight) ** 2 * variance
        variance += STEP**2 * np.exp(2 * log_std)
        total -= mean**2 + variance
    return total


def within(gradients: Tensor, wanted: list[float], deviations: float = 4.0) -> None:
    """The mean of k episodes' gradients is the wanted one, to so many standard errors of it."""
    error = gradients.std(0) / len(gradients) ** 0.5
    assert ((gradients.mean(0) - torch.tensor(wanted)).abs() <= deviations * error).all()
    assert (error < 0.05 * torch.tensor(wanted).abs().max()).all()


@pytest.mark.parametrize("baseline", [MEAN, LINEAR])
def test_the_gradient_is_that_of_the_expected_return(baseline: Baseline) -> None:
    at = {"log_std": -0.7, "weight": -0.4, "bias": 0.2}
    actor = linear_actor(**at)
    episodes = integrators(actor, 20_000)
    to_go = episodes.returns_to_go(1.0)
    assert to_go[:, 0].mean().item() == pytest.approx(expected_return(**at), rel=0.01)
    gradients = episode_gradients(actor, episodes, to_go - baseline(episodes, to_go))
    assert [name for name, _ in actor.named_parameters()] == ["log_std", "body.weight0", "body.bias0"]
    size = 1e-4
    moved = [[expected_return(**at | {name: at[name] + sign * size}) for sign in (1, -1)] for name in at]
    within(gradients, [(above - below) / (2 * size) for above, below in moved])


def test_the_gradient_of_a_bandit_has_a_closed_form() -> None:
    # Reward −(u − c)² with u ~ N(μ, σ²): E = −(μ − c)² − σ², ∂E/∂μ = −2(μ − c), ∂E/∂log σ = −2σ².
    actor, c = linear_actor(bias=0.5, log_std=-1.0), 1.2
    action = actor.act(torch.zeros(50_000, 1, 1), noise(50_000, 1, 1))
    episodes = WholeEpisodes(torch.zeros_like(action), action, -((action - c) ** 2)[..., 0], torch.ones(50_000, 1))
    to_go = episodes.returns_to_go(0.9)
    gradients = episode_gradients(actor, episodes, to_go - MEAN(episodes, to_go))
    within(gradients, [-2 * np.exp(-2.0), 0.0, -2 * (0.5 - c)])


def test_a_baseline_takes_most_of_the_scatter_away() -> None:
    actor = linear_actor(weight=-0.4)
    episodes = integrators(actor, 2_000)
    to_go = episodes.returns_to_go(1.0)
    scatter = [
        episode_gradients(actor, episodes, to_go - off).var(0).sum().item()
        for off in (torch.zeros_like(to_go), MEAN(episodes, to_go), LINEAR(episodes, to_go))
    ]
    assert scatter[2] < scatter[1] < 0.3 * scatter[0]


def test_the_gradient_of_all_is_the_mean_of_that_of_each() -> None:
    actor = linear_actor(weight=-0.4)
    episodes = integrators(actor, 40)
    advantage = noise(40, STEPS)
    score(dict(actor.named_parameters()), actor, episodes, advantage).backward()
    whole = torch.cat([p.grad.flatten() for p in actor.parameters() if p.grad is not None])
    torch.testing.assert_close(episode_gradients(actor, episodes, advantage).mean(0), whole)


def made(reward: list[list[float]], mask: list[list[float]]) -> WholeEpisodes:
    shape = (len(reward), len(reward[0]), 1)
    return WholeEpisodes(torch.zeros(shape), torch.zeros(shape), torch.tensor(reward), torch.tensor(mask))


def test_returns_to_go_and_their_mean_by_hand() -> None:
    episodes = made([[1.0, 2.0, 4.0], [3.0, 5.0, 0.0], [7.0, 0.0, 0.0]], [[1, 1, 1], [1, 1, 0], [1, 0, 0]])
    to_go = episodes.returns_to_go(0.5)
    assert to_go.tolist() == [[3.0, 4.0, 4.0], [5.5, 5.0, 0.0], [7.0, 0.0, 0.0]]
    alive = MEAN(episodes, to_go) * episodes.mask
    assert alive.tolist() == [[6.25, 5.0, 0.0], [5.0, 4.0, 0.0], [4.25, 0.0, 0.0]]


def test_a_regression_recovers_returns_that_are_linear_in_its_features() -> None:
    observation, mask = noise(30, 8, 2), torch.ones(30, 8)
    mask[3, 5:] = 0
    time = torch.arange(8) / 100.0
    to_go = 2.0 + observation @ torch.tensor([1.0, -3.0]) + 0.5 * observation[..., 0] ** 2 + 40.0 * time
    to_go[3, 5:] = 1e6  # beyond an end, where nothing is learnt
    episodes = WholeEpisodes(observation, torch.zeros(30, 8, 1), torch.zeros(30, 8), mask)
    found = LinearBaseline(ridge=1e-9, horizon=100.0)(episodes, to_go)
    torch.testing.assert_close(found[mask > 0], to_go[mask > 0], atol=2e-2, rtol=0.0)
    assert LINEAR(WholeEpisodes(*(field[:1] for field in episodes)), to_go[:1]).abs().max() == 0.0


@pytest.mark.parametrize("baseline", [MEAN, LINEAR])
def test_an_episodes_baseline_does_not_depend_on_the_episode(baseline: Baseline) -> None:
    episodes = integrators(linear_actor(), 6)
    to_go = episodes.returns_to_go(1.0)
    changed = to_go.clone()
    changed[2] += 100.0
    before, after = baseline(episodes, to_go), baseline(episodes, changed)
    torch.testing.assert_close(before[2], after[2], atol=1e-4, rtol=0.0)
    assert (before - after)[[1, 3]].abs().max() > 1.0


def reinforce(seed: int = 0, **changes: Any) -> Reinforce:  # noqa: ANN401
    normaliser = partial(RunningNormaliser, clip=10.0)
    actor = partial(GaussianActor, normaliser=normaliser, hidden=[], activation="tanh", log_std=-0.5)
    numbers: dict[str, Any] = {"slots": SLOTS, "batch_frames": 80, "gamma": 0.9, "rate": 0.1, "adam_epsilon": 1e-8}
    return Reinforce(INTERFACE, seed, **{"actor": actor, "baseline": MEAN} | numbers | changes)


def experience(algorithm: Reinforce) -> Experience:
    collector = PointCollector(algorithm.policies["policy"], n=SLOTS, steps=5)
    source = UniformRandomizer(GAIN, {})
    return Experience(collector, algorithm.policies["policy"], cast(Any, None), source)


@pytest.mark.parametrize("baseline", [MEAN, pytest.param(LINEAR, marks=pytest.mark.slow)])
def test_reaches_the_optimum_which_is_linear(baseline: Baseline) -> None:
    algorithm = reinforce(baseline=baseline)
    played = experience(algorithm)
    figures = [algorithm.iterate(played) for _ in range(80)][-1]
    assert mean_reward(algorithm.deployed) > mean_reward(best) - 0.03
    assert figures["episodes_learnt"] == SLOTS
    assert 0.0 < figures["std"] < 0.7


def test_one_whole_episode_of_each_slot_is_learnt_from() -> None:
    algorithm = reinforce()
    heard = list[TensorDict]()
    played = experience(algorithm)
    played.listen(heard.append)
    algorithm.iterate(played)
    (batch,) = heard
    assert batch.shape == (SLOTS, LIMIT)
    assert cast(Tensor, batch["context"])[:, 0].unique().numel() == SLOTS
    mask = torch.ones(SLOTS, LIMIT, dtype=torch.bool)
    mask[0, 3:] = False
    batch["next", "infeasible"][0, 5] = True  # in a later episode
    batch["next", "infeasible"][1, 5] = True
    episodes = whole_episodes(batch, mask, algorithm.actor)
    assert len(episodes.reward) == SLOTS - 1
    assert episodes.reward[0, 3:].abs().max() == 0.0


def test_nothing_is_learnt_where_every_context_is_infeasible() -> None:
    algorithm = reinforce()
    batch = experience(algorithm).collect_whole(np.ones((SLOTS, 1)))
    batch["next", "infeasible"][:] = True
    before = algorithm.parameters.vector.clone()
    assert algorithm.update(batch) == {"episodes_learnt": 0.0}
    assert torch.equal(algorithm.parameters.vector, before)


def test_continues_exactly(tmp_path: Path) -> None:
    whole, first, second = reinforce(), reinforce(), reinforce(seed=3)
    learning = [iterating(each, experience(each)) for each in (whole, first, second)]
    learn_whole_and_in_parts(learning, (3, 2), tmp_path)
    assert torch.equal(whole.parameters.vector, second.parameters.vector)


def test_training_on_draws_other_contexts() -> None:
    seen = []
    for seed in (0, 0, 1):
        algorithm = reinforce()
        algorithm.explore_anew(seed)
        seen.append(experience(algorithm).contexts(algorithm.rng, 3).tolist())
    assert seen[0] == seen[1] != seen[2]


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.rate is 0; expected a number above 0\."):
        reinforce(rate=0.0)
