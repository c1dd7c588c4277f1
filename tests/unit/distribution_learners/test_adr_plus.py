"""ADR+ in a world whose contexts move alike on either side of ½: it seeks the side that its expert comes from."""

import copy
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from differing_dynamics import HARD, LENGTH, SPACE, DifferingCollector, DifferingExperience, moved
from torch import Tensor

from dr_lab.distribution_learners.adr.adr import ADR
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.adr_plus.adr_plus import ADRPlus
from dr_lab.distribution_learners.adr_plus.prior_particles import PriorParticles
from dr_lab.distribution_learners.svpg.particles import Particles
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.distribution_learners.svpg.walk import Walk, WalkStep
from dr_lab.errors import ConfigError
from dr_lab.experts.expert import Demonstrations, Expert
from dr_lab.randomizers.empirical import EmpiricalRandomizer


class DifferingExpert(Expert):
    """Acts at random, as the policy does, in one context."""

    def __init__(self, z: float, shown: bool = False) -> None:
        self.z, self.shown = z, shown

    def demonstrations(self) -> Demonstrations:
        rng, courses = np.random.default_rng(5), list[tuple[Tensor, Tensor]]()
        for _ in range(100):
            x, action = [np.array(rng.uniform(-1.0, 1.0))], rng.standard_normal(LENGTH)
            for a in action:
                x.append(moved(x[-1], a, np.array(self.z)))
            seen = torch.tensor(np.array(x))[:, None]
            courses.append(
                (torch.cat([seen, seen * 0 + self.z], 1) if self.shown else seen, torch.tensor(action)[:, None])
            )
        return Demonstrations.of(courses)


def parts(particles: Any) -> tuple[EmpiricalRandomizer, Any, Any]:  # noqa: ANN401
    walk = partial(Walk, max_step=0.05, horizon=50)
    svpg = partial(SVPG, count=5, proposals=4, walk=walk, particles=particles, learning_rate=3e-3, temperature=10.0)
    sees = partial(Discriminator, hidden=[32, 32], learning_rate=3e-3, minibatch=64, epochs=2.0, clip=10.0)
    return EmpiricalRandomizer(SPACE, None, window=5000, bins=10), svpg, sees


def finished() -> dict[str, Any]:
    randomizer, svpg, sees = parts(partial(Particles, hidden=[16, 16], gamma=0.99))
    return ADR(randomizer, 3, svpg, sees, context_shown=False, inherits=[], reference_load=8).state_dict()


def adr_plus(z: float, penalty: float = 0.1, *, seed: int = 0, expert_is_shown: bool = False) -> ADRPlus:
    randomizer, svpg, sees = parts(partial(PriorParticles, hidden=[16, 16], gamma=0.99, penalty=penalty))
    expert = DifferingExpert(z, expert_is_shown)
    return ADRPlus(randomizer, seed, svpg, sees, context_shown=False, inherits=["particles"], expert=expert)


def share_of_hard(learner: ADRPlus, rounds: int) -> float:
    torch.manual_seed(0)
    collector = DifferingCollector(learner.source)
    experience, done = DifferingExperience(collector), 0
    while done < rounds:
        done += bool(learner.update(next(collector), experience))
    assert not experience.contexts_played  # the reference is the expert's, which is not played
    late = learner.randomizer.sample([np.random.default_rng(0)] * 2000)
    return float((late > HARD).mean())


@pytest.mark.slow
@pytest.mark.parametrize(("z", "expected"), [(0.8, (0.6, 1.0)), (0.2, (0.0, 0.4))])
def test_contexts_like_the_experts_are_proposed_more_often(z: float, expected: tuple[float, float]) -> None:
    learner = adr_plus(z)
    learner.inherit(finished())
    low, high = expected
    assert low < share_of_hard(learner, 250) < high


@pytest.mark.slow
def test_a_large_penalty_keeps_the_particles_where_the_prior_is() -> None:
    moved_by = dict[float, float]()
    for penalty in (0.0, 100.0):
        learner = adr_plus(0.8, penalty)
        learner.inherit(finished())
        share_of_hard(learner, 60)
        particles = cast(PriorParticles, learner._svpg.particles)
        u = torch.linspace(0.0, 1.0, 11).expand(5, 11)[..., None]
        particles.penalty = 1.0
        moved_by[penalty] = float(particles.cost(u).detach().mean())
    assert moved_by[100.0] < 0.2 * moved_by[0.0]


def test_the_gradient_of_the_cost_is_that_of_the_divergence() -> None:
    generator = torch.Generator().manual_seed(0)
    particles = PriorParticles(2, 1, generator, hidden=[4], gamma=0.9, penalty=0.7)
    others = Particles(2, 1, generator, hidden=[4], gamma=0.9)
    particles.inherit(others.state_dict())
    assert particles.cost(torch.rand(2, 3, 1)).detach().abs().max() < 1e-6  # nothing at first: each begins as its prior
    with torch.no_grad():
        particles.actors.rows.data += 0.1 * torch.randn(particles.actors.rows.shape, generator=generator)
    u, action = torch.rand(2, 1, generator=generator), torch.randn(2, 1, generator=generator)
    steps = [WalkStep(u, action, u, torch.ones(2, dtype=torch.bool))]
    found = particles.gradients(steps, torch.zeros(2, 1)).actor
    cost, known = particles.cost(u[:, None]), particles.values(u[:, None])
    advantage = (-cost + 0.9 * known - known).detach()
    expected = (particles.policy(u[:, None]).log_prob(action[:, None]) * advantage).sum()
    (score,) = torch.autograd.grad(expected, particles.actors.rows)
    delta, rows = 1e-3, particles.actors.rows
    for place in [(0, 0), (1, 5), (1, rows.shape[1] - 1)]:
        with torch.no_grad():
            ends = []
            for sign in (1, -1):
                rows[place] += sign * delta
                ends.append(particles.cost(u[:, None]).sum())
                rows[place] -= sign * delta
        slope = (ends[0] - ends[1]) / (2 * delta)
        assert found[place] == pytest.approx(float(score[place] - slope), abs=2e-3)


def test_without_a_prior_it_says_what_to_give() -> None:
    learner = adr_plus(0.8)
    collector = DifferingCollector(learner.source)
    with pytest.raises(ConfigError, match="init=FOLDER init_distribution=true"):
        learner.update(next(collector), DifferingExperience(collector))


def test_an_expert_that_sees_something_else_is_refused() -> None:
    learner = adr_plus(0.8, expert_is_shown=True)
    learner.inherit(finished())
    with pytest.raises(ConfigError, match="5 numbers, those of the policy that is trained 3"):
        share_of_hard(learner, 1)


def test_continues_exactly() -> None:
    first, second = adr_plus(0.8), adr_plus(0.8, seed=5)
    first.inherit(finished())
    share_of_hard(first, 3)
    second.load_state_dict(copy.deepcopy(first.state_dict()))
    found = list[float]()
    for learner in (first, second):
        torch.manual_seed(1)
        collector = DifferingCollector(learner.source, seed=4)
        experience, figures = DifferingExperience(collector), dict[str, float]()
        while not figures:
            figures = dict(learner.update(next(collector), experience))
        found.append(figures["particle_spread"])
    assert found[0] == found[1]
