"""The averaged actor is the mean of what the actor was."""

import numpy as np
import torch

from dr_lab.networks.averaged_actor import AveragedActor
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.normaliser import NoNormaliser


def actor(seed: int = 0) -> DeterministicActor:
    bound = np.array([2.0])
    return DeterministicActor(3, -bound, bound, seed, NoNormaliser, [4], "tanh", noise=0.5)


def test_the_first_steps_have_their_plain_mean_and_later_ones_a_share() -> None:
    average = AveragedActor(actor(), steps=3)
    points = torch.randn(5, len(average.vector), generator=torch.Generator().manual_seed(1))
    for point in points[:3]:
        average.take(point)
    torch.testing.assert_close(average.vector, points[:3].mean(0))
    for point in points[3:]:
        average.take(point)
    expected = (2 / 3) ** 2 * points[:3].mean(0) + 2 / 9 * points[3] + points[4] / 3
    torch.testing.assert_close(average.vector, expected)


def test_of_one_step_it_is_the_actor_and_acts_without_noise() -> None:
    one = actor(seed=4)
    average = AveragedActor(actor(), steps=1)
    average.take(FlatParameters(one.body.parameters()).vector)
    observation = torch.randn(6, 3, generator=torch.Generator().manual_seed(1))
    assert torch.equal(average(observation), one.mean(observation))


def test_goes_on_from_a_state() -> None:
    average, again = AveragedActor(actor(), steps=9), AveragedActor(actor(seed=5), steps=9)
    points = torch.randn(4, len(average.vector), generator=torch.Generator().manual_seed(1))
    for point in points[:3]:
        average.take(point)
    again.load_state_dict(average.state_dict())
    for each in (average, again):
        each.take(points[3])
    observation = torch.randn(6, 3, generator=torch.Generator().manual_seed(1))
    assert torch.equal(average.vector, again.vector)
    assert torch.equal(average(observation), again(observation))


def test_the_actor_goes_its_own_way() -> None:
    one = actor()
    average = AveragedActor(one, steps=2)
    before = average.vector.clone()
    with torch.no_grad():
        one.body.weights[0].add_(1.0)
    assert torch.equal(average.vector, before)
    assert average.actor.normaliser is one.normaliser
