"""What a policy is worth on a machine that its model does not know everything of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np
from tensordict import TensorDict

from dr_lab.envs.setting import Setting, require_mujoco
from dr_lab.errors import ConfigError
from dr_lab.evaluators.evaluator import Evaluation, Progress, Row, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.joint_labels import entries
from dr_lab.recorders.training import Sample
from dr_lab.targets.target import Target
from dr_lab.training.recorded import as_episode, record
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
        return np.nan if _diverged(self.simulated) else self.simulated.undiscounted

    @property
    def difference(self) -> float:
        """Return on the machine less that in the model."""
        return self.real.undiscounted - self.expected

    @property
    def rmse(self) -> Array:
        """Root mean square difference of the positions for as long as both episodes last, shape (nq,).

        A free or ball joint has several numbers, each of which differs for itself: m of a place, 1 of a quaternion.
        """
        steps = min(len(self.real.qpos), len(self.simulated.qpos))
        return np.sqrt(np.mean((self.real.qpos[:steps] - self.simulated.qpos[:steps]) ** 2, axis=0))


@dataclass(frozen=True, kw_only=True)
class RealVsSimEvaluator(IntervalEvaluator):
    """Plays a policy on a target, which stands for the real machine, and in the model.

    Every episode is played twice from one start: on the target, and in the model at its nominal context, which of the
    model of a run (``model@env.model=from_run``) is what the run fitted. Differences are therefore paired, episode by
    episode. The policy sees positions and velocities as they are; encoders and latencies of a bench, and effects of the
    model at sensors, play no part. A policy that sees the context is told the nominal one.

    Both loops are closed, so that a small gap may grow into another course. Recorded commands of measured logs are
    played in a model by ``dr-lab compare``, that of a run by ``dr-lab compare model=from_run model.run=FOLDER``.

    Attributes: as `IntervalEvaluator`, its episodes on target and model each, and
        target: makes the target of a machine and its task.

    Raises:
        ConfigError: a number is out of its range.
    """

    target: Callable[[Setting], Target]

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play both.

        Raises:
            ConfigError: the target does not fit the task or cannot be driven, or MuJoCo does not simulate the machine.
        """
        del folder
        setting, pairs = require_mujoco(subject.setting, "evaluator=real_vs_sim"), []
        target, slots = _driven(self.target(setting)), subject.slots(self.episodes, self.seed)
        simulated = record(setting, slots, subject.policy, np.tile(setting.space.nominal, (self.episodes, 1)))
        for number, twin in enumerate(simulated, start=1):
            course = cast(TensorDict, target.play(subject.policy, (twin.qpos[:1], twin.qvel[:1]), 1)[0])
            real = as_episode(course, f"real_{number}", twin.geometry, setting.seconds, {})
            pairs.append(Pair(real, replace(twin, name=f"simulated_{number}")))
            progress(number / self.episodes)
        widest = max(pairs, key=lambda pair: np.nan_to_num(abs(pair.difference)))
        shown, solved = [widest.real, widest.simulated], _solved(setting, pairs)
        rows = [{**_row(pair), **{key: float(each[i]) for key, each in solved.items()}} for i, pair in enumerate(pairs)]
        figures = self._figures(pairs) | {key: float(values.mean()) for key, values in solved.items()}
        returns = {"real": [p.real.undiscounted for p in pairs], "simulated": [p.expected for p in pairs]}
        samples = [Sample(name, np.array(values), "An episode each.") for name, values in returns.items()]
        return Evaluation(
            figures, rows, _units(widest), samples=samples, episodes=shown, told=self._told(target, pairs, bool(solved))
        )

    def _told(self, target: Target, pairs: Sequence[Pair], solved: bool) -> str:
        known = sum(map(np.isfinite, [pair.difference for pair in pairs]))
        share = "; solved that of those at whose end the task is solved" if solved else ""
        return (
            f"What is called real is {target.nature}, as config.yaml tells. {self.episodes} episodes were played on "
            "it, and from the same starts in the model. Returns are interquartile means, low and high their "
            f"intervals ({self.stated(len(pairs), known)}); infeasible is the share of episodes that diverge in the "
            "model and are left out, real.infeasible that of those on what is called real, which count with the return "
            f"that the task declares{share}."
        )

    def _figures(self, pairs: Sequence[Pair]) -> dict[str, float]:
        """Interquartile means with their intervals, without what diverged in the model; the difference is of pairs."""
        columns = {
            "real": [pair.real.undiscounted for pair in pairs],
            "simulated": [pair.expected for pair in pairs],
            "difference": [pair.difference for pair in pairs],
        }
        figures = {}
        for name, values in columns.items():
            found = self.interval(np.array(values))
            figures |= {name: found.value, f"{name}.low": found.low, f"{name}.high": found.high}
        lost = {"infeasible": ~np.isfinite(columns["simulated"]), "real.infeasible": [_diverged(p.real) for p in pairs]}
        return figures | {name: float(np.mean(values)) for name, values in lost.items()}


def _diverged(episode: Episode) -> bool:
    return episode.ended == "infeasible"


def _driven(target: Target) -> Target:
    """The target, where a policy can act on it."""
    if not target.drivable:
        raise ConfigError(
            f"evaluator=real_vs_sim lets the policy act on the target, which here is {target.nature} and cannot be "
            "driven. Recorded commands are played in a model by dr-lab compare, that of a run by dr-lab compare "
            "model=from_run model.run=FOLDER. For a policy, take target@evaluator.target=plant or =model."
        )
    return target


def _solved(setting: Setting, pairs: Sequence[Pair]) -> dict[str, Array]:
    """Whether the task is solved at the end, 0 or 1 by episode, shape (k,); nothing where it names no such thing."""
    last = {"real": [pair.real for pair in pairs], "simulated": [pair.simulated for pair in pairs]}
    found = {key: setting.task.solved(np.stack([e.observation[-1] for e in each])) for key, each in last.items()}
    return {f"{key}.solved": values.astype(np.float64) for key, values in found.items() if values is not None}


def _row(pair: Pair) -> Row:
    return {
        "episode": pair.real.name.removeprefix("real_"),
        "real": pair.real.undiscounted,
        "simulated": pair.expected,
        "difference": pair.difference,
        **dict(zip(_units(pair), pair.rmse.tolist(), strict=True)),
    }


def _units(pair: Pair) -> dict[str, str]:
    """Of the positions' errors, by their names, as `Pair.rmse` has them."""
    return {f"{each.dotted}.rmse": each.unit for each in entries(pair.real.geometry)[0]}
