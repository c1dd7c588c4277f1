"""DiDoR, its ensemble and peers on the point mass, whose gain is the domain."""

from collections.abc import Callable
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from playing import Uniform
from point_mass import INTERFACE, PointCollector, actor, best, mean_reward, ppo_arguments
from pretended_experience import PretendedExperience
from settings import setting
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.didor.didor import DiDoR
from dr_lab.algorithms.didor.distillation import Distillation
from dr_lab.algorithms.ensemble.ensemble import Ensemble
from dr_lab.algorithms.p2pdrl.p2pdrl import P2PDRL
from dr_lab.algorithms.p2pdrl.peer_surrogate import PeerSurrogate
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.ppo_stack import PPOStack
from dr_lab.algorithms.teachers.teachers import Teachers
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian import Gaussian, divergence
from dr_lab.trajectory import Array

SLOTS, BATCH = 32, 32 * 30


def feasible(z: Array) -> Array:
    return np.zeros(len(z))


def learner(interface: object, seed: int, **changes: Any) -> PPO:  # noqa: ANN401
    del interface
    return PPO(**ppo_arguments(seed=seed, **changes))


def teachers(count: int = 2) -> partial[Teachers]:
    return partial(Teachers, learner=learner, count=count, slots=SLOTS)


def didor(seed: int = 0, **changes: Any) -> DiDoR:  # noqa: ANN401
    distillation = partial(Distillation, epochs=10, minibatch=60, rate=3e-3, adam_epsilon=1e-8)
    own = {"teacher_frames": 10 * BATCH, "frames": 20 * BATCH, "batch_frames": BATCH} | changes
    return DiDoR(INTERFACE, seed, teachers(), actor(), distillation, **own)


def ensemble(seed: int = 0) -> Ensemble:
    return Ensemble(INTERFACE, seed, teachers(), BATCH)


def p2pdrl(seed: int = 0, alpha: float = 0.05) -> P2PDRL:
    return P2PDRL(INTERFACE, seed, learner, workers=2, alpha=alpha, slots=SLOTS, batch_frames=BATCH)


def experience(algorithm: Algorithm, returns: Callable[[Array], Array] = feasible) -> PretendedExperience:
    source = Uniform(np.array([0.5]), np.array([1.5]))
    return PretendedExperience(returns, PointCollector(algorithm.collecting, n=SLOTS), source)


@pytest.mark.parametrize("made", [didor, *(pytest.param(made, marks=pytest.mark.slow) for made in (ensemble, p2pdrl))])
def test_reaches_the_optimum(made: Callable[[], Algorithm]) -> None:
    algorithm = made()
    assert mean_reward(algorithm.deployed) < mean_reward(best) - 0.2
    seen = experience(algorithm)
    for _ in range(20):
        algorithm.iterate(seen)
    assert mean_reward(algorithm.deployed) > mean_reward(best) - 0.03


