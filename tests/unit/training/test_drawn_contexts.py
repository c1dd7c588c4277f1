"""Which contexts a run notes as drawn."""

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.training.drawn_contexts import DrawnContexts

NAMES = ["mass", "length"]


def batch(context: list[list[float]], proposal: list[list[int]] | None = None) -> TensorDict:
    """Of two slots; the second parameter is twice the first."""
    z = torch.tensor(context, dtype=torch.float64)
    keys = torch.full(z.shape, -1) if proposal is None else torch.tensor(proposal)
    return TensorDict({"context": torch.stack([z, 2 * z], -1), "proposal": keys}, batch_size=z.shape)


def noted(drawn: DrawnContexts) -> list[tuple[int, float]]:
    header, *rows = drawn.csv(NAMES).splitlines()
    assert header == "frames,mass,length"
    cells = [row.split(",") for row in rows]
    assert all(float(length) == 2 * float(mass) for _, mass, length in cells)
    return [(int(frames), float(mass)) for frames, mass, _ in cells]


def test_a_context_is_noted_when_a_slot_begins_with_it() -> None:
    drawn = DrawnContexts()
    drawn.take(batch([[0.1, 0.1, 0.3], [0.2, 0.2, 0.2]]))
    drawn.take(batch([[0.3, 0.3, 0.3], [0.2, 0.4, 0.4]]))  # the first slot goes on, the second begins anew at step 4
    assert noted(drawn) == [(0, 0.1), (0, 0.2), (4, 0.3), (8, 0.4)]


def test_a_proposal_counts_once_and_so_does_a_task_of_several_slots() -> None:
    drawn = DrawnContexts()
    drawn.take(batch([[0.1, 0.2], [0.1, 0.3]], [[7, 8], [7, 9]]))
    drawn.take(batch([[0.1, 0.5], [0.3, 0.5]], [[7, -1], [9, -1]]))
    assert sorted(noted(drawn)) == [(0, 0.1), (2, 0.2), (2, 0.3), (6, 0.5)]


def test_what_is_gone_on_with_is_the_same_as_what_was_never_interrupted() -> None:
    rng, whole, first, second = np.random.default_rng(0), DrawnContexts(), DrawnContexts(), DrawnContexts()
    batches = [batch(rng.integers(3, size=(2, 5)).astype(float).tolist()) for _ in range(4)]
    for each in batches:
        whole.take(each)
    for each in batches[:2]:
        first.take(each)
    second.load_state_dict(first.state_dict())
    for each in batches[2:]:
        second.take(each)
    assert second.csv(NAMES) == whole.csv(NAMES)
    assert len(noted(whole)) > 10


def test_machines_without_parameters_note_nothing() -> None:
    drawn = DrawnContexts()
    drawn.take(TensorDict({"context": torch.zeros(2, 3, 0), "proposal": torch.full((2, 3), -1)}, batch_size=[2, 3]))
    assert drawn.csv([]) == "frames\n"
