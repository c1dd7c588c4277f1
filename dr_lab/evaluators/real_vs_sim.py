"""What a policy is worth on a machine that its model does not know everything of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np
import torch

from dr_lab.envs.task import Change, Task, Values
from dr_lab.errors import ConfigError, require_numbers
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Row, Subject
from dr_lab.evaluators.statistics import iqm_interval
from dr_lab.physics.context import ContextSpace
from dr_lab.plants.machine import Vector
from dr_lab.plants.operator import Experiment
from dr_lab.plants.rig import Rig
from dr_lab.plants.tracking import track
from dr_lab.recorders.episode import Episode
from dr_lab.reports.quantity import percent
from dr_lab.training.recorded import record
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Pair:
    """One start played twice.

    Attributes:
        real: on the machine.
        simulated: in the model.
    """

    real: Episode
    simulated: Episode

    @property
    def expected(self) -> float:
        """Return in the model; NaN where this diverged."""
        return np.nan if self.simulated.ended == "infeasible" else self.simulated.undiscounted

    @property
    def difference(self) -> float:
        """Return on the machine less that in the model."""
        return self.real.undiscounted - self.expected

    @property
    def rmse(self) -> Array:
        """Root mean square difference of the positions for as long as both episodes last, rad or m, shape (nq,)."""
        steps = min(len(self.real.qpos), len(self.simulated.qpos))
        return np.sqrt(np.mean((self.real.qpos[:steps] - self.simulated.qpos[:steps]) ** 2, axis=0))


@dataclass(frozen=True)
class RealVsSimEvaluator(Evaluator):
    """Plays a policy on another simulator's machine, with its own true values and a hidden effect, and in the model.

    Every episode is played twice from one start: on the machine, and in the model at its nominal context, which of the
    model of a run (``model@env.model=from_run``) is what the run fitted. Differences are therefore paired, episode by
    episode. The policy sees positions and velocities as they are; encoders and latencies of the bench, and effects of
    the model at sensors, play no part. A policy that sees the context is told the nominal one.

    Both loops are closed, so that a small gap may grow into another course. Recorded commands of measured logs are
    played in a model by ``dr-lab compare``, that of a run by ``dr-lab compare model=from_run model.run=FOLDER``.

    Attributes:
        plant: the machine, what is hidden in it and how closely it is followed.
        machine: seed of the machine's true values.
        episodes: on each.
        confidence: of the intervals.
        resamples: of the bootstrap.
        seed: of starts and bootstrap.

    Raises:
        ConfigError: a number is out of its range.
    """

    plant: Rig
    machine: int
    episodes: int
    confidence: float
    resamples: int
    seed: int

    def __post_init__(self) -> None:
        least = {"episodes": 1, "resamples": 1}
        require_numbers(self, "evaluator", positive=("confidence",), least=least, below={"confidence": 1.0})

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play both.

        Raises:
            ConfigError: the task needs more than positions and velocities, or the machine has other joints, actuators.
        """
        del folder
        setting = subject.setting
        self._require_same(setting.task, setting.model.nominal())
        simulated = record(
            subject.slots(self.episodes, self.seed), subject.policy, np.tile(setting.space.nominal, (self.episodes, 1))
        )
        pairs = []
        for number, twin in enumerate(simulated, start=1):
            real = self._on_plant(subject, twin, f"real_{number}")
            pairs.append(Pair(real, replace(twin, name=f"simulated_{number}")))
            progress(number / self.episodes)
        widest = max(pairs, key=lambda pair: np.nan_to_num(abs(pair.difference)))
        shown = [widest.real, widest.simulated]
        rows, told = [_row(pair) for pair in pairs], self._told()
        return Evaluation(self._figures(pairs), rows, _units(widest), episodes=shown, told=told)

    def _told(self) -> str:
        hidden = self.plant.hidden
        inside = ", ".join(f"{key} {value}" for key, value in hidden.parameters.items())
        return (
            f"{self.episodes} episodes on the machine of seed {self.machine} (hidden in it: {hidden.label}"
            f"{f', {inside}' if inside else ''}) and from the same starts in the model. Returns are interquartile "
            f"means, low and high their {percent(self.confidence)} intervals; infeasible is the share of episodes that "
            "diverge in the model."
        )

    def _figures(self, pairs: Sequence[Pair]) -> dict[str, float]:
        """Interquartile means with their intervals, without what diverged; the difference is that of pairs."""
        columns = {
            "real": [pair.real.undiscounted for pair in pairs],
            "simulated": [pair.expected for pair in pairs],
            "difference": [pair.difference for pair in pairs],
        }
        figures = {}
        for name, values in columns.items():
            found = iqm_interval(np.array(values), self.confidence, self.resamples, self.seed)
            figures |= {name: found.value, f"{name}.low": found.low, f"{name}.high": found.high}
        return figures | {"infeasible": float(np.mean(~np.isfinite(columns["simulated"])))}

    def _require_same(self, task: Task, compiled: mujoco.MjModel) -> None:
        joints = [compiled.joint(i).name for i in range(compiled.njnt)]
        actuators = [compiled.actuator(i).name for i in range(compiled.nu)]
        if joints != list(self.plant.joints) or actuators != list(self.plant.actuators):
            raise ConfigError(
                f"evaluator.plant has joints {', '.join(self.plant.joints)} and actuators "
                f"{', '.join(self.plant.actuators)}; the model has {', '.join(joints)} and {', '.join(actuators)}. "
                "Choose the plant of the same machine: plant@evaluator.plant=NAME. Available: the options of plant in "
                "dr-lab record --help."
            )
        if set(task.reads) - {"qpos", "qvel"}:
            raise ConfigError(
                f"Task {type(task).__name__} reads {', '.join(task.reads)}; a plant knows positions and velocities "
                "alone. Take a task that reads no more."
            )

    def _on_plant(self, subject: Subject, twin: Episode, name: str) -> Episode:
        """The episode on the plant that begins as its twin in the model."""
        task, plant = subject.setting.task, self.plant
        seconds = task.frame_skip * float(twin.geometry.opt.timestep)
        time = np.arange(task.time_limit + 1, dtype=np.float64) * seconds
        experiment = Experiment(
            machine=plant.nominal.machine(plant.nominal.true_values(self.machine)),
            effect=plant.hidden,
            documented=plant.documented,
            issued=time[:-1],
            latency=0.0,
            instants=time,
            start=(*twin.qpos[0].tolist(), *twin.qvel[0].tolist()),
            accuracy=plant.accuracy,
        )
        states, actions = track(experiment, _controller(subject, twin))
        joints, degrees = len(plant.joints), states.shape[1] // 2
        qpos, qvel = states[:, :joints], states[:, degrees : degrees + joints]
        values = values_at_nominal(subject.setting.space)
        reward = rewards(task, values, qpos, qvel, actions, seconds)
        last = len(reward)
        return replace(
            twin,
            name=name,
            context={},
            time=time[: last + 1],
            qpos=qpos[: last + 1],
            qvel=qvel[: last + 1],
            action=actions[:last],
            reward=reward,
            ended="terminated" if task.terminated(_fields(qpos[[last]], qvel[[last]]), values).any() else "truncated",
        )


