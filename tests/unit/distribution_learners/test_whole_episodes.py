"""Episodes that lie across batches come out whole."""

from typing import cast

import numpy as np
import pytest
import torch
from settings import setting
from torch import Tensor

from dr_lab.collectors.lean import LeanCollector
from dr_lab.distribution_learners.adr.whole_episodes import EpisodeAssembler, transitions


def stagger(steps: int) -> tuple[LeanCollector, int]:
    make = setting("hopper", "env/context=hopper/friction", "env.task.time_limit=9").make
    return LeanCollector(make(None, 3, 0, threads=1, staggered=True), policy, steps), 9


def policy(observation: Tensor) -> Tensor:
    return torch.sin(50.0 * observation[:, :3])


@pytest.mark.parametrize("steps", [1, 4, 30])
def test_episodes_are_those_of_one_long_batch(steps: int) -> None:
    collector, limit = stagger(60)
    long = next(collector)
    rows = transitions(long, 0)
    done, terminated = (cast(Tensor, long["next", key])[..., 0].numpy() for key in ("done", "terminated"))
    expected = []
    for slot in range(3):
        begin = 0
        for end in np.flatnonzero(done[slot]) + 1:
            if begin or terminated[slot, end - 1]:  # the first may have been cut early, as slots are staggered
                expected.append(rows[slot, begin:end])
            begin = int(end)
    parts, (short, _) = EpisodeAssembler(0), stagger(steps)
    found = [each.transitions for _ in range(60 // steps) for each in parts.take(next(short))]
    assert sorted(map(fingerprint, found)) == sorted(map(fingerprint, expected))
    assert {len(each) for each in expected} >= {limit}
    assert parts._kept < limit + steps


def fingerprint(rows: Tensor) -> tuple[int, float]:
    return len(rows), float(rows.double().cumsum(0).sum())


def test_goes_on_where_its_state_was_taken() -> None:
    collector, _ = stagger(4)
    batches = [next(collector) for _ in range(10)]
    whole, first, second = EpisodeAssembler(0), EpisodeAssembler(0), EpisodeAssembler(0)
    expected = [each for batch in batches for each in whole.take(batch)][-5:]
    for batch in batches[:5]:
        first.take(batch)
    second.load_state_dict(first.state_dict())
    found = [each for batch in batches[5:] for each in second.take(batch)][-5:]
    for a, b in zip(expected, found, strict=True):
        assert torch.equal(a.transitions, b.transitions)
