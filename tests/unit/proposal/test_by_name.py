"""Which series a joint may be, by the numbers in both names."""

import pytest

from dr_lab.measurements.inventory import Place
from dr_lab.proposal.by_name import matches
from dr_lab.proposal.survey import Series
from dr_lab.proposal.words import read_name


def series(name: str) -> Series:
    return Series(Place("", name, "", "column"), read_name("", name, ""), ())


@pytest.mark.parametrize(
    ("joints", "columns", "found"),
    [
        (("j5", "j3", "j4"), ("pos (3)", "pos (4)", "pos (5)"), [[2], [0], [1]]),
        (("axis_1", "axis_2"), ("q2", "dq2", "q1"), [[2], [0, 1]]),
        (("joint_1", "joint_2"), ("data[0]", "data[1]"), [[0], [1]]),  # other numbers: in the order of the model
        (("shoulder", "elbow"), ("q1", "q2"), [[0], [1]]),
        (("j5", "j3"), ("pos (3)", "pos (4)"), [[0], [1]]),
    ],
)
def test_numbers_that_both_names_have_tell_which_is_which(
    joints: tuple[str, ...], columns: tuple[str, ...], found: list[list[int]]
) -> None:
    assert matches(joints, [series(name) for name in columns]) == found
