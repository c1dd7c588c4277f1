"""What a policy is worth on a machine that its model does not know everything of."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import torch

from dr_lab.envs.task import Change, Task
from dr_lab.errors import ConfigError, require_numbers
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import iqm_interval
from dr_lab.plants.bench import Bench
from dr_lab.plants.machine import Vector
from dr_lab.plants.operator import Experiment
from dr_lab.plants.tracking import track
from dr_lab.seeding import stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class RealVsSimEvaluator(Evaluator):
    """Plays a policy on another simulator's machine, with its own true values and a hidden effect, and in the model.

    Episodes begin in states of the task's one distribution. The policy sees positions and velocities as they are; the
    bench's encoders and latencies play no part.

    Attributes:
        plant: the machine, what is hidden in it and how closely it is followed.
        machine: seed of the machine's true values.
        episodes: on each.
        confidence: of the intervals.
        resamples: of the bootstrap.
        seed: of starts and bootstrap.

    Raises:
        ConfigError: a number is too small.
    """

    plant: Bench
    machine: int
    episodes: int
    confidence: float
    resamples: int
    seed: int

    def __post_init__(self) -> None:
        require_numbers(self, "evaluator", positive=("confidence",), least={"episodes": 1, "resamples": 1})

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play both.

        Raises:
            ConfigError: the task needs more than positions and velocities, or the machine has other joints, actuators.
        """
        del folder
        compiled = subject.setting.model.nominal()
        self._require_same(subject.setting.task, compiled)
        real = []
        for episode in range(self.episodes):
            start = subject.setting.task.start(stream(self.seed, "start", str(episode)), compiled)
            real.append(self._on_plant(subject, compiled, *start))
            progress((episode + 1) / (self.episodes + 1))
        nominal = np.tile(subject.setting.space.nominal, (self.episodes, 1))
        simulated = subject.rollouts(self.episodes, self.seed).returns(nominal)
        progress(1.0)
        rows = [
            {"episode": float(k), "real": float(r), "simulated": float(s)}
            for k, (r, s) in enumerate(zip(real, simulated, strict=True))
        ]
        figures = {}
        for name, returns in (("real", np.array(real)), ("simulated", simulated)):
            found = iqm_interval(returns, self.confidence, self.resamples, self.seed)
            figures |= {name: found.value, f"{name}.low": found.low, f"{name}.high": found.high}
        return Evaluation(figures, rows)

    def _require_same(self, task: Task, compiled: mujoco.MjModel) -> None:
        joints = [compiled.joint(i).name for i in range(compiled.njnt)]
        actuators = [compiled.actuator(i).name for i in range(compiled.nu)]
        if joints != list(self.plant.joints) or actuators != list(self.plant.actuators):
            raise ConfigError(
                f"evaluator.plant has joints {', '.join(self.plant.joints)} and actuators "
                f"{', '.join(self.plant.actuators)}; the model has {', '.join(joints)} and {', '.join(actuators)}. "
                "Choose the plant of the same machine: /plant@evaluator.plant=…"
            )
        if set(task.reads) - {"qpos", "qvel"}:
            raise ConfigError(
                f"Task {type(task).__name__} reads {', '.join(task.reads)}; a plant knows positions and velocities "
                "alone. Take a task that reads no more."
            )

    def _on_plant(self, subject: Subject, compiled: mujoco.MjModel, qpos: Array, qvel: Array) -> float:
        """Return of one episode on the plant, up to its end."""
        task, plant = subject.setting.task, self.plant
        low, high = task.action_bounds(compiled)
        seconds = task.frame_skip * float(compiled.opt.timestep)

        def controller(instant: int, position: Vector, velocity: Vector) -> Vector:
            del instant
            seen = task.observe(_fields(np.array([position]), np.array([velocity])))
            with torch.no_grad():
                action = subject.policy(torch.from_numpy(seen.astype(np.float32)))
            return np.clip(action.double().numpy()[0], low, high).tolist()

        time = np.arange(task.time_limit + 1, dtype=np.float64) * seconds
        experiment = Experiment(
            machine=plant.nominal.machine(plant.nominal.true_values(self.machine)),
            effect=plant.hidden,
            documented=plant.documented,
            issued=time[:-1],
            latency=0.0,
            instants=time,
            start=(*qpos.tolist(), *qvel.tolist()),
            accuracy=plant.accuracy,
        )
        states, actions = track(experiment, controller)
        joints, degrees = len(plant.joints), states.shape[1] // 2
        return episode_return(task, states[:, :joints], states[:, degrees : degrees + joints], actions, seconds)


def episode_return(task: Task, qpos: Array, qvel: Array, actions: Array, seconds: float) -> float:
    """Undiscounted return of a trajectory up to where the task ends it.

    Args:
        task: what rewards.
        qpos: positions before the first and after every control step, shape (t + 1, nq).
        qvel: velocities, shape (t + 1, nv).
        actions: shape (t, nu).
        seconds: length of a control step.
    """
    before, after = _fields(qpos[:-1], qvel[:-1]), _fields(qpos[1:], qvel[1:])
    terminated = task.terminated(after)
    change = Change(task.marker(before), task.marker(after), after, terminated, actions, seconds)
    ended = np.flatnonzero(terminated)
    last = ended[0] + 1 if len(ended) else len(actions)
    return float(task.reward(change)[:last].sum())


def _fields(qpos: Array, qvel: Array) -> dict[str, Array]:
    return {"qpos": qpos, "qvel": qvel}
