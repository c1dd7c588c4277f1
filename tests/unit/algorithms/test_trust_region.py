"""TRPO: conjugate gradients against a dense solve, the exact Hessian of the divergence, a bound that holds."""

from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from continuing import iterating, learn_whole_and_in_parts
from point_mass import INTERFACE, LIMIT, PointCollector, best, mean_reward
from torch import Tensor
from torch.distributions import Independent, Normal, kl_divergence

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.critic_baseline import CriticBaseline
from dr_lab.algorithms.reinforce.linear_baseline import LinearBaseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.algorithms.trpo.clipped_step import ClippedStep
from dr_lab.algorithms.trpo.conjugate_gradients import conjugate_gradients
from dr_lab.algorithms.trpo.divergence_product import divergence_product
from dr_lab.algorithms.trpo.own_policy import OwnPolicy
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean_divergence, policy_rows
from dr_lab.algorithms.trpo.policy_step import PolicyStep
from dr_lab.algorithms.trpo.trpo import TRPO
from dr_lab.algorithms.trpo.trust_region import TrustRegion
from dr_lab.collectors.experience import Experience
from dr_lab.errors import ConfigError
from dr_lab.networks.critic import Critic
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian, divergence
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.uniform import UniformRandomizer

REGION = {"max_kl": 0.01, "iterations": 10, "tolerance": 1e-10, "damping": 1e-5}
REGION |= {"hessian_every": 1, "trials": 15, "shrink": 0.8}
LINEAR = LinearBaseline(ridge=1e-5, horizon=100.0)
GAIN = ContextSpace((Parameter("gain", "1", 1.0, 0.5, 1.5),))
SLOTS = 32


