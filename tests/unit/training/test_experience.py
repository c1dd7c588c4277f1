"""Whole episodes of a policy, and batches beside them, on a block with a known course."""

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from settings import setting
from test_recorded import DT, FORCE, LIMIT, episodes, push
from torch import Tensor

from dr_lab.collectors.collector import Collector
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.play import play, undiscounted
from dr_lab.collectors.shares import shares
from dr_lab.collectors.torchrl import TorchRLCollector
from dr_lab.envs.setting import Setting
from dr_lab.randomizers.context_source import UNKEYED, Proposals
from dr_lab.trajectory import Array


def test_what_is_played_is_laid_out_as_it_happened() -> None:
    z = np.array([[4.0], [0.5], [4.0]])  # more than slots; the second leaves its bounds in step 17
    played = play(episodes(2), push, z)
    assert played.batch_size == (3, LIMIT)
    assert cast(Tensor, played["mask"]).sum(1).tolist() == [LIMIT, 17, LIMIT]
    assert played["next", "done"].sum(1)[:, 0].tolist() == [1, 1, 1]
    assert played["next", "terminated"][1, 16]
    assert played["next", "truncated"][0, -1]
    velocity = FORCE / 4.0 * DT * np.arange(LIMIT + 1)
    np.testing.assert_allclose(played["qvel"][0, :, 0], velocity[:-1])
    np.testing.assert_allclose(played["next", "qvel"][0, :, 0], velocity[1:])
    np.testing.assert_allclose(played["next", "qpos"][2, :, 0], DT * np.cumsum(velocity)[1:])
    going = played["mask"][:, 1:]
    for key in ("observation", "qpos", "qvel"):
        assert torch.equal(played[key][:, 1:][going], played["next", key][:, :-1][going])
        assert not played["next", key][1, 17:].any()
    assert not played["next", "reward"][1, 17:].any()
    torch.testing.assert_close(played["context"][:, -1, 0], torch.tensor([4.0, 0.5, 4.0]))
    np.testing.assert_allclose(undiscounted(played)[0], velocity[1:].sum())


def test_episodes_begin_where_they_are_told_to() -> None:
    starts = (np.array([[1.0], [2.0], [3.0]]), np.array([[0.1], [0.2], [-0.3]]))
    played = play(episodes(2), push, np.full((3, 1), 2.0), starts)
    np.testing.assert_array_equal(played["qpos"][:, 0], starts[0])
    np.testing.assert_array_equal(played["qvel"][:, 0], starts[1])
    np.testing.assert_allclose(played["next", "qvel"][:, 0] - played["qvel"][:, 0], FORCE / 2.0 * DT)


def test_an_infeasible_context_has_no_return() -> None:
    returns = undiscounted(play(episodes(2), push, np.array([[-1.0], [4.0]])))
    assert np.isnan(returns).tolist() == [True, False]


@pytest.mark.parametrize("kind", [LeanCollector, TorchRLCollector])
def test_new_episodes_begin_in_given_contexts_and_what_is_played_disturbs_none(kind: type[Collector]) -> None:
    hopper: Setting = setting("hopper", "env/context=hopper/friction", "env.task.time_limit=8")

    def policy(observation: torch.Tensor) -> torch.Tensor:
        return 0.1 * observation[:, :3]

    def experience() -> Experience:
        collector = kind(hopper.make(None, 3, 0, threads=1), policy, 20)  # pyright: ignore[reportCallIssue]
        return Experience(collector, policy, hopper.make(None, 2, 1, threads=1).episodes)

    z = np.linspace(hopper.space.low, hopper.space.high, 3)
    one, other = experience(), experience()
    one.collect()
    one.begin(z)
    batch = one.collect()
    torch.testing.assert_close(batch["context"], torch.from_numpy(z).float()[:, None].expand(-1, 20, -1))
    assert batch["next", "done"].squeeze(-1).nonzero()[:, 1].tolist() == [7, 15] * 3
    other.collect()
    other.begin(z)
    other.play(policy, z)
    again = other.collect()
    assert torch.equal(batch["observation"], again["observation"])
    one.close()
    other.close()


