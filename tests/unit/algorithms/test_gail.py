"""GAIL: the loss against its closed form, an expert whom rewards contradict, and exact continuation."""

import copy
from functools import partial
from typing import cast

import numpy as np
import pytest
import torch
from point_mass import INTERFACE, STEP, PointCollector, column, ppo
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.gail.discriminator import ImitationDiscriminator
from dr_lab.algorithms.gail.gail import GAIL
from dr_lab.errors import ConfigError
from dr_lab.experts.expert import Demonstrations, Expert

GOAL = 0.8  # where the expert goes; the task pays for 0


class Goes(Expert):
    """Goes to GOAL on the point mass of gain 1."""

    def __init__(self, width: int = 1) -> None:
        self.width = width

    def demonstrations(self) -> Demonstrations:
        rng, courses = np.random.default_rng(1), list[tuple[Tensor, Tensor]]()
        for _ in range(40):
            x, actions = [rng.uniform(-1.0, 1.0)], list[float]()
            for _ in range(15):
                actions.append(float(np.clip(2.0 * (GOAL - x[-1]) + 0.1 * rng.standard_normal(), -1.0, 1.0)))
                x.append(x[-1] + STEP * actions[-1])
            courses.append((torch.tensor(x)[:, None].expand(-1, self.width), torch.tensor(actions)[:, None]))
        return Demonstrations.of(courses)


def learner(interface: Interface, seed: int) -> Algorithm:
    assert interface is INTERFACE
    return ppo(seed)


def gail(seed: int = 0, width: int = 1) -> GAIL:
    sees = partial(
        ImitationDiscriminator,
        hidden=[32],
        learning_rate=1e-3,
        minibatch=64,
        epochs=2.0,
        gradient_penalty=0.0,
        clip=10.0,
    )
    return GAIL(INTERFACE, seed, learner, Goes(width), sees)


def discriminator(penalty: float) -> ImitationDiscriminator:
    return ImitationDiscriminator(2, 1, 0, [8], 1e-2, 32, 1.0, penalty, 10.0)


@pytest.mark.slow
def test_the_policy_goes_where_the_expert_goes_and_not_where_the_task_pays() -> None:
    torch.manual_seed(0)
    algorithm = gail()
    collector = PointCollector(algorithm.policies["policy"])
    figures = [dict(algorithm.update(next(collector))) for _ in range(60)]
    x = torch.zeros(1, 1)
    for _ in range(15):
        x = x + STEP * algorithm.deployed(x).clamp(-1.0, 1.0)
    assert float(x) == pytest.approx(GOAL, abs=0.2)
    assert figures[-1]["discriminator_accuracy"] < 0.8  # they can hardly be told apart
    assert all(np.isfinite(each["discriminator_loss"]) for each in figures)


def test_the_task_s_return_does_not_choose_what_is_deployed() -> None:
    assert not gail().judged_by_return


def test_the_reward_is_the_papers_and_the_loss_the_two_cross_entropies() -> None:
    found = discriminator(0.0)
    observation, action = torch.randn(64, 2), torch.rand(64, 1)
    belief = found.belief(observation, action)
    torch.testing.assert_close(found.reward(observation, action), -(1.0 - belief).log())
    same = Demonstrations(observation, action, observation, (64,))
    # No opinion, nor anything to learn, where both sides are the same: −2 log ½.
    assert found.learn(same, observation, action) == pytest.approx(2.0 * np.log(2.0), abs=0.02)
    assert found.accuracy(same, observation, action) == pytest.approx(0.5)


@pytest.mark.parametrize("penalty", [0.0, 10.0])
def test_sides_that_differ_are_told_apart(penalty: float) -> None:
    found, generator = discriminator(penalty), torch.Generator().manual_seed(0)
    draws = [torch.randn(512, 2, generator=generator) + shift for shift in (2.0, -2.0)]
    action = torch.zeros(512, 1)
    expert = Demonstrations(draws[0], action, draws[0], (512,))
    losses = [found.learn(expert, draws[1], action) for _ in range(8)]
    assert losses[-1] < losses[0]
    assert found.accuracy(expert, draws[1], action) > 0.95
    assert found.reward(draws[0], action).mean() > found.reward(draws[1], action).mean()


def test_a_batch_keeps_the_rewards_of_the_task() -> None:
    algorithm = gail()
    batch = next(PointCollector(algorithm.policies["policy"]))
    before = cast(Tensor, batch["next", "reward"]).clone()
    algorithm.update(batch)
    assert torch.equal(cast(Tensor, batch["next", "reward"]), before)


def test_training_on_shows_the_discriminator_other_minibatches() -> None:
    batch, learnt = next(PointCollector(gail().policies["policy"])), list[Tensor]()
    for seed in (0, 0, 1):
        algorithm = gail()
        algorithm.explore_anew(seed)
        algorithm.update(batch)
        learnt.append(algorithm.discriminator.belief.body.weights[0].detach())
    assert torch.equal(learnt[0], learnt[1])
    assert not torch.equal(learnt[0], learnt[2])


def test_continues_exactly_and_changes_no_random_numbers_of_torch() -> None:
    algorithm, other = gail(), gail(seed=7)
    collector = PointCollector(algorithm.policies["policy"])
    batches = [next(collector) for _ in range(4)]
    for batch in batches[:2]:
        algorithm.update(batch)
    other.load_state_dict(copy.deepcopy(algorithm.state_dict()))
    state = torch.get_rng_state()
    for batch in batches[2:]:
        assert dict(algorithm.update(batch)) == dict(other.update(batch))
    assert torch.equal(torch.get_rng_state(), state)
    probe = column(np.linspace(-1.0, 1.0, 9))
    assert torch.equal(algorithm.deployed(probe), other.deployed(probe))


def test_an_expert_of_another_task_is_refused() -> None:
    algorithm = gail(width=3)
    with pytest.raises(ConfigError, match="sees 3 numbers and does 1; the policy that is trained sees 1"):
        algorithm.update(next(PointCollector(algorithm.policies["policy"])))


def test_an_algorithm_that_collects_in_its_own_way_is_refused() -> None:
    class Collects(Algorithm):
        batch_frames = 1

        def iterate(self, experience: object) -> dict[str, float]:
            return {}

    own = type("Own", (Collects,), dict.fromkeys(Algorithm.__abstractmethods__))
    with pytest.raises(ConfigError, match=r"algorithm@algorithm\.learner=ppo or ddpg"):
        GAIL(INTERFACE, 0, lambda *_: own(), Goes(), lambda *_: discriminator(0.0))
