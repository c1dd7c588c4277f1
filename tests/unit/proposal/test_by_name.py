"""Which series a joint may be, by the numbers in both names."""

import pytest

from dr_lab.measurements.inventory import Place
from dr_lab.proposal.by_name import matches
from dr_lab.proposal.drives import Drive, commands_by_name
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


def drive(name: str, *, slides: bool = False) -> Drive:
    return Drive(name, 0, name, "N" if slides else "N·m", 1.0, servo=False, added=False, slides=slides)


@pytest.mark.parametrize(
    ("names", "columns", "found"),
    [
        (("a1", "a2", "z3"), ("a1_cur_A", "a2_cur_A", "link_V"), {"a1": "a1_cur_A", "a2": "a2_cur_A"}),
        (("z3",), ("link_V",), {"z3": "link_V"}),  # where no name says more
        (("z3",), ("hook_N",), {}),  # a force drives no hinge
    ],
)
def test_a_command_is_what_its_name_says_or_no_name_says_more(
    names: tuple[str, ...], columns: tuple[str, ...], found: dict[str, str]
) -> None:
    commands = commands_by_name([drive(name) for name in names], [series(name) for name in columns])
    assert {each.drive.name: each.series.place.path for each in commands} == found


def test_a_force_may_drive_a_slide() -> None:
    (command,) = commands_by_name([drive("z3", slides=True)], [series("hook_N")])
    assert command.unit == "N"


@pytest.mark.parametrize(
    ("name", "kind", "unit", "identity"),
    [
        ("Motordrehzahl [1/min]", "velocity", "rpm", set()),
        ("Drehzahl [U/min]", "velocity", "rpm", set()),
        ("Schlittenposition [mm]", "position", "mm", {"schlitten"}),
        ("Armwinkel [°]", "position", "", {"arm"}),
        ("Sollstrom [A]", "drive", "A", set()),
        ("ElbowAngle_deg", "position", "deg", {"elbow"}),
        ("elbowtorque", "drive", "", {"elbow"}),
        ("position", "position", "", set()),
        ("Ángulo", "position", "", set()),
        ("VELOCIDA", "velocity", "", set()),
        ("REFERENC", "reference", "", set()),
        ("Sollweg_mm", "reference", "mm", set()),
        ("Winkel_Grad", "position", "deg", set()),
        ("pos_m3", "position", "", {"m"}),
        ("pos_m[3]", "position", "m", set()),
    ],
)
def test_a_word_that_names_a_thing_and_its_quantity_is_two(name: str, kind: str, unit: str, identity: set[str]) -> None:
    words = read_name("", name, "")
    assert (words.kind, words.unit, words.identity) == (kind, unit, identity)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("hook_load_N", "other"),
        ("motor_load_N", "drive"),
        ("present_load", ""),
        ("dc_bus_V", "other"),
        ("DCbus_V", "other"),
        ("Vbat", "other"),
        ("u_link1", "drive"),
        ("loadcell_N", "other"),
    ],
)
def test_a_load_cell_and_a_supply_drive_nothing(name: str, kind: str) -> None:
    assert read_name("", name, "").kind == kind
