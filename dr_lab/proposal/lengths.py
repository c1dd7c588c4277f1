"""Columns that are lengths by their names, which hinges hardly are."""

from collections.abc import Sequence

import mujoco

from dr_lab.proposal.by_name import matches, said_of
from dr_lab.proposal.command_units import factors
from dr_lab.proposal.output import Output
from dr_lab.proposal.survey import Series
from dr_lab.proposal.tokens import tokens

_AXES = ({"x"}, {"y"}, {"z"})
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def is_bare(series: Series) -> bool:
    """Whether a series is called x, y or z and nothing else, units apart."""
    said = tokens(series.place.label or series.place.path)
    return not series.words.asked and {*said[:1]} in _AXES and (len(said) == 1 or bool(series.words.unit))


def is_length(series: Series) -> bool:
    """Whether a series' name says that it is a length."""
    return series.words.unit in factors("m", series.words.unit) or (is_bare(series) and not series.words.unit)


def joints_may_be(model: mujoco.MjModel, joints: Sequence[str], series: Sequence[Series]) -> list[list[int]]:
    """The series that each joint may be, as `matches`; for a hinge, lengths only where nothing else is left."""
    found = []
    for joint, places in zip(joints, matches(joints, series), strict=True):
        turns = model.jnt_type[model.joint(joint).id] == _HINGE
        angles = [k for k in places if not is_length(series[k])]
        found.append(angles if turns and angles else places)
    return found


def lengths_as_angles(model: mujoco.MjModel, outputs: Sequence[Output]) -> list[str]:
    """What is unsure about hinges whose position is a column that is a length by its name, a sentence each."""
    doubts = []
    for i in range(model.njnt):
        joint = model.joint(i).name
        series = [output.parts[0] for output in outputs if output.channel == f"{joint}.position"]
        if model.jnt_type[i] == _HINGE and series and is_length(series[0]) and not said_of([joint], series):
            doubts.append(
                f"{series[0].place} is a length by its name, but read as the angle of {joint}, as no other column may "
                "be that. If it is where a point of the machine is, put a site there and a sensor that reads it "
                '(<framepos objtype="site">) into the model: then it is read as that sensor\'s.'
            )
    return doubts
