"""Logs of a plant: the source that `record` writes by default."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import yaml

from dr_lab.plants.rig import Rig, RigRecording
from dr_lab.plants.truth import truth
from dr_lab.recorders.mcap import FloatArrays, JointStates
from dr_lab.sources.source import NamedLog

_WARNING = "# The truth behind these logs. Whoever looks for what is missing must not read it.\n"


@dataclass(frozen=True)
class PlantSource:
    """Experiments on a simulated machine.

    Attributes:
        plant: the machine on its bench.
        joint_topic: topic of the encoder readings, ``sensor_msgs/msg/JointState``; velocities only where the
            instruments report them.
        command_topic: topic of the commands, ``std_msgs/msg/Float64MultiArray`` with one number for each actuator.
    """

    plant: Rig
    joint_topic: str
    command_topic: str

    def logs(self, seed: int) -> Iterator[NamedLog]:
        """The logs of the machine that the seed stands for."""
        return map(self._named, self.plant.recordings(seed))

    def companions(self, seed: int) -> Mapping[str, bytes]:
        """``truth.yaml``: true parameters, hidden effect and clock."""
        text = yaml.safe_dump(truth(self.plant, seed), sort_keys=False, allow_unicode=True)
        return {"truth.yaml": (_WARNING + text).encode()}

    def _named(self, recording: RigRecording) -> NamedLog:
        joints = JointStates(
            self.joint_topic,
            self.plant.joints,
            recording.stamp,
            recording.arrival,
            recording.position,
            recording.velocity,
        )
        commands = FloatArrays(self.command_topic, self.plant.actuators, recording.command_time, recording.command)
        return NamedLog(recording.name, (joints, commands), {"source": "simulated machine"})
