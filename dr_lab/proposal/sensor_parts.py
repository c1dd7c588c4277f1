"""Single axes of the model's sensors, where the logs hold no whole vector: what a camera sees in its picture."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.physics.compiling import compiled
from dr_lab.proposal.by_name import said_of
from dr_lab.proposal.lengths import is_bare
from dr_lab.proposal.output import Output
from dr_lab.proposal.poses import poses
from dr_lab.proposal.sensors import Sensed, pairs, read_vector, sensors_of
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.vectors import VectorKind, find_parts
from dr_lab.trajectory import Array

_KINDS: tuple[VectorKind, ...] = ("position", "rate", "acceleration")
_STILL = 1e-6  # share of the most that an axis changes, below which another does not


def find_sensor_parts(spec: mujoco.MjSpec, logs: Survey, sensed: Sensed, settings: ProposalSettings) -> Sensed:
    """What was found, and the axes that are read by sensors of the model of which no whole vector was.

    Args:
        spec: the robot's.
        logs: what the logs hold, without what sensors read already.
        sensed: what was found of whole vectors.
        settings: thresholds.
    """
    found = replace(sensed, outputs=[*sensed.outputs], doubts=[*sensed.doubts])
    read = {output.channel for output in sensed.outputs}
    vectors = find_parts(_free(spec, [each for each in logs.series if each.moves]))
    for kind in _KINDS:
        names = [name for name in sensors_of(spec, kind) if f"sensor.{name}" not in read]
        for name, vector in pairs(names, [each for each in vectors if each.kind == kind], found):
            unit, why, doubts = read_vector(vector, vectors, settings)
            axes = _Axes(vector.axes, "")
            if kind == "position":
                axes = _within(vector.axes, _changes(spec, name))
            doubts += [axes.doubt] if axes.doubt else []
            found.doubts += [f"sensor.{name}: {doubt}." for doubt in doubts]
            found.outputs += [
                Output(f"sensor.{name}.{axis}", (part,), unit, 1, 0.0, wrap=False, why=why)
                for axis, part in zip(axes.letters, vector.parts, strict=True)
            ]
    return found


def _free(spec: mujoco.MjSpec, series: list[Series]) -> list[Series]:
    """The series that are no joint's by name; a slide may be what x, y or z says."""
    scalar = [j for j in spec.joints if j.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)]
    said = said_of([joint.name for joint in scalar], series)
    slides = any(joint.type == mujoco.mjtJoint.mjJNT_SLIDE for joint in scalar)
    return [each for k, each in enumerate(series) if k not in said and not (slides and is_bare(each))]


@dataclass(frozen=True)
class _Axes:
    """Axes of a sensor that columns are read as, one letter each, and what is unsure about them."""

    letters: str
    doubt: str


def _within(said: str, changes: Array) -> _Axes:
    """The axes that columns say, or the one that is left where the model cannot move along one that they say."""
    moving = {axis for axis, change in zip("xyz", changes, strict=True) if change > _STILL * changes.max()}
    stuck, left = [axis for axis in said if axis not in moving], sorted(moving - {*said})
    if len(stuck) == len(left) == 1:
        return _Axes(
            said.replace(stuck[0], left[0]),
            f"the model does not move along {stuck[0]}, so that the column {stuck[0]} is read as its axis {left[0]}; "
            "check the directions",
        )
    doubt = (
        f"the model does not move along {', '.join(stuck)}, as the logs do: theirs may be another frame"
        if stuck
        else ""
    )
    return _Axes(said, doubt)


def _changes(spec: mujoco.MjSpec, sensor: str) -> Array:
    """How far a position that a sensor reads changes over the model's places, by axis, shape (3,), m."""
    read = [data.sensor(sensor).data.copy() for data in poses(compiled(spec.copy()))]
    return np.ptp(np.asarray(read, np.float64), axis=0)