class InTurn:
    """Proposes contexts by slot, each slot its own one after the other, and numbers them."""

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high = low, high

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        keys = 10 * slots + [rng.integers(3) for rng in rngs]
        return Proposals(self.of(keys), keys)

    def of(self, keys: NDArray[np.int64]) -> Array:
        return self.low + (self.high - self.low) * keys[..., None] / 30.0


@pytest.mark.parametrize("kind", [LeanCollector, TorchRLCollector])
def test_a_source_proposes_by_slot_and_knows_its_episodes(kind: type[Collector]) -> None:
    hopper: Setting = setting("hopper", "env/context=hopper/friction", "env.task.time_limit=5")
    source = InTurn(hopper.space.low, hopper.space.high)
    env = hopper.make(source, 3, 0, threads=1)
    with kind(env, lambda seen: 0.1 * seen[:, :3], 20) as collector:  # pyright: ignore[reportCallIssue]
        batch = next(collector)
        keys = cast(Tensor, batch["proposal"])
        assert keys.shape == (3, 20)
        assert torch.equal(keys // 10, torch.arange(3)[:, None].expand(3, 20))
        assert len(keys.unique()) > 5
        torch.testing.assert_close(batch["context"], torch.from_numpy(source.of(keys.numpy())).float())
        ended = cast(Tensor, batch["next", "done"])[:, :-1, 0]
        assert torch.equal(keys[:, 1:][~ended], keys[:, :-1][~ended])
        collector.begin(np.tile(hopper.space.nominal, (3, 1)))
        assert (next(collector)["proposal"] == UNKEYED).all()


def test_shares_of_the_slots_keep_their_numbers() -> None:
    hopper: Setting = setting("hopper", "env/context=hopper/friction")
    source = InTurn(hopper.space.low, hopper.space.high)
    whole, half = hopper.make(source, 4, 0, threads=1).episodes, hopper.make(source, 2, 5, threads=1).episodes
    half.load_state_dict(shares(whole.state_dict(), 4, 2)[1])
    half.begin(np.arange(2))
    assert (half.proposals // 10).tolist() == [2, 3]


@pytest.mark.parametrize("kind", [LeanCollector, TorchRLCollector])
def test_whole_episodes_are_collected_in_every_slot_and_the_rest_is_cut(kind: Callable[..., Collector]) -> None:
    hopper: Setting = setting("hopper", "env/context=hopper/friction", "env.task.time_limit=8")

    env = hopper.make(None, 4, 0, threads=1, staggered=True)
    experience = Experience(kind(env, _still, 3), _still, hopper.make(None, 2, 1, threads=1).episodes)
    heard = []
    experience.listen(heard.append)
    experience.collect()
    z = np.array([[1.5], [1.5], [3.0], [3.0]])
    batch = experience.collect_whole(z)
    assert batch is heard[-1]
    assert batch.batch_size == (4, 9)  # three times three, the time limit being 8
    np.testing.assert_allclose(batch["context"][..., 0], np.repeat(z, 9, axis=1))
    done = batch["next", "done"][..., 0]
    assert done.nonzero()[:, 1].tolist() == [7, 8] * 4
    assert torch.equal(batch["next", "truncated"][..., 0], done)
    assert not batch["next", "terminated"].any()
    assert batch["first"].sum(1).tolist() == [8] * 4


def test_control_steps_of_whole_episodes_are_counted_and_the_count_is_resumed() -> None:
    hopper: Setting = setting("hopper", "env.task.time_limit=8")

    def make() -> Experience:
        env = hopper.make(None, 2, 0, threads=1)
        return Experience(LeanCollector(env, _still, 3), _still, hopper.make(None, 2, 1, threads=1).episodes)

    one, other = make(), make()
    nominal = one.contexts(np.random.default_rng(0), 5)
    assert nominal.shape == (5, 0)
    one.play(_still, nominal)
    assert one.rollout_frames == 5 * 8
    other.load_state_dict(one.state_dict())
    assert other.rollout_frames == 5 * 8


def _still(observation: torch.Tensor) -> torch.Tensor:
    return 0.1 * observation[:, :3]
