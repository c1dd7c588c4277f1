"""Runs that go on from one state with several seeds explore independently."""

from pathlib import Path

import pytest
import torch
from small_runs import BATCH, EPISODES, RUNS, plan, trained
from torch import Tensor

from dr_lab.collectors.collector import SeededPolicy
from dr_lab.training.run_state import RunState

ALGORITHMS = [run for run in RUNS if run not in ("lsdr", "simopt", "adr", "meta_adr")]  # which are others' once more


@pytest.mark.parametrize("run", ALGORITHMS)
def test_what_collects_draws_by_the_seed_that_it_is_given(run: str) -> None:
    training = plan(run, "cpu").assemble(None)
    training.trainer.close()
    acting, width = training.algorithm.collecting, training.experience.collect()["observation"].shape[-1]

    def drawn(seed: int) -> Tensor:
        assert isinstance(acting, SeededPolicy)  # by which a collector seeds its workers
        acting.reseed(seed)
        return acting(torch.zeros(EPISODES, width))

    first, second = drawn(1), drawn(2)
    assert (first != second).all()
    assert torch.equal(drawn(1), first)


@pytest.mark.parametrize("run", ALGORITHMS)
def test_training_on_from_one_state_takes_other_actions_with_another_seed(run: str, tmp_path: Path) -> None:
    trained(run, "cpu", tmp_path, BATCH)
    state, seen = RunState.load(tmp_path), list[Tensor]()
    for seed in (1, 1, 2):
        training = plan(run, "cpu").assemble(None)  # with episodes that begin alike
        state.train_on(training.algorithm, seed)
        seen.append(training.experience.collect()["action"][:, 0])
        training.trainer.close()
    assert torch.equal(seen[0], seen[1])
    assert (seen[0] != seen[2]).all()
