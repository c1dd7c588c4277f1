"""Stretches in which a joint is held are left out of what is proposed."""

import pytest

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.faults.fault_words import common_stretch
from dr_lab.proposal.held import without_held
from dr_lab.proposal.split import Split


def held(log: str, rest: str) -> Fault:
    return Fault("held", log, "hinge", 0.0, 0.8, "hinge rests.", "Take the rest.", rest)


@pytest.mark.parametrize(
    ("names", "common"),
    [
        (["a[0.8:]"], "a[0.8:]"),
        (["a[0.8:4]", "a[1.2:4]"], "a[1.2:4]"),
        (["a[-9.2:]", "a[:-1.5]"], "a[-9.2:-1.5]"),
        (["a[10:]", "a[9:]"], "a[10:]"),  # by number, not by letter
        (["a[3.1:]", "a[:2.9]"], ""),
    ],
)
def test_what_stretches_have_in_common(names: list[str], common: str) -> None:
    assert common_stretch(names) == common


def test_a_log_that_is_split_begins_behind_the_hand() -> None:
    split = Split(("a.csv",), ("a[:4]",), ("a[4:]",), {})
    found = without_held(split, [held("a[:4]", "a[0.8:4]")], ["a"])
    assert (found.fit, found.held_out) == (("a[0.8:4]",), ("a[4:]",))
    assert found.shortened == {"a[:4]": "a[0.8:4] of it is taken. hinge rests."}


def test_whole_logs_are_named_where_one_of_them_is_cut() -> None:
    split = Split(("*.csv",), None, ("c",), {})
    found = without_held(split, [held("b", "b[0.8:]"), held("c", "c[:3]")], ["a", "b", "c"])
    assert (found.fit, found.held_out) == (("a", "b[0.8:]"), ("c[:3]",))


def test_a_log_of_which_nothing_would_be_left_stays_as_it_is() -> None:
    split = Split(("a.csv",), ("a[:4]",), ("a[4:]",), {})
    assert without_held(split, [held("a[:4]", "a[3.1:4]"), held("a[:4]", "a[:2.9]")], ["a"]) is split


def test_other_faults_cut_nothing() -> None:
    split = Split(("*.csv",), None, ("c",), {})
    off = Fault("off", "a", "motor", 0.0, 0.8, "The machine is off.", "Leave it out.")
    assert without_held(split, [off], ["a", "b", "c"]) is split
