"""SVPG on the unit cube: the stacked update against one particle after the other, and walks towards a reward."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import pytest
import torch
from torch import Tensor
from torch.func import functional_call

from dr_lab.distribution_learners.svpg.particles import Particles, WalkActor, discounted
from dr_lab.distribution_learners.svpg.stacked import Stacked
from dr_lab.distribution_learners.svpg.stein import ascent_direction
from dr_lab.distribution_learners.svpg.svpg import SVPG, spread
from dr_lab.distribution_learners.svpg.walk import Walk, WalkStep
from dr_lab.errors import ConfigError


def svpg(size: int = 1, count: int = 5, **changes: Any) -> SVPG:  # noqa: ANN401
    walk = partial(Walk, max_step=changes.pop("max_step", 0.05), horizon=changes.pop("horizon", 50))
    particles = partial(Particles, hidden=[16, 16], gamma=0.99)
    settings = {"proposals": 4, "learning_rate": 3e-3, "temperature": 10.0} | changes
    return SVPG(size, 0, count, walk=walk, particles=particles, **settings)


def test_stacked_networks_give_what_each_gives_alone() -> None:
    generator = torch.Generator().manual_seed(0)
    members = [WalkActor(2, [8], generator) for _ in range(3)]
    x = torch.rand(3, 4, 2, generator=generator)
    expected = torch.stack([one(each) for one, each in zip(members, x, strict=True)])
    torch.testing.assert_close(Stacked(members)(x), expected)


def test_the_stacked_step_is_that_of_single_particles() -> None:
    one, rewards = svpg(size=2, horizon=3), torch.randn(5, 4, generator=torch.Generator().manual_seed(3))
    one.propose()
    actors, critics = one.particles.actors, one.particles.critics
    before = {part: {k: v.detach().clone() for k, v in part.parameters_of_all().items()} for part in (actors, critics)}
    x = actors.rows.detach().clone()
    steps: list[Any] = list(one._steps)
    slopes = torch.stack(
        [
            _gradient_alone(
                (actors, {name: value[i] for name, value in before[actors].items()}),
                (critics, {name: value[i] for name, value in before[critics].items()}),
                [[part[i] for part in step] for step in steps],
                rewards[i],
            )
            for i in range(5)
        ]
    )
    torch.testing.assert_close(one.particles.gradients(steps, rewards).actor, slopes)
    one.learn(rewards)
    direction = ascent_direction(x, slopes, 10.0)
    # Adam's first step is the learning rate along the sign.
    sure = direction.abs() > 1e-5
    expected = (x + 3e-3 * direction.sign())[sure]
    torch.testing.assert_close(actors.rows.detach()[sure], expected, atol=3e-5, rtol=0)


def _gradient_alone(
    actors: tuple[Stacked, dict[str, Tensor]],
    critics: tuple[Stacked, dict[str, Tensor]],
    steps: Sequence[Sequence[Tensor]],
    rewards: Tensor,
) -> Tensor:
    """Σ A ∇ log π of one particle, by a loop over its steps."""
    (actor, critic), (mu, value) = ((each._one[0] for each, _ in (actors, critics)), (actors[1], critics[1]))
    mu = {name: tensor.requires_grad_() for name, tensor in mu.items()}
    following, objective = None, torch.zeros(())
    for (before, action, after, cut), reward in reversed(list(zip(steps, rewards, strict=True))):
        known, beyond = (functional_call(critic, value, (u,))[0].detach() for u in (before, after))
        following = reward + 0.99 * (beyond if following is None or cut else following)
        mean, log_std = functional_call(actor, mu, (before,)).chunk(2)
        log_prob = torch.distributions.Normal(mean, log_std.exp()).log_prob(action).sum()
        objective = objective + (following - known) * log_prob
    slopes = torch.autograd.grad(objective, list(mu.values()))
    return torch.cat([slope.flatten() for slope in slopes])


def test_returns_by_hand() -> None:
    rewards, after = torch.tensor([[1.0, 2.0, 3.0]]), torch.tensor([[10.0, 20.0, 30.0]])
    cut = torch.tensor([[False, True, False]])
    # R₂ = 3 + ½·30, R₁ = 2 + ½·20 (cut), R₀ = 1 + ½·12
    assert discounted(rewards, after, cut, 0.5).tolist() == [[7.0, 12.0, 18.0]]


def test_the_state_that_a_walk_has_given_stays_as_it_was() -> None:
    walk = Walk(3, 2, torch.Generator().manual_seed(0), max_step=0.1, horizon=5)
    given = walk.state_dict()
    walk.step(torch.full((3, 2), 0.1))
    assert given["age"].tolist() == [0, 0, 0]
    assert walk.state_dict()["age"].tolist() == [1, 1, 1]


def test_walks_stay_in_the_cube_keep_to_the_longest_step_and_begin_anew() -> None:
    walk = Walk(64, 2, torch.Generator().manual_seed(0), max_step=0.1, horizon=5)
    steps, positions = list[WalkStep](), list[Tensor]()
    for _ in range(5):
        steps.append(walk.step(torch.full((64, 2), 3.0)))
        positions.append(walk.position)
    for step, position in zip(steps, positions, strict=True):
        moved = (step.after - step.before).norm(dim=1)
        assert (step.after <= 1.0).all()
        assert (moved <= 0.1 + 1e-6).all()
        assert step.cut[moved == 0].all()
        assert torch.equal(position[~step.cut], step.after[~step.cut])
        assert (position[step.cut] != step.after[step.cut]).any(-1).all()
    never_stuck = torch.stack([~step.cut for step in steps[:4]]).all(0)
    assert never_stuck.any()
    assert steps[4].cut[never_stuck].all()


def test_a_walk_that_does_not_move_is_cut() -> None:
    walk = Walk(3, 1, torch.Generator().manual_seed(0), max_step=0.1, horizon=50)
    walk.position = torch.tensor([[1.0], [0.95], [0.0]])
    assert walk.step(torch.ones(3, 1)).cut.tolist() == [True, False, False]


@pytest.mark.slow
def test_proposals_begin_as_a_walk_without_a_preference() -> None:
    one = svpg(count=40)
    proposed = torch.cat([one.propose().flatten() for _ in range(300)])
    shares = torch.histc(proposed, 5, 0.0, 1.0) / len(proposed)
    torch.testing.assert_close(shares, torch.full((5,), 0.2), atol=0.06, rtol=0)  # clipping keeps walks at the faces


@pytest.mark.slow
def test_proposals_gather_where_the_reward_is() -> None:
    one, late = svpg(), list[Tensor]()
    for _ in range(400):
        proposed = one.propose()
        one.learn((proposed[..., 0] > 0.7).float())
        late.append(proposed)
    assert (torch.cat(late[-100:]) > 0.7).float().mean() > 0.6  # 0.3 of a walk without a preference


@pytest.mark.slow
def test_heat_keeps_particles_apart() -> None:
    spreads = []
    for temperature in (0.01, 1000.0):
        one = svpg(temperature=temperature)
        found = [one.learn((one.propose()[..., 0] > 0.7).float()) for _ in range(60)]
        spreads.append(found[-1]["particle_spread"])
    assert spreads[0] < spreads[1]


def test_continues_exactly() -> None:
    whole, first, second = svpg(), svpg(), svpg()
    for _ in range(3):
        for one in (whole, first):
            one.learn(one.propose()[..., 0])
    proposed = whole.propose(), first.propose()
    second.load_state_dict(first.state_dict())
    whole.learn(proposed[0][..., 0])
    second.learn(proposed[1][..., 0])
    assert torch.equal(whole.particles.actors.rows, second.particles.actors.rows)
    assert torch.equal(whole.propose(), second.propose())


def test_numbers_out_of_range_are_told() -> None:
    with pytest.raises(ConfigError, match=r"distribution_learner\.svpg\.temperature is 0; expected a number above 0"):
        svpg(temperature=0.0)
    with pytest.raises(ConfigError, match=r"distribution_learner\.svpg\.walk\.horizon is 0; expected at least 1"):
        svpg(horizon=0)


def test_spread_is_the_mean_distance() -> None:
    assert spread(torch.tensor([[0.0], [1.0], [3.0]])) == 2.0
    assert spread(torch.zeros(1, 2)) == 0.0
