"""TD3 finds the optimum of the point mass, lets its actor wait, and continues exactly."""

from pathlib import Path
from typing import Any

import pytest
import torch
from continuing import learn_whole_and_in_parts, updating
from point_mass import INTERFACE, PointCollector, best, mean_reward, replaying_arguments

from dr_lab.algorithms.td3.td3 import TD3
from dr_lab.errors import ConfigError


def td3(seed: int = 0, **changes: Any) -> TD3:  # noqa: ANN401
    waits = {"target_noise": 0.2, "target_clip": 0.5, "actor_every": 2}
    averages = {"saturation_cost": 0.01, "average_steps": 20}
    return TD3(INTERFACE, seed, **replaying_arguments() | waits | averages | changes)


def collector(algorithm: TD3) -> PointCollector:
    return PointCollector(algorithm.policies["policy"], n=16, steps=4)


def test_reaches_the_optimum() -> None:
    algorithm = td3()
    batches = collector(algorithm)
    for _ in range(60):
        algorithm.update(next(batches))
    assert mean_reward(algorithm.deployed) > mean_reward(best) - 0.03


def test_the_actor_steps_with_every_third_step_of_the_critics() -> None:
    algorithm = td3(steps_per_frame=1 / 64, learning_starts=0, actor_every=3)
    batches, actor, critics = collector(algorithm), list[bool](), list[bool]()
    for _ in range(7):
        parts = (algorithm.loss.actor_parameters, algorithm.loss.critic_parameters)
        before = [part.vector.clone() for part in parts]
        algorithm.update(next(batches))
        moved = [not torch.equal(part.vector, was) for part, was in zip(parts, before, strict=True)]
        actor.append(moved[0])
        critics.append(moved[1])
    assert actor == [False, False, True, False, False, True, False]
    assert all(critics)


def test_continues_exactly(tmp_path: Path) -> None:
    settings = {"steps_per_frame": 3 / 64, "learning_starts": 0}  # stops between two steps of the actor
    whole, first, second = td3(**settings), td3(**settings), td3(seed=3, **settings)
    learning = [updating(each, collector(each)) for each in (whole, first, second)]
    learn_whole_and_in_parts(learning, (5, 2), tmp_path)
    for part in ("explorer", "average", "critics", "targets"):
        for a, b in zip(whole.state_dict()[part].values(), second.state_dict()[part].values(), strict=True):
            assert torch.equal(a, b)


def test_both_critics_begin_differently() -> None:
    one, other = td3().critics
    assert not torch.equal(next(one.parameters()), next(other.parameters()))


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.actor_every is 0; expected at least 1\."):
        td3(actor_every=0)
    with pytest.raises(ConfigError, match=r"algorithm\.target_noise is -1; expected at least 0\."):
        td3(target_noise=-1.0)
    with pytest.raises(ConfigError, match=r"algorithm\.average_steps is 0; expected at least 1\."):
        td3(average_steps=0)
    with pytest.raises(ConfigError, match=r"algorithm\.saturation_cost is -1; expected at least 0\."):
        td3(saturation_cost=-1.0)
