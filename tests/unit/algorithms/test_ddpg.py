"""DDPG finds the optimum of the point mass and continues exactly."""

import copy
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from continuing import learn_whole_and_in_parts, updating
from point_mass import ASKEW, INTERFACE, PointCollector, best, mean_reward, replaying_arguments
from tensordict import TensorDict
from torch import Tensor
from torchrl.data import TensorDictReplayBuffer

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ddpg.ddpg import DDPG
from dr_lab.algorithms.ddpg.loss import Transitions
from dr_lab.errors import ConfigError
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.normaliser import NoNormaliser, Normaliser, RunningNormaliser
from dr_lab.training.checkpoint import save


def ddpg(
    seed: int = 0,
    normaliser: Callable[[int], Normaliser] = NoNormaliser,
    interface: Interface = INTERFACE,
    **changes: Any,  # noqa: ANN401
) -> DDPG:
    return DDPG(interface, seed, **replaying_arguments(normaliser) | changes)


def collector(algorithm: DDPG) -> PointCollector:
    return PointCollector(algorithm.policies["policy"], n=16, steps=4)


def watched(algorithm: DDPG, sampled: list[Transitions], monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep what the loss is given."""
    differentiate = algorithm.loss.differentiate_critics

    def keep(batch: Transitions) -> tuple[Tensor, Tensor]:
        sampled.append(batch)
        return differentiate(batch)

    monkeypatch.setattr(algorithm.loss, "differentiate_critics", keep)


def test_reaches_the_optimum() -> None:
    algorithm = ddpg()
    batches = collector(algorithm)
    figures = [algorithm.update(next(batches)) for _ in range(40)][-1]
    assert mean_reward(algorithm.deployed) > mean_reward(best) - 0.03
    assert figures["critic_loss"] < 1.0


def test_observations_of_any_size_are_normalised(monkeypatch: pytest.MonkeyPatch) -> None:
    normaliser = partial(RunningNormaliser, clip=10.0)
    algorithm = ddpg(normaliser=normaliser)
    seen, sampled = normaliser(1), list[Transitions]()
    watched(algorithm, sampled, monkeypatch)
    batches = collector(algorithm)
    for _ in range(8):
        batch = next(batches)
        batch["observation"] = 50.0 + 20.0 * batch["observation"]
        batch["next", "observation"] = 50.0 + 20.0 * batch["next", "observation"]
        seen.update(batch["observation"])
        algorithm.update(batch)
    torch.testing.assert_close(algorithm.actor.normaliser.state_dict(), seen.state_dict())
    for key in ("observation", "after"):
        assert torch.cat([getattr(sample, key) for sample in sampled]).abs().max() < 9.0


def test_the_minibatches_of_a_large_batch_are_not_held_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    algorithm = ddpg(learning_starts=0, steps_per_frame=4.0, minibatch=8)
    batches, sampled, held = collector(algorithm), list[Transitions](), list[int]()
    watched(algorithm, sampled, monkeypatch)
    draw = type(algorithm.buffer).__getitem__

    def noted(buffer: TensorDictReplayBuffer, rows: Tensor) -> TensorDict:
        held.append(len(rows))
        return draw(buffer, rows)

    monkeypatch.setattr(type(algorithm.buffer), "__getitem__", noted)
    algorithm.update(next(batches))
    assert [len(sample.reward) for sample in sampled] == [8] * 256  # 64 control steps
    assert sum(held) == 8 * 256
    assert max(held) <= 8 * 64


@pytest.mark.parametrize("replay", [2000, 200])  # of which the latter is written over
def test_continues_exactly(replay: int, tmp_path: Path) -> None:
    whole, first, second = ddpg(replay=replay), ddpg(replay=replay), ddpg(seed=3, replay=replay)
    learning = [updating(each, collector(each)) for each in (whole, first, second)]
    learn_whole_and_in_parts(learning, (5, 2), tmp_path)
    for part in ("explorer", "average", "critics", "targets"):
        for a, b in zip(whole.state_dict()[part].values(), second.state_dict()[part].values(), strict=True):
            assert torch.equal(a, b)


def test_a_checkpoint_holds_no_more_than_was_collected(tmp_path: Path) -> None:
    sizes = []
    for replay in (500, 500_000):
        algorithm = ddpg(replay=replay)
        algorithm.update(next(collector(algorithm)))
        save(tmp_path / "c.pt", algorithm.state_dict())
        sizes.append((tmp_path / "c.pt").stat().st_size)
    assert sizes[0] == sizes[1]


@pytest.mark.parametrize(("steps_per_frame", "steps"), [(1 / 256, 5), (0.25, 20 * 16)])
def test_control_steps_earn_gradient_steps_over_several_batches(
    steps_per_frame: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    algorithm = ddpg(steps_per_frame=steps_per_frame, learning_starts=0, batch_frames=64)
    taken = list[Transitions]()
    watched(algorithm, taken, monkeypatch)
    batches = collector(algorithm)
    figures = [algorithm.update(next(batches)) for _ in range(20)]
    assert len(taken) == steps
    assert sum(np.isfinite(each["critic_loss"]) for each in figures) == min(steps, 20)


def test_the_actor_climbs_q_as_it_has_just_become(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lillicrap et al. 2016, algorithm 1: Q learns first."""
    algorithm, seen = ddpg(), list[Tensor]()
    differentiate, critic = algorithm.loss.differentiate_actor, algorithm.loss.critic_parameters.vector

    def note(observation: Tensor) -> Tensor:
        seen.append(critic.clone())
        return differentiate(observation)

    monkeypatch.setattr(algorithm.loss, "differentiate_actor", note)
    batches = collector(algorithm)
    while not seen:
        algorithm.update(next(batches))
    assert torch.equal(seen[-1], critic)


def test_the_end_in_an_infeasible_context_is_not_learnt_from() -> None:
    algorithm = ddpg()
    batch = next(collector(algorithm))
    batch["next", "infeasible"][3, 2] = True
    batch["next", "reward"][3, 2] = -1e6
    algorithm.update(batch)
    assert len(algorithm.buffer) == batch.numel() - 1
    assert algorithm.buffer.storage[:]["next", "reward"].min() > -10.0
    batch["next", "infeasible"][:] = True
    algorithm.update(batch)
    assert len(algorithm.buffer) == batch.numel() - 1


def test_actions_are_kept_in_units_of_their_bounds() -> None:
    algorithm = ddpg(interface=ASKEW)
    batch = next(collector(algorithm))
    algorithm.update(batch)
    kept = algorithm.buffer.storage[:]["action"]
    torch.testing.assert_close(kept, (batch["action"].reshape(-1, 1) + 1.0) / 2.0)
    observation = torch.linspace(-2.0, 2.0, 5)[:, None]
    algorithm.actor.noise = 0.0
    torch.testing.assert_close(algorithm.deployed(observation), algorithm.actor(observation))


def test_training_on_collects_anew() -> None:
    algorithm = ddpg(learning_starts=100)
    batches = collector(algorithm)
    for _ in range(5):
        algorithm.update(next(batches))
    algorithm.begin_schedules()
    assert len(algorithm.buffer) == 0
    assert np.isnan(algorithm.update(next(batches))["q"])
    assert np.isfinite(algorithm.update(next(batches))["q"])


def test_the_mean_of_the_last_steps_is_deployed_and_trained_on(monkeypatch: pytest.MonkeyPatch) -> None:
    algorithm = ddpg(average_steps=1000, learning_starts=0)
    batches, seen, take = collector(algorithm), list[Tensor](), algorithm.average.take

    def keep(vector: Tensor) -> None:
        seen.append(vector.clone())
        take(vector)

    monkeypatch.setattr(algorithm.average, "take", keep)
    for _ in range(5):
        algorithm.update(next(batches))
    mean = torch.stack(seen).mean(0)
    assert len(seen) == 5 * 16
    torch.testing.assert_close(algorithm.average.vector, mean)
    assert (algorithm.loss.actor_parameters.vector - mean).abs().max() > 1e-3
    algorithm.begin_schedules()
    observation = torch.linspace(-2.0, 2.0, 5)[:, None]
    assert torch.equal(algorithm.loss.actor_parameters.vector, algorithm.average.vector)
    assert torch.equal(algorithm.actor.mean(observation), algorithm.deployed(observation))


def test_one_state_may_be_trained_on_from_twice() -> None:
    algorithm = ddpg()
    batches = collector(algorithm)
    for _ in range(5):
        algorithm.update(next(batches))
    state = copy.deepcopy(algorithm.state_dict())

    def trained_on() -> DDPG:
        again = ddpg(seed=3)
        again.load_state_dict(state)
        more = collector(again)
        for _ in range(2):
            again.update(next(more))
        return again

    first, second = trained_on(), trained_on()
    for a, b in zip(first.critics.parameters(), second.critics.parameters(), strict=True):
        assert torch.equal(a, b)


def test_neighbouring_seeds_share_no_numbers() -> None:
    generators = [generator for seed in range(3) for generator in (ddpg(seed).actor.generator, ddpg(seed).generator)]
    assert len({generator.initial_seed() for generator in generators}) == 6


def test_actions_are_uniform_until_learning_starts() -> None:
    algorithm = ddpg(interface=ASKEW, learning_starts=200)
    explorer, batches = algorithm.policies["policy"], collector(algorithm)
    drawn = explorer(torch.zeros(20_000, 1))
    assert drawn.min() < -2.99
    assert drawn.max() > 0.99
    # U(−3, 1) has mean −1 and variance 16/12
    assert drawn.mean().item() == pytest.approx(-1.0, abs=0.04)
    assert drawn.var().item() == pytest.approx(16 / 12, rel=0.03)
    for _ in range(4):  # of 64 control steps
        assert not algorithm.explorer.follows
        algorithm.update(next(batches))
    again = ddpg(seed=1, interface=ASKEW)
    again.load_state_dict(algorithm.state_dict())
    for one in (algorithm, again):
        assert one.policies["policy"](torch.zeros(20_000, 1)).std().item() < 1.0
    algorithm = ddpg(interface=ASKEW)
    algorithm.begin_schedules()  # of a policy that was trained
    assert algorithm.explorer.follows


def test_exploration_stays_within_the_bounds() -> None:
    action = ddpg().actor(torch.zeros(500, 1))
    assert action.abs().max() <= 1.0
    assert action.std() > 0.1


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.gamma is 1\.5; expected at most 1\."):
        ddpg(gamma=1.5)
    with pytest.raises(ConfigError, match=r"algorithm\.tau is 2; expected at most 1\."):
        ddpg(tau=2.0)
    with pytest.raises(ConfigError, match=r"algorithm\.actor\.noise is -1; expected at least 0\."):
        DeterministicActor(1, np.array([-1.0]), np.array([1.0]), 0, NoNormaliser, [4], "relu", noise=-1.0)
    with pytest.raises(ConfigError, match=r"hidden is \[0\]; expected the width of each hidden layer"):
        DeterministicActor(1, np.array([-1.0]), np.array([1.0]), 0, NoNormaliser, [0], "relu", noise=0.1)
