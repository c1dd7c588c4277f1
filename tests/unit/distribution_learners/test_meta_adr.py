"""Meta-ADR with a meta-learner that acts otherwise after adapting to one half of the tasks, and alike in the other."""

import copy
from collections.abc import Sequence
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from differing_dynamics import HARD, LENGTH, SPACE, DifferingCollector, row
from pretended_experience import PretendedExperience
from tensordict import TensorDict

from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.meta_adr.dealt_proposals import DealtProposals
from dr_lab.distribution_learners.meta_adr.meta_adr import MetaADR
from dr_lab.distribution_learners.svpg.particles import Particles
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.distribution_learners.svpg.walk import Walk
from dr_lab.errors import ConfigError
from dr_lab.randomizers.context_source import UNKEYED, ContextSource
from dr_lab.randomizers.empirical import EmpiricalRandomizer

TASKS, SHARE, PROPOSALS = 20, 2, 20
EXPERIENCE = PretendedExperience(lambda z: z[:, 0])


def meta_adr(seed: int = 0) -> MetaADR:
    walk, particles = partial(Walk, max_step=0.05, horizon=50), partial(Particles, hidden=[16, 16], gamma=0.99)
    svpg = partial(SVPG, count=5, proposals=4, walk=walk, particles=particles, learning_rate=3e-3, temperature=10.0)
    sees = partial(Discriminator, hidden=[32, 32], learning_rate=3e-3, minibatch=64, epochs=2.0, clip=10.0)
    randomizer = EmpiricalRandomizer(SPACE, None, window=5000, bins=10)
    return MetaADR(randomizer, seed, svpg, sees, context_shown=False, inherits=[])


class Adapting:
    """Gives the batches of a meta-learner; a slot goes on after its episode has ended, as collectors do."""

    def __init__(self, source: ContextSource, seed: int = 0) -> None:
        self.source, self.rng = source, np.random.default_rng(seed)

    def batches(self, updates: int = 1) -> list[TensorDict]:
        drawn = self.source.propose([self.rng] * TASKS, np.arange(TASKS))
        z, keys = drawn.z[:, 0].repeat(SHARE), drawn.keys.repeat(SHARE)
        return [self._phase(z, keys, done, updates - done) for done in range(updates + 1)]

    def _phase(self, z: np.ndarray, keys: np.ndarray, updates: int, left: int) -> TensorDict:
        x, rows = self.rng.uniform(-1.0, 1.0, len(z)), list[Any]()
        learnt = (z > HARD) & (updates > 0)
        for step in range(2 * LENGTH):
            action = self.rng.standard_normal(len(z)) + np.where(learnt, 2.0, 0.0)
            done = np.full(len(z), step % LENGTH == LENGTH - 1)
            rows.append(row(x, action, x + action, z, {"done": done, "infeasible": np.zeros(len(z), bool)}))
            x = x + action
        batch = cast(TensorDict, torch.stack(rows, 1))
        counts = {"updates": np.full(len(z), updates), "updates_left": np.full(len(z), left)}
        for name, values in {"proposal": keys, **counts}.items():
            batch[name] = torch.from_numpy(values)[:, None].expand(batch.shape)
        return batch


def rounds(learner: MetaADR, machine: Adapting, count: int) -> list[dict[str, float]]:
    found = list[dict[str, float]]()
    while len(found) < count:
        found += [dict(each) for batch in machine.batches() if (each := learner.update(batch, EXPERIENCE))]
    return found


@pytest.mark.slow
def test_tasks_that_adapting_changes_are_proposed_more_often() -> None:
    learner = meta_adr()
    figures = rounds(learner, Adapting(learner.source), 200)
    late = learner.randomizer.sample([np.random.default_rng(0)] * 2000)
    assert (late > HARD).mean() > 0.65  # 0.5 of a walk without a preference
    assert figures[-1]["discriminator_accuracy"] > 0.6


def watched_rounds(learner: MetaADR, machine: Adapting, diverging: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Transitions of either side in two rounds; the first episode diverges in these slots of each phase."""
    given = list[tuple[int, int]]()
    learn = Discriminator.learn

    def watched(self: Discriminator, randomised: torch.Tensor, reference: torch.Tensor) -> float:
        given.append((len(randomised), len(reference)))
        return learn(self, randomised, reference)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Discriminator, "learn", watched)
        for _ in range(2):
            *phases, last = zip(machine.batches(updates=2), diverging, strict=True)
            for batch, slots in (*phases, last):
                batch["next", "infeasible"][slots, LENGTH - 1] = True
            assert not any(learner.update(batch, EXPERIENCE) for batch, _ in phases)
            assert learner.update(last[0], EXPERIENCE)
    return given


def test_a_meta_batch_of_as_many_tasks_is_a_round_and_only_its_first_episodes_count() -> None:
    learner = meta_adr()
    given = watched_rounds(learner, Adapting(learner.source), [[], [], []])
    assert given == [(TASKS * SHARE * LENGTH,) * 2] * 2


def test_of_a_task_that_is_infeasible_before_the_adaptation_the_discriminator_sees_neither_side() -> None:
    learner = meta_adr()
    given = watched_rounds(learner, Adapting(learner.source), [[0, SHARE], [], [SHARE]])
    assert given == [((TASKS - 2) * SHARE * LENGTH,) * 2] * 2


def test_proposals_are_dealt_in_turn() -> None:
    dealt = DealtProposals(np.arange(5.0)[:, None])
    rngs = [np.random.default_rng(0)] * 7
    assert dealt.propose(rngs, np.arange(7)).keys.tolist() == [0, 1, 2, 3, 4, 0, 1]
    dealt.answer(0)
    dealt.answer(3)
    assert dealt.propose(rngs[:4], np.arange(4)).z.ravel().tolist() == [1.0, 2.0, 4.0, 1.0]
    dealt.renew(np.arange(5.0, 7.0)[:, None])
    assert dealt.propose(rngs[:2], np.arange(2)).keys.tolist() == [5, 6]


def test_an_algorithm_that_adapts_to_nothing_or_plays_other_tasks_is_refused() -> None:
    learner = meta_adr()
    with pytest.raises(ConfigError, match=r"Take a meta-learner: algorithm=maml"):
        learner.update(next(DifferingCollector(learner.source)), EXPERIENCE)
    (batch, _) = Adapting(learner.source).batches()
    batch["proposal"] = torch.full(batch.shape, UNKEYED)
    with pytest.raises(ConfigError, match="gives its episodes others"):
        learner.update(batch, EXPERIENCE)


def test_continues_exactly() -> None:
    whole, first, second = meta_adr(), meta_adr(), meta_adr(seed=5)
    expected = rounds(whole, Adapting(whole.source), 5)
    machine = Adapting(first.source)
    rounds(first, machine, 2)
    before, after = machine.batches()
    first.update(before, EXPERIENCE)  # in the middle of a meta-batch
    second.load_state_dict(copy.deepcopy(first.state_dict()))
    found = [dict(second.update(after, EXPERIENCE))]
    machine.source = second.source
    assert found + rounds(second, machine, 2) == expected[2:]
