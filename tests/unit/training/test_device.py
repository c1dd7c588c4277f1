"""Devices by name, and the copies on the CPU that act for policies on another."""

from types import MethodType
from typing import cast

import numpy as np
import pytest
import torch
from point_mass import best, ppo

from dr_lab.collectors.boundary import DeviceBoundary, boundary_to
from dr_lab.errors import ConfigError
from dr_lab.networks.policy_stack import PolicyStack
from dr_lab.training.device import require_device

CPU = torch.device("cpu")
SEEN = torch.linspace(-1.0, 1.0, 5)[:, None]


def test_the_cpu_is_always_there() -> None:
    assert require_device("cpu") == CPU


@pytest.mark.parametrize("name", ["cuda:99", "gpu", "meta", "0", ""])
def test_a_device_that_is_not_there_is_told(name: str) -> None:
    with pytest.raises(ConfigError, match=rf"device is {name}, .* available are cpu.*device=cpu"):
        require_device(name)


def test_policies_that_learn_on_the_cpu_act_themselves() -> None:
    policies = (ppo().actor, ppo().deployed)
    assert boundary_to(CPU).acting(policies) is policies


def test_a_copy_draws_on_where_the_policy_would() -> None:
    actor = ppo().actor
    expected = [actor(SEEN), actor(SEEN)]
    actor = ppo().actor
    (copied,) = DeviceBoundary(CPU).acting([actor])
    assert copied is not actor
    assert torch.equal(copied(SEEN), expected[0])
    assert torch.equal(actor(SEEN), expected[1])


def test_a_copy_is_renewed_and_not_before() -> None:
    actor, boundary = ppo().actor, DeviceBoundary(CPU)
    _, mean = boundary.acting((actor, actor.mean))
    with torch.no_grad():
        actor.body.biases[-1].add_(1.0)
    actor.normaliser.update(3.0 + SEEN)
    before = mean(SEEN)
    assert not torch.equal(before, actor.mean(SEEN))
    boundary.renew()
    assert torch.equal(mean(SEEN), actor.mean(SEEN))


def test_what_policies_share_their_copies_share() -> None:
    first, second = ppo(0).actor, ppo(1).actor
    second.normaliser = first.normaliser
    stack, mean = DeviceBoundary(CPU).acting((PolicyStack([first, second]), first.mean))
    assert isinstance(stack, PolicyStack)
    assert stack.policies[0].normaliser is stack.policies[1].normaliser
    assert cast(MethodType, mean).__self__ is stack.policies[0]


def test_commands_and_policies_on_the_cpu_are_played_as_they_are() -> None:
    boundary, commands, actor = DeviceBoundary(CPU), np.zeros((1, 2, 1)), ppo().actor
    assert boundary.playing(commands) is commands
    assert boundary.playing(actor) is actor
    assert boundary.playing(best) is best
