"""What a position that is asked of a joint has in common with the joint's logged angle."""

import numpy as np
import pytest

from dr_lab.measurements.inventory import Place
from dr_lab.proposal.drives import Command, Drive
from dr_lab.proposal.output import Output
from dr_lab.proposal.search import Found
from dr_lab.proposal.setpoints import counted
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Given, Outcome, Reading
from dr_lab.proposal.words import read_name

NOTHING = np.zeros((1, 1))
TRIED = Outcome(NOTHING[0], (), NOTHING, NOTHING, NOTHING, NOTHING[0])
FOUND = Found((Reading(0, 1.0, np.pi),), TRIED, (), ())  # an angle that counts from upright
KP = 5.0  # N·m/rad


def series(name: str) -> Series:
    return Series(Place("", name, "", "column"), read_name("", name, ""), ())


def command(constant: float, unit: str, *, servo: bool, seen: bool = True) -> Command:
    """A model's own actuator, beside whose command a constant force acts."""
    drive = Drive("motor", 0, "joint", "rad" if servo else "N·m", KP, servo=servo, added=False, slides=False)
    given = Given(0, 0.0, KP, 0.0, 0.0, constant, 0.01)
    return Command(drive, series("goal"), given, unit, 1, 1.0, 0.0, seen=seen, why="", doubts=())


ANGLE = Output("joint.position", (series("angle"),), "deg", -1, 180.0, wrap=False, why="")


@pytest.mark.parametrize(
    ("given", "offset"),
    [
        (command(KP * np.pi, "rad", servo=True), np.pi),
        (command(KP * np.pi, "deg", servo=True), 180.0),
        (command(0.1 * KP, "rad", servo=True), 0.0),  # a target that counts as the model does, under a small force
        (command(KP * np.pi, "N·m", servo=False), 0.0),  # a torque counts from nowhere
    ],
)
def test_a_target_gets_the_angles_offset_where_the_force_agrees(given: Command, offset: float) -> None:
    assert counted(given, FOUND, ANGLE).offset == pytest.approx(offset)


def test_a_target_that_the_motion_does_not_show_is_read_as_the_angle() -> None:
    found = counted(command(0.0, "rad", servo=True, seen=False), FOUND, ANGLE)
    assert (found.sign, found.unit) == (-1, "deg")
