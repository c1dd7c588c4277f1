"""A machine by another simulator, with true values and a hidden effect of its own."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
import torch
from tensordict import TensorDict, pad_sequence

from dr_lab.collectors.collector import Drive, Policy
from dr_lab.envs.batched_env import single
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError
from dr_lab.plants.machine import Vector
from dr_lab.plants.operator import Experiment
from dr_lab.plants.rig import Rig
from dr_lab.plants.tracking import track
from dr_lab.recorders.joint_labels import commanded
from dr_lab.seeding import stream
from dr_lab.targets.target import Target, require_drive
from dr_lab.targets.task_view import TaskView
from dr_lab.trajectory import Array


class PlantTarget(Target):
    """SciPy on the equations of motion; encoders and latencies of the bench play no part.

    Args:
        setting: machine and task as this side knows them.
        plant: the machine, what is hidden in it and how closely it is followed.
        machine: seed of the machine's true values.
        seed: of the starts that are not given, which are those of the task.

    Raises:
        ConfigError: the machine has other joints or actuators, or the task reads more than positions and velocities.
    """

    nature: ClassVar[str] = (
        "no hardware but a machine by another simulator, SciPy on the equations of motion, with the true values and "
        "the hidden effect of evaluator.target.plant"
    )

    def __init__(self, setting: Setting, plant: Rig, machine: int, seed: int) -> None:
        self._setting, self._plant = setting, plant
        self._compiled = setting.model.nominal()
        self._require_same()
        self._view = TaskView(setting)
        self._machine = plant.nominal.machine(plant.nominal.true_values(machine))
        self._stream = stream(seed, "target")

    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """Episode after episode; a start that is not given is the task's."""
        acts, courses = require_drive(drive), []
        for index in range(count):
            if starts is None:
                start = self._setting.task.start(self._stream, self._compiled)
            else:
                start = starts[0][index], starts[1][index]
            if isinstance(acts, np.ndarray):
                courses.append(self._play(_recited(acts[index]), len(acts[index]), *start))
            else:
                courses.append(self._play(self._closed(acts), self._view.steps, *start))
        return pad_sequence(courses)

    def _play(self, drive: Callable[[int, Array, Array], Array], steps: int, qpos: Array, qvel: Array) -> TensorDict:
        plant, view = self._plant, self._view
        time, actions = np.arange(steps + 1, dtype=np.float64) * view.seconds, list[Array]()

        def controller(instant: int, position: Vector, velocity: Vector) -> Vector:
            asked = drive(instant, np.array([position]), np.array([velocity]))
            actions.append(np.clip(asked, view.low, view.high))
            return view.commands(actions[-1][None])[0].tolist()

        experiment = Experiment(
            machine=self._machine,
            effect=plant.hidden,
            documented=plant.documented,
            issued=time[:-1],
            latency=0.0,
            instants=time,
            start=(*qpos.tolist(), *qvel.tolist()),
            accuracy=plant.accuracy,
        )
        states, _ = track(experiment, controller)
        joints, degrees = len(plant.joints), states.shape[1] // 2
        return view.course(states[:, :joints], states[:, degrees : degrees + joints], np.stack(actions))

    def _closed(self, policy: Policy) -> Callable[[int, Array, Array], Array]:
        def act(instant: int, qpos: Array, qvel: Array) -> Array:
            del instant
            with torch.no_grad():
                return policy(single(self._view.observe(qpos, qvel))).double().numpy()[0]

        return act

    def _require_same(self) -> None:
        compiled, plant = self._compiled, self._plant
        joints = [compiled.joint(i).name for i in range(compiled.njnt)]
        actuators = [compiled.actuator(row).name for row in commanded(compiled)]
        if joints != list(plant.joints) or actuators != list(plant.actuators):
            raise ConfigError(
                f"The target's plant has joints {', '.join(plant.joints)} and actuators {', '.join(plant.actuators)}; "
                f"the model has {', '.join(joints)} and {', '.join(actuators)}. Choose the plant of the same machine: "
                "plant@evaluator.target.plant=NAME (dr-lab train: plant@distribution_learner.target.plant=NAME). "
                "Available: the options of plant in dr-lab record --help. Or take target=model."
            )


def _recited(commands: Array) -> Callable[[int, Array, Array], Array]:
    return lambda instant, qpos, qvel: commands[instant]
