"""What slots are given of a round of proposals."""

import numpy as np

from dr_lab.distribution_learners.adr.proposals import OpenProposals

Z = np.array([[0.0], [1.0], [2.0], [3.0]])


def drawn(proposals: OpenProposals) -> set[int]:
    rngs = [np.random.default_rng(seed) for seed in range(64)]
    found = proposals.propose(rngs, np.arange(64))
    np.testing.assert_array_equal(found.z[:, 0], (found.keys - proposals.first).astype(float))
    return set(found.keys.tolist())


def test_slots_draw_what_waits_and_where_nothing_does_all_alike() -> None:
    proposals = OpenProposals(Z)
    assert drawn(proposals) == {0, 1, 2, 3}
    assert proposals.answer(1) == 1
    proposals.run(np.array([2, 2]))
    assert drawn(proposals) == {0, 3}
    proposals.run(np.array([0, 2, 3]))
    assert drawn(proposals) == {0, 1, 2, 3}
    assert not proposals.answered


def test_answers_of_another_round_and_second_ones_count_for_nothing() -> None:
    proposals = OpenProposals(Z)
    assert [proposals.answer(key) for key in (0, 0, 4, -1)] == [0, None, None, None]
    for key in (1, 2, 3):
        proposals.answer(key)
    assert proposals.answered
    proposals.renew(Z[:2])
    assert [proposals.answer(key) for key in (3, 5)] == [None, 1]
    proposals.renew(Z)
    assert drawn(proposals) == {6, 7, 8, 9}