def test_the_teachers_learn_first_each_in_its_own_domain_then_the_student_in_those_of_all() -> None:
    algorithm = didor(teacher_frames=3 * BATCH)
    seen, batches = experience(algorithm), []
    seen.listen(batches.append)
    before = algorithm.student.body.weights[0].detach().clone()
    for _ in range(3):
        assert "worst_teacher" in algorithm.iterate(seen)
    assert torch.equal(algorithm.student.body.weights[0], before)
    taught = algorithm.teachers.state_dict()["members"]
    frozen = [each["actor"]["body.weight0"].clone() for each in taught]
    for _ in range(2):
        assert "distillation" in algorithm.iterate(seen)
    assert not torch.equal(algorithm.student.body.weights[0], before)
    for each, weight in zip(algorithm.teachers.members, frozen, strict=True):
        assert torch.equal(each.actor.body.weights[0], weight)
    assert algorithm.domains is not None
    z = torch.from_numpy(algorithm.domains).float().repeat_interleave(SLOTS // 2, 0)
    for batch in batches:
        assert torch.equal(batch["context"], z[:, None].expand(-1, batch.shape[1], -1))


@pytest.mark.slow
def test_a_student_of_teachers_that_are_the_same_becomes_their_copy() -> None:
    algorithm = didor(teacher_frames=0, frames=40 * BATCH)
    one, other = algorithm.teachers.members
    torch.nn.init.normal_(one.actor.body.weights[-1], generator=torch.Generator().manual_seed(1))
    other.actor.load_state_dict(one.actor.state_dict())
    algorithm.teachers.acting.refresh()
    seen = experience(algorithm)
    figures = [algorithm.iterate(seen) for _ in range(40)]
    assert figures[0]["distillation"] > 0.5
    assert figures[-1]["distillation"] < 1e-3


def test_an_infeasible_domain_is_drawn_anew() -> None:
    algorithm = didor()
    seen = experience(algorithm, lambda z: np.where(z[:, 0] < 1.2, np.nan, 0.0))
    contexts = algorithm.teachers.slot_contexts(seen)
    assert contexts.shape == (SLOTS, 1)
    assert (contexts >= 1.2).all()
    hopeless = experience(didor(), lambda z: np.full(len(z), np.nan))
    with pytest.raises(ConfigError, match="100 contexts for teacher 0"):
        teachers()(INTERFACE, 0).slot_contexts(hopeless)
    with pytest.raises(ConfigError, match="100 contexts for worker 0"):
        p2pdrl().iterate(hopeless)


def test_peers_learn_on_where_a_context_does_not_compile() -> None:
    of = setting("hopper", "env/context=hopper/torso_size", "env.task.time_limit=10")
    source = Uniform(np.array([-0.05]), np.array([0.05]))  # half of which are no size at all
    env, played = (of.make(None, count, 0, threads=1) for count in (4, 2))
    interface = Interface(env.episodes.observation.shape[1], env.episodes.low, env.episodes.high)
    algorithm = P2PDRL(interface, 0, partial(_on, interface), workers=2, alpha=0.05, slots=4, batch_frames=40)
    collector = LeanCollector(env, algorithm.collecting, 10)
    seen = Experience(collector, algorithm.policies["policy"], played.episodes, source)
    batches = list[TensorDict]()
    seen.listen(batches.append)
    for _ in range(3):
        before = [member.actor_adam.state_dict()["steps"] for member in algorithm.stack.members]
        algorithm.iterate(seen)
        after = [member.actor_adam.state_dict()["steps"] for member in algorithm.stack.members]
        assert all(late > early for early, late in zip(before, after, strict=True))
    contexts = torch.cat([cast(Tensor, batch["context"])[:, 0] for batch in batches])
    assert (contexts > 0.0).all()
    assert len(contexts.unique()) == 3 * 2


def _on(interface: Interface, _: object, seed: int) -> PPO:
    return PPO(**ppo_arguments(seed=seed, interface=interface))


@pytest.mark.parametrize("made", [partial(didor, teacher_frames=2 * BATCH), ensemble, p2pdrl])
def test_continues_exactly(made: Callable[..., Algorithm]) -> None:
    whole, first, second = made(), made(), made(seed=7)
    seen = [experience(each) for each in (whole, first, second)]
    expected = [whole.iterate(seen[0]) for _ in range(4)][2:]
    first.iterate(seen[1])
    first.iterate(seen[1])
    second.load_state_dict(first.state_dict())
    seen[2].load_state_dict(seen[1].state_dict())
    assert [second.iterate(seen[2]) for _ in range(2)] == expected


def test_the_ensemble_does_what_its_policies_would_do_on_average() -> None:
    algorithm = ensemble()
    observation = torch.linspace(-1.0, 1.0, 5)[:, None]
    expected = torch.stack([each.actor.mean(observation) for each in algorithm.teachers.members]).mean(0)
    torch.testing.assert_close(algorithm.deployed(observation), expected)


@pytest.mark.slow
def test_peers_are_left_alone_without_a_penalty_and_come_nearer_with_one() -> None:
    apart = []
    for alpha in (0.0, 5.0):
        algorithm = p2pdrl(alpha=alpha)
        seen = experience(algorithm)
        for _ in range(8):
            algorithm.iterate(seen)
        one, other = algorithm.stack.members
        rows = torch.linspace(-1.0, 1.0, 21)[:, None]
        apart.append(divergence(*(Gaussian(each.actor.body(rows), each.actor.log_std) for each in (one, other))).mean())
    assert apart[1] < 0.2 * apart[0]


def test_the_penalty_s_gradient_goes_to_each_policy_alone() -> None:
    members = [learner(None, seed) for seed in range(3)]
    for k, member in enumerate(members):
        torch.nn.init.normal_(member.actor.body.weights[-1], generator=torch.Generator().manual_seed(k))
    batch = next(PointCollector(PPOStack(members).acting, n=24))
    rows = [m.samples(batch[8 * k : 8 * k + 8]).at(torch.ones(8, 30, dtype=torch.bool)) for k, m in enumerate(members)]  # pyright: ignore[reportArgumentType]
    for member, each in zip(members, rows, strict=True):
        member.surrogate.differentiate(each)
    plain = [member.surrogate.actor_parameters.gradient.clone() for member in members]
    PeerSurrogate([member.surrogate for member in members], alpha=0.7).differentiate(rows)
    for k, (member, each) in enumerate(zip(members, rows, strict=True)):
        one = Gaussian(member.actor.body(each.observation), member.actor.log_std)
        peers = [Gaussian(p.actor.body(each.observation).detach(), p.actor.log_std.detach()) for p in members]
        penalty = torch.stack([divergence(one, peer).mean() for j, peer in enumerate(peers) if j != k]).sum() / 2
        slopes = torch.autograd.grad(0.7 * penalty, [member.actor.log_std, *member.actor.body.parameters()])
        expected = plain[k] + torch.cat([slope.flatten() for slope in slopes])
        torch.testing.assert_close(member.surrogate.actor_parameters.gradient, expected, rtol=1e-4, atol=1e-5)


def test_what_leaves_nothing_for_the_student_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"algorithm.teacher_frames is 960 of 960"):
        didor(teacher_frames=BATCH, frames=BATCH)


def test_policies_that_cannot_share_the_slots_are_refused() -> None:
    with pytest.raises(ConfigError, match="5 policies cannot share 32 episodes"):
        teachers(5)(INTERFACE, 0)
