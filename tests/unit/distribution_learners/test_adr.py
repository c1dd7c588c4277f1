"""Active domain randomisation in a world whose hard contexts are known."""

from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from differing_dynamics import HARD, INFEASIBLE, LENGTH, SPACE, DifferingCollector, DifferingExperience
from tensordict import TensorDict

from dr_lab.distribution_learners.adr.adr import ADR
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.svpg.particles import Particles
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.distribution_learners.svpg.walk import Walk
from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import UNKEYED
from dr_lab.randomizers.empirical import EmpiricalRandomizer
from dr_lab.randomizers.uniform import UniformRandomizer

PROPOSALS = 20


def adr(seed: int = 0, **changes: Any) -> ADR:  # noqa: ANN401
    walk = partial(Walk, max_step=changes.pop("max_step", 0.05), horizon=50)
    particles = partial(Particles, hidden=[16, 16], gamma=0.99)
    svpg = partial(SVPG, count=5, proposals=4, walk=walk, particles=particles, learning_rate=3e-3, temperature=10.0)
    discriminator = partial(
        Discriminator, hidden=[32, 32], learning_rate=3e-3, minibatch=64, epochs=changes.pop("epochs", 2.0), clip=10.0
    )
    randomizer = EmpiricalRandomizer(SPACE, changes.pop("ranges", None), window=5000, bins=10)
    settings = {"reference_load": 8, "context_shown": False, "inherits": ["particles", "discriminator"]} | changes
    return ADR(randomizer, seed, svpg, discriminator, **settings)


def run(learner: ADR, rounds: int, seed: int = 0) -> tuple[list[dict[str, float]], DifferingExperience]:
    """Figures of every round."""
    collector = DifferingCollector(learner.source, seed=seed)
    experience = DifferingExperience(collector, seed)
    return go_on(learner, collector, experience, rounds), experience


def go_on(
    learner: ADR, collector: DifferingCollector, experience: DifferingExperience, rounds: int
) -> list[dict[str, float]]:
    found = list[dict[str, float]]()
    while len(found) < rounds:
        figures = dict(learner.update(next(collector), experience))
        found += [figures] if figures else []
    return found


@pytest.mark.slow
def test_contexts_whose_transitions_differ_are_proposed_more_often() -> None:
    torch.manual_seed(0)
    learner = adr()
    figures, _ = run(learner, 250)
    late = learner.randomizer.sample([np.random.default_rng(0)] * 2000)
    assert (late > HARD).mean() > 0.65  # 0.5 of a walk without a preference
    assert figures[-1]["discriminator_accuracy"] > 0.6
    assert figures[0]["proposal_reward"] < figures[-1]["proposal_reward"]


def test_every_proposal_is_answered_by_one_reference_in_the_nominal_context() -> None:
    _, experience = run(adr(), 3)
    played = np.concatenate(experience.contexts_played)
    assert len(played) == 3 * PROPOSALS
    assert (played == SPACE.nominal).all()


def test_slots_play_what_is_not_answered_and_keys_go_on() -> None:
    learner = adr()
    collector = DifferingCollector(learner.source)
    experience, seen, first = DifferingExperience(collector), dict[int, float](), set[int]()
    for _ in range(30):
        first.add(learner.source.first)
        batch = next(collector)
        keys, contexts = (cast(torch.Tensor, batch[name]).flatten().tolist() for name in ("proposal", "context"))
        for key, z in zip(keys, contexts, strict=True):
            assert seen.setdefault(key, z) == z
        learner.update(batch, experience)
    assert sorted(first) == [PROPOSALS * k for k in range(len(first))]
    assert len(first) > 3
    assert set(range(max(first))) <= set(seen)


def test_infeasible_proposals_are_counted_and_rewarded_lowest() -> None:
    learner, given = adr(), list[torch.Tensor]()
    learn = learner._svpg.learn

    def watched(found: torch.Tensor) -> dict[str, float]:
        given.append(found.flatten())
        return learn(found)

    cast(Any, learner._svpg).learn = watched
    learner.source.z[:3] = INFEASIBLE / 2
    collector = DifferingCollector(learner.source)
    experience = DifferingExperience(collector)
    for _ in range(10):
        learner.source.z[:3] = INFEASIBLE / 2
        (figures,) = go_on(learner, collector, experience, 1)
        share = (learner.randomizer._noted[-PROPOSALS:, 0] < INFEASIBLE).mean()
        assert share >= 0.15
        assert figures["proposals_infeasible"] == pytest.approx(share)
        assert (given[-1][:3] <= given[-1].min()).all()


def test_a_round_without_a_feasible_proposal_is_rewarded_as_the_lowest_so_far() -> None:
    learner = adr()
    collector = DifferingCollector(learner.source)
    experience = DifferingExperience(collector)
    go_on(learner, collector, experience, 3)
    assert learner._lowest < 0.0
    learner.source.z[:] = INFEASIBLE / 2
    collector._begin(np.arange(len(collector.z)))
    (figures,) = go_on(learner, collector, experience, 1)
    assert figures["proposals_infeasible"] == 1.0
    assert figures["proposal_reward"] == pytest.approx(learner._lowest)