def draw(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def test_conjugate_gradients_give_what_a_dense_solve_gives() -> None:
    factor = draw(40, 40)
    matrix, wanted = factor @ factor.T + torch.eye(40), draw(40, seed=1)
    found = conjugate_gradients(lambda v: matrix @ v, wanted, 200, 1e-12).found
    torch.testing.assert_close(found, torch.linalg.solve(matrix, wanted), rtol=1e-8, atol=1e-8)


def test_conjugate_gradients_end_with_as_many_products_as_there_are_eigenvalues() -> None:
    basis = torch.linalg.qr(draw(30, 30)).Q
    matrix = basis @ torch.diag(torch.tensor([1.0, 4.0, 9.0] * 10, dtype=torch.float64)) @ basis.T
    products = list[Tensor]()

    def product(vector: Tensor) -> Tensor:
        products.append(vector)
        return matrix @ vector

    wanted = draw(30, seed=1)
    solved = conjugate_gradients(product, wanted, 30, 1e-10)
    assert len(products) == 3
    torch.testing.assert_close(matrix @ solved.found, wanted)
    torch.testing.assert_close(solved.image, wanted)


def test_conjugate_gradients_keep_what_they_had_before_a_direction_that_curves_down() -> None:
    assert not conjugate_gradients(lambda v: -v, draw(3), 10, 0.0).found.any()


def test_the_divergence_is_that_of_torch() -> None:
    one, other = Gaussian(draw(5, 3), 0.3 * draw(3, seed=1)), Gaussian(draw(5, 3, seed=2), 0.3 * draw(3, seed=3))
    first, second = (Independent(Normal(each.mean, each.log_std.exp()), 1) for each in (one, other))
    torch.testing.assert_close(divergence(one, other), kl_divergence(first, second))


def actor(hidden: list[int] | None = None) -> GaussianActor:
    bound = np.ones(2)
    return GaussianActor(3, -bound, bound, 0, NoNormaliser, hidden or [5], "tanh", log_std=-0.3).double()


def rows_of(policy: GaussianActor) -> tuple[dict[str, Tensor], Tensor, PolicyRows]:
    """Episodes of which some end early; parameters, the same as a vector, and rows."""
    like = {name: value.detach() for name, value in policy.named_parameters()}
    mask = torch.ones(4, 6, dtype=torch.float64)
    mask[1, 4:], mask[3] = 0.0, 0.0
    episodes = WholeEpisodes(draw(4, 6, 3), draw(4, 6, 2, seed=1), draw(4, 6, seed=2), mask)
    acted = policy.distribution(like, episodes.observation.flatten(0, 1))
    rows = policy_rows(episodes, Gaussian(acted.mean, acted.log_std[None]), draw(4, 6, seed=3))
    return like, torch.cat([value.flatten() for value in like.values()]), rows


def test_rows_that_count_are_standardised_and_weigh_alike() -> None:
    _, _, rows = rows_of(actor())
    assert rows.weight.sum().item() == pytest.approx(1.0)
    assert rows.weight.unique().tolist() == pytest.approx([0.0, 1.0 / 16])
    known = rows.advantage[rows.weight > 0]
    assert known.mean().item() == pytest.approx(0.0, abs=1e-12)
    assert known.std(correction=0).item() == pytest.approx(1.0)
    assert not rows.advantage[rows.weight == 0].any()


def test_fewer_rows_weigh_as_much_as_all() -> None:
    _, _, rows = rows_of(actor())
    fewer = rows.thinned(5)
    assert fewer.weight.sum().item() == pytest.approx(1.0)
    assert fewer.weight.tolist() == pytest.approx([1 / 3, 1 / 3, 0.0, 1 / 3, 0.0])  # row 10 is beyond an end, 20 too
    assert torch.equal(fewer.action, rows.action[[0, 5, 10, 15, 20]])
    nothing = rows._replace(weight=torch.zeros_like(rows.weight)).thinned(5)
    assert not nothing.weight.any()


def test_the_product_is_that_of_the_dense_hessian_of_the_divergence() -> None:
    policy = actor()
    like, vector, rows = rows_of(policy)
    policy_at = OwnPolicy(policy, like, rows.observation)
    dense = torch.autograd.functional.hessian(lambda at: mean_divergence(policy_at(at), rows), vector)
    product = divergence_product(policy_at.linearised(vector), rows)
    found = torch.stack([product(unit) for unit in torch.eye(len(vector), dtype=torch.float64)])
    torch.testing.assert_close(found, cast(Tensor, dense), rtol=1e-8, atol=1e-10)


def trpo(seed: int = 0, baseline: Baseline = LINEAR, step: Any = None, **changes: Any) -> TRPO:  # noqa: ANN401
    make = partial(GaussianActor, normaliser=NoNormaliser, hidden=[16], activation="tanh", log_std=-0.5)
    region = partial(TrustRegion, **REGION) if step is None else step
    numbers: dict[str, Any] = {"slots": SLOTS, "batch_frames": SLOTS * LIMIT, "gamma": 0.9, "lam": 0.97}
    return TRPO(INTERFACE, seed, make, baseline, region, **numbers | changes)


def critic(rate: float = 3e-3) -> CriticBaseline:
    make = partial(Critic, hidden=[16], activation="tanh")
    return CriticBaseline(make, seed=0, epochs=10, minibatch=64, rate=rate, adam_epsilon=1e-8)


def clipped() -> partial[PolicyStep]:
    return partial(ClippedStep, clip=0.2, epochs=10, rate=3e-3, max_gradient=0.5, max_kl=0.05, adam_epsilon=1e-8)


def experience(algorithm: TRPO) -> Experience:
    collector = PointCollector(algorithm.policies["policy"], n=SLOTS, steps=LIMIT)
    return Experience(collector, algorithm.policies["policy"], cast(Any, None), UniformRandomizer(GAIN, {}))


@pytest.mark.parametrize("every", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_the_bound_holds_at_every_step_and_the_optimum_is_reached(every: int) -> None:
    """At the optimum a step as long as the bound only wanders about it, so the best policy on the way is asked."""
    algorithm = trpo(step=partial(TrustRegion, **REGION | {"max_kl": 0.05, "hessian_every": every}))
    played, figures, rewards = experience(algorithm), list[dict[str, float]](), list[float]()
    for _ in range(40):
        figures.append(dict(algorithm.iterate(played)))
        rewards.append(mean_reward(algorithm.deployed))
    assert all(0.0 <= each["kl"] <= 0.05 for each in figures)
    assert np.mean([each["improvement"] > 0.0 for each in figures]) > 0.6
    assert max(each["kl"] for each in figures) > 0.02  # while there is far to go the bound is made use of
    assert max(rewards) > mean_reward(best) - 0.05


def test_nothing_moves_where_no_action_is_better_than_another() -> None:
    policy = actor()
    like, vector, rows = rows_of(policy)
    parameters = FlatParameters(policy.parameters())
    step = TrustRegion(parameters, **REGION)
    equal = rows._replace(advantage=torch.zeros_like(rows.advantage))
    figures = step(OwnPolicy(policy, like, rows.observation), equal)
    assert figures["kl"] == figures["gradient"] == 0.0
    assert torch.equal(parameters.vector, vector)


def test_the_figures_of_a_clipped_step_are_of_the_policy_that_it_leads_to() -> None:
    policy = actor()
    like, _, rows = rows_of(policy)
    parameters, policy_at = FlatParameters(policy.parameters()), OwnPolicy(policy, like, rows.observation)
    step = ClippedStep(parameters, clip=0.2, epochs=1, rate=0.01, max_gradient=0.5, max_kl=None, adam_epsilon=1e-8)
    before = step.loss(policy_at(parameters.vector), rows)
    figures = step(policy_at, rows)
    after = policy_at(parameters.vector)
    assert figures["kl"] == pytest.approx(mean_divergence(after, rows).item()) != 0.0
    assert figures["improvement"] == pytest.approx((before - step.loss(after, rows)).item())
    assert figures["improvement"] > 0.0
    assert figures["epochs"] == 1.0


@pytest.mark.parametrize("baseline", [LINEAR, pytest.param(critic(), marks=pytest.mark.slow)])
def test_the_clipped_step_learns_too(baseline: Baseline) -> None:
    algorithm = trpo(baseline=baseline, step=clipped())
    played = experience(algorithm)
    before = mean_reward(algorithm.deployed)
    figures = [algorithm.iterate(played) for _ in range(30)]
    assert mean_reward(algorithm.deployed) > before + 0.5 * (mean_reward(best) - before)
    assert all(each["epochs"] >= 1 for each in figures)


def test_a_critic_explains_returns_that_depend_on_what_is_observed() -> None:
    baseline = critic(rate=1e-2)
    observation = draw(40, 8, 1).float()
    wanted = 50.0 + 20.0 * observation[..., 0] ** 2
    episodes = WholeEpisodes(observation, observation, wanted, torch.ones(40, 8))
    assert not baseline(episodes, wanted).any()
    for _ in range(20):
        baseline.learn(episodes, wanted)
    assert ((baseline(episodes, wanted) - wanted).var() / wanted.var()).item() < 0.02


@pytest.mark.parametrize("lam", [0.0, 0.97, 1.0])
def test_a_baseline_that_has_learnt_nothing_explains_nothing(lam: float) -> None:
    """Whatever λ is: that rewards scatter less than returns is not the baseline's doing."""
    algorithm = trpo(baseline=critic(), lam=lam)
    assert algorithm.iterate(experience(algorithm))["explained"] == 0.0


def test_training_on_takes_a_critic_s_samples_in_another_order() -> None:
    observation = draw(40, 8, 1).float()
    episodes = WholeEpisodes(observation, observation, observation[..., 0], torch.ones(40, 8))
    learnt = list[Tensor]()
    for seed in (0, 0, 1):
        algorithm = trpo(baseline=critic(), step=clipped())
        algorithm.explore_anew(seed)
        algorithm.baseline.learn(episodes, episodes.reward)
        learnt.append(algorithm.baseline.state_dict()["learner"]["vector"])
    assert torch.equal(learnt[0], learnt[1])
    assert not torch.equal(learnt[0], learnt[2])


@pytest.mark.parametrize("make", [trpo, lambda seed=0: trpo(seed, baseline=critic(), step=clipped())])
def test_continues_exactly(make: Any, tmp_path: Any) -> None:  # noqa: ANN401
    whole, first, second = make(), make(), make(seed=3)
    learning = [iterating(each, experience(each)) for each in (whole, first, second)]
    learn_whole_and_in_parts(learning, (3, 2), tmp_path)
    assert torch.equal(whole.step.parameters.vector, second.step.parameters.vector)


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.step\.max_kl is 0; expected a number above 0\."):
        trpo(step=partial(TrustRegion, **REGION | {"max_kl": 0.0}))
    with pytest.raises(ConfigError, match=r"algorithm\.lam is 2; expected at most 1\."):
        trpo(lam=2.0)
