"""Snapshots act as the policies did, and the best of them is chosen."""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import mujoco
import numpy as np
import pytest
import torch
from block_on_rail import constant
from point_mass import PointCollector, ppo
from small_runs import BATCH, plan
from test_recorded import DT, LIMIT, PARAMETERS, XML, Push
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.algorithms.p2pdrl.p2pdrl import P2PDRL
from dr_lab.envs.setting import Setting
from dr_lab.errors import ConfigError
from dr_lab.physics.model import from_spec
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.training.checkpoint import save
from dr_lab.training.plan import CHECKPOINT, POLICY
from dr_lab.training.policy_snapshots import Choice, Chosen, PolicySnapshot, PolicySnapshots
from dr_lab.training.run_state import RunState
from dr_lab.trajectory import Array

# Equal parameters may lie elsewhere in memory, which changes the last digit of a product.
close = functools.partial(torch.allclose, rtol=1e-6, atol=1e-6)


def test_the_last_few_policies_are_kept_as_they_were() -> None:
    algorithm, observation = ppo(), torch.linspace(-1.0, 1.0, 7)[:, None]
    batches, snapshots = PointCollector(algorithm.policies["policy"]), PolicySnapshots(algorithm, 3)
    acted = []
    for iteration in range(5):
        algorithm.update(next(batches))
        snapshots.take(480 * (iteration + 1))
        acted.append(algorithm.deployed(observation))
    again = PolicySnapshots(ppo(seed=1), 3)
    again.load_state_dict(snapshots.state_dict())
    for kept in (snapshots.restored(), again.restored()):
        assert [each.frames for each in kept] == [1440, 1920, 2400]
        for snapshot, action in zip(kept, acted[2:], strict=True):
            assert close(snapshot.deployed(observation), action)
    assert close(algorithm.deployed(observation), acted[-1])
    assert close(snapshots.restored()[0].exploring(observation), again.restored()[0].exploring(observation))


def test_peers_that_share_a_normaliser_go_back_together(tmp_path: Path) -> None:
    training = plan("p2pdrl", "cpu").assemble(tmp_path / CHECKPOINT)
    snapshots, first = PolicySnapshots(training.algorithm, 9), dict[str, Tensor]()

    def keep(*_: object) -> None:
        snapshots.take(training.trainer.frames)
        if not first:
            first.update(actors(training.algorithm))

    training.trainer.run(3 * BATCH, keep)
    training.trainer.close()
    save(tmp_path / POLICY, snapshots.taken[0])
    again, last = plan("p2pdrl", "cpu", seed=1).assemble(None).algorithm, actors(training.algorithm)
    RunState.load(tmp_path).restore(again)
    for name, value in actors(again).items():
        assert torch.equal(value, first[name])
        assert not torch.equal(value, last[name])


def actors(algorithm: Algorithm) -> dict[str, Tensor]:
    """Copies of one layer and of the normaliser of each of P2PDRL's workers."""
    assert isinstance(algorithm, P2PDRL)
    found = enumerate(member.actor for member in algorithm.stack.members)
    return {
        f"{part} {k}": value.detach().clone()
        for k, actor in found
        for part, value in (("layer", actor.body.weights[0]), ("mean", actor.normaliser.state_dict()["mean"]))
    }


FORCES = (1.0, 3.0, 3.0, 2.0)
RETURNS = np.array(FORCES) / 4.0 * DT * LIMIT * (LIMIT + 1) / 2  # of 4 kg: v = F t/m, summed over the steps


class Partly(FixedRandomizer):
    """A context at one mass but for the first few, whose mass is negative."""

    impossible = 0

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        z = super().sample(rngs)
        z[: self.impossible] = -1.0
        return z


def chosen_of(impossible: int) -> Chosen:
    """Among policies that push a block, in four contexts."""
    model = from_spec("block", mujoco.MjSpec.from_string(XML), PARAMETERS)
    task = Push(frame_skip=1, time_limit=LIMIT)
    setting = Setting(
        name="block", model=model, task=task, show_context=False, infeasible_return=-7.0, speed_limit=200.0
    )
    snapshots = [PolicySnapshot(i, constant(f), constant(f)) for i, f in enumerate(FORCES)]
    source = Partly(model.space, {"cube.mass": 4.0})
    source.impossible = impossible
    return Choice(snapshots=4, episodes=4).choose(snapshots, setting, source, 0, 1)


def test_the_newest_of_the_best_is_chosen_and_its_episodes_are_counted() -> None:
    chosen = chosen_of(impossible=0)
    assert chosen.index == 2
    np.testing.assert_allclose(cast(list[float], chosen.returns), RETURNS)
    assert chosen.frames == 4 * 4 * LIMIT


def test_contexts_that_do_not_compile_lower_no_return() -> None:
    chosen = chosen_of(impossible=3)
    assert chosen.index == 2
    np.testing.assert_allclose(cast(list[float], chosen.returns), RETURNS)


def test_where_no_context_is_feasible_the_newest_is_chosen_and_no_return_is_known() -> None:
    chosen = chosen_of(impossible=4)
    assert chosen.index == 3
    assert np.isnan(chosen.returns).all()


def test_a_choice_without_episodes_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"choice\.episodes is 0"):
        Choice(snapshots=10, episodes=0)