class DivergingExperience(DifferingExperience):
    """So many of the episodes in a load diverge at their second step."""

    diverge: int

    def play(self, *args: Any, **kwargs: Any) -> TensorDict:  # noqa: ANN401
        played = super().play(*args, **kwargs)
        played["next", "infeasible"][: self.diverge, 1] = True
        played["mask"][: self.diverge, 2:] = False
        return played


def test_references_that_diverge_are_left_out_unless_all_do() -> None:
    learner = adr()
    experience = DivergingExperience(collector := DifferingCollector(learner.source))
    experience.diverge = 1
    while not learner._references:
        assert not learner.update(next(collector), experience)
    assert [len(each) for each in learner._references] == [LENGTH] * (len(experience.contexts_played[0]) - 1)
    assert go_on(learner, collector, experience, 2)  # and the next load plays others in their place
    learner, experience.diverge = adr(), PROPOSALS
    with pytest.raises(ConfigError, match="reference of distribution_learner=adr, is infeasible"):
        go_on(learner, DifferingCollector(learner.source), experience, 1)


def test_a_bound_of_the_discriminator_is_told_by_its_own_name() -> None:
    with pytest.raises(ConfigError, match=r"distribution_learner\.discriminator\.clip is 0"):
        Discriminator(3, 0, [8], 1e-3, 8, 1.0, clip=0.0)


def test_the_box_of_the_randomizer_is_the_cube() -> None:
    learner = adr(ranges={"gain": [0.3, 0.4]})
    run_z = learner.source.z
    assert ((run_z >= 0.3) & (run_z <= 0.4)).all()


def test_a_context_that_is_shown_is_hidden_from_the_discriminator() -> None:
    learner = adr(context_shown=True)
    collector = DifferingCollector(learner.source)
    batch = next(collector)
    for place in ("observation", ("next", "observation")):
        batch[place] = torch.cat([cast(torch.Tensor, batch[place]), cast(torch.Tensor, batch["context"])], -1)
    learner.update(batch, DifferingExperience(collector))
    assert learner._answers
    for answer in learner._answers.values():
        assert answer.transitions.shape == (LENGTH, 3) or answer.infeasible


def test_contexts_of_an_algorithms_own_are_refused() -> None:
    learner = adr()
    collector = DifferingCollector(learner.source)
    batch = next(collector)
    batch["proposal"] = torch.full(batch.shape, UNKEYED)
    with pytest.raises(ConfigError, match="no proposal is ever answered"):
        learner.update(batch, DifferingExperience(collector))


def test_another_randomizer_and_a_context_without_parameters_are_told() -> None:
    parts: Any = (0, None, None, False, [], 1)
    with pytest.raises(ConfigError, match=r"which UniformRandomizer cannot\. Take randomizer=empirical"):
        ADR(UniformRandomizer(SPACE, None), *parts)
    with pytest.raises(ConfigError, match="nothing to propose"):
        ADR(EmpiricalRandomizer(ContextSpace(()), None, 1, 1), *parts)


def test_continues_exactly() -> None:
    whole, first = adr(), adr()
    torch.manual_seed(0)
    expected, experience = run(whole, 7)
    torch.manual_seed(0)
    _, cut = run(first, 3)
    collectors = cut._collector
    assert isinstance(collectors, DifferingCollector)
    first.update(next(collectors), cut)  # in the middle of a round
    second = adr(seed=5)
    state = first.state_dict()
    other = DifferingCollector(second.source, seed=5)
    other.load_state_dict(collectors.state_dict())
    second.load_state_dict(state)
    played = DifferingExperience(other)
    played.rng.bit_generator.state = cut.rng.bit_generator.state
    found = go_on(second, other, played, 4)
    assert found == expected[3:]
    assert len(experience.contexts_played) == len(cut.contexts_played) + len(played.contexts_played)
    np.testing.assert_array_equal(whole.source.z, second.source.z)
    np.testing.assert_array_equal(whole.randomizer._noted, second.randomizer._noted)


def test_particles_and_discriminator_of_another_run_are_taken_over() -> None:
    taught = adr()
    run(taught, 4)
    state = taught.state_dict()
    for inherits in (["particles"], ["discriminator"], ["particles", "discriminator"]):
        learner = adr(seed=1, inherits=inherits)
        before = learner._svpg.particles.actors.rows.detach().clone()
        learner.inherit(state)
        rows, vector = learner._svpg.particles.actors.rows, state["discriminator"]["vector"]
        assert torch.equal(rows, taught._svpg.particles.actors.rows if "particles" in inherits else before)
        made = learner._discriminator
        assert (made is not None and torch.equal(made.state_dict()["vector"], vector)) == ("discriminator" in inherits)


def test_a_frozen_discriminator_stays_as_it_is() -> None:
    taught, learner = adr(), adr(seed=1, epochs=0.0)
    run(taught, 4)
    learner.inherit(taught.state_dict())
    assert learner._discriminator is not None
    before = learner._discriminator.state_dict()
    run(learner, 3)
    after = learner._discriminator.state_dict()
    assert torch.equal(before["vector"], after["vector"])
    for name, value in before["normaliser"].items():
        assert torch.equal(value, after["normaliser"][name])
