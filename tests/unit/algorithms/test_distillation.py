"""A student learns by the divergence from its teachers in closed form."""

from functools import partial

import numpy as np
import pytest
import torch
from point_mass import actor

from dr_lab.algorithms.didor.distillation import Distillation
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian import Gaussian, divergence
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser

BOUNDS = (np.array([-1.0, -2.0]), np.array([1.0, 2.0]))


def student(seed: int = 0) -> GaussianActor:
    return partial(actor(), normaliser=NoNormaliser)(3, *BOUNDS, seed)


def states(count: int, seed: int) -> torch.Tensor:
    return torch.randn(count, 3, generator=torch.Generator().manual_seed(seed))


def teacher_of(one: GaussianActor, observation: torch.Tensor) -> Gaussian:
    with torch.no_grad():
        mean = one.body(observation)
    return Gaussian(mean, (one.log_std.detach() + 0.3).expand_as(mean))


def test_the_gradient_is_that_of_the_divergence() -> None:
    one, other, observation = student(), student(1), states(50, 2)
    torch.nn.init.normal_(other.body.weights[-1], generator=torch.Generator().manual_seed(3))
    learning = Distillation(one, seed=0, epochs=1, minibatch=50, rate=1e-9, adam_epsilon=1e-8)
    taught = teacher_of(other, observation)
    parameters = [one.log_std, *one.body.parameters()]
    loss = divergence(taught, Gaussian(one.body(observation), one.log_std)).mean()
    expected = torch.cat([slope.flatten() for slope in torch.autograd.grad(loss, parameters)])
    figures = learning.learn(observation, taught)
    assert figures["distillation"] == pytest.approx(loss.item())
    torch.testing.assert_close(learning._parameters.gradient, expected, rtol=1e-4, atol=1e-6)


def test_of_one_teacher_the_student_becomes_its_copy() -> None:
    one, other = student(), student(1)
    torch.nn.init.normal_(other.body.weights[-1], generator=torch.Generator().manual_seed(3))
    learning = Distillation(one, seed=0, epochs=10, minibatch=50, rate=3e-3, adam_epsilon=1e-8)
    figures = [learning.learn(rows, teacher_of(other, rows)) for rows in (states(500, k) for k in range(40))]
    assert figures[0]["distillation"] > 1.0
    assert figures[-1]["distillation"] < 0.01  # in states that it has not learnt from
    torch.testing.assert_close(one.log_std, other.log_std + 0.3, rtol=0.0, atol=0.05)


@pytest.mark.slow
def test_of_two_teachers_in_the_same_states_it_becomes_the_gaussian_of_both_moments() -> None:
    # KL(teacher‖student) is least at the mean, with the variance about it: σ² + (gap/2)².
    one, rows = student(), states(400, 0)
    log_std, gap = torch.full((400, 2), -1.0), torch.tensor([0.8, -0.4])
    mean = torch.zeros(400, 2)
    both = Gaussian(torch.cat([mean - gap / 2, mean + gap / 2]), torch.cat([log_std, log_std]))
    learning = Distillation(one, seed=0, epochs=60, minibatch=100, rate=3e-3, adam_epsilon=1e-8)
    for _ in range(5):
        learning.learn(torch.cat([rows, rows]), both)
    variance = np.exp(-2.0) + (gap / 2).square()
    torch.testing.assert_close((2 * one.log_std).exp(), variance, rtol=0.05, atol=0.0)
    assert one.body(rows).abs().mean() < 0.05


def test_a_rate_of_nothing_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"algorithm.distillation.rate"):
        Distillation(student(), seed=0, epochs=1, minibatch=50, rate=0.0, adam_epsilon=1e-8)


def test_exploring_anew_takes_the_states_in_another_order() -> None:
    observation = states(64, 4)
    taught = teacher_of(student(1), observation)

    def learnt(*seeds: int) -> torch.Tensor:
        one = student()
        learning = Distillation(one, seed=0, epochs=1, minibatch=16, rate=1e-2, adam_epsilon=1e-8)
        for seed in seeds:
            learning.explore_anew(seed)
        learning.learn(observation, taught)
        return torch.cat([each.detach().flatten() for each in one.body.parameters()])

    assert torch.equal(learnt(5), learnt(5))
    assert not torch.equal(learnt(5), learnt())
    assert not torch.equal(learnt(5), learnt(6))