def _controller(subject: Subject, twin: Episode) -> Callable[[int, Vector, Vector], Vector]:
    """What the policy does in a state of the plant."""
    setting, task, space = subject.setting, subject.setting.task, subject.setting.space
    low, high = task.action_bounds(twin.geometry)
    values = values_at_nominal(space)
    told = space.to_unit(space.nominal)[None] if setting.show_context else np.empty((1, 0))

    def controller(instant: int, position: Vector, velocity: Vector) -> Vector:
        del instant
        fields = _fields(np.array([position]), np.array([velocity]))
        seen = np.concatenate([task.observe(fields, values), told], axis=1)
        with torch.no_grad():
            action = subject.policy(torch.from_numpy(seen.astype(np.float32)))
        return np.clip(action.double().numpy()[0], low, high).tolist()

    return controller


def values_at_nominal(space: ContextSpace) -> Values:
    """The nominal context of a single state, by name."""
    return {p.name: np.array([p.nominal]) for p in space.parameters}


def rewards(task: Task, values: Values, qpos: Array, qvel: Array, actions: Array, seconds: float) -> Array:
    """Reward of each control step of a trajectory up to where the task ends it, shape (≤ t,).

    Args:
        task: what rewards.
        values: the context.
        qpos: positions before the first and after every control step, shape (t + 1, nq).
        qvel: velocities, shape (t + 1, nv).
        actions: shape (t, nu).
        seconds: length of a control step.
    """
    before, after = _fields(qpos[:-1], qvel[:-1]), _fields(qpos[1:], qvel[1:])
    terminated = task.terminated(after, values)
    change = Change(task.marker(before), task.marker(after), after, values, terminated, actions, seconds)
    ended = np.flatnonzero(terminated)
    return task.reward(change)[: ended[0] + 1 if len(ended) else len(actions)]


def _row(pair: Pair) -> Row:
    model = pair.real.geometry
    names = [model.joint(i).name for i in range(model.njnt)]
    return {
        "episode": pair.real.name.removeprefix("real_"),
        "real": pair.real.undiscounted,
        "simulated": pair.expected,
        "difference": pair.difference,
        **{f"{name}.rmse": float(error) for name, error in zip(names, pair.rmse, strict=True)},
    }


def _units(pair: Pair) -> dict[str, str]:
    """Of the positions' errors."""
    model = pair.real.geometry
    slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    return {f"{model.joint(i).name}.rmse": "m" if slide else "rad" for i, slide in enumerate(slides)}


def _fields(qpos: Array, qvel: Array) -> dict[str, Array]:
    return {"qpos": qpos, "qvel": qvel}
