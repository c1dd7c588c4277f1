"""Algorithms that are stopped, saved and continued, beside one that is not."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.collectors.collector import Collector
from dr_lab.collectors.experience import Experience
from dr_lab.training.checkpoint import load, save


class Learning(NamedTuple):
    """An algorithm at work.

    Attributes:
        algorithm: what learns.
        source: where its batches come from, with a state of its own.
        step: one iteration.
    """

    algorithm: Algorithm
    source: Any
    step: Callable[[], object]


def iterating(algorithm: Algorithm, experience: Experience) -> Learning:
    """An algorithm that collects by itself."""
    return Learning(algorithm, experience._collector, lambda: algorithm.iterate(experience))


def updating(algorithm: Algorithm, collector: Collector) -> Learning:
    """An algorithm that is given batches."""
    return Learning(algorithm, collector, lambda: algorithm.update(next(collector)))


def learn_whole_and_in_parts(learning: Sequence[Learning], counts: tuple[int, int], folder: Path) -> list[object]:
    """Let one learn through, and a third go on from a file with what a second has learnt before.

    Args:
        learning: what takes all steps, what takes those before the file is written, and what takes those after it, of
            another seed until then.
        counts: steps before and after.
        folder: for the file.

    Returns:
        What the last steps gave.
    """
    (whole, first, second), (before, after) = learning, counts
    for _ in range(before + after):
        whole.step()
    for _ in range(before):
        first.step()
    save(folder / "continued.pt", first.algorithm.state_dict())
    second.algorithm.load_state_dict(load(folder / "continued.pt"))
    second.source.load_state_dict(first.source.state_dict())
    return [second.step() for _ in range(after)]
