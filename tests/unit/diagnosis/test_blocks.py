"""Which windows are taken together, and which of many."""

import numpy as np
import pytest
from diagnosis_machines import evidence_settings

from dr_lab.diagnosis.evidence.left_out import parts_of
from dr_lab.diagnosis.windows.blocks import spread


@pytest.mark.parametrize(("count", "most", "places"), [(11, 3, [0, 5, 10]), (2, 5, [0, 1]), (4, 1, [0]), (0, 3, [])])
def test_places_are_evenly_spread_from_the_first_to_the_last(count: int, most: int, places: list[int]) -> None:
    assert spread(count, most).tolist() == places


@pytest.mark.parametrize(
    ("log", "parts"),
    [([0, 0, 1, 1, 2, 2], [[0, 1], [2, 3], [4, 5]]), ([0, 0, 0, 1, 1, 1], [[0], [1], [2], [3], [4], [5]])],
)
def test_few_logs_are_left_out_in_blocks(log: list[int], parts: list[list[int]]) -> None:
    """Two logs are fewer than three; six windows are fewer than eight blocks, so that each is one."""
    found = parts_of(np.array(log), evidence_settings(least_trusted=3, least_blocks=8))
    assert [rows.tolist() for rows in found] == parts
