"""A force that nobody catalogued: learned at a joint, and judged by logs that it was not learned from."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.comparison.localised import predicted_score
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.missing_force.force_step import Machine
from dr_lab.diagnosis.missing_force.learning import Prospect, learn_force, prospect
from dr_lab.effects.effect import place
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.effects.residual_force import ResidualForce, learned_forces
from dr_lab.reports.force_entries import LearnedEntry

Phase = Callable[[str], None]


@dataclass(frozen=True)
class Lesson:
    """What was learned at a joint, and what it is worth.

    Attributes:
        fitted_model: the model with the force as its last effect.
        joint: where it acts.
        removes: share of the squared predicted error of the held-out logs that it removes; negative where that grows.
        by_log: root mean square predicted error of each held-out log without and with it, in standard deviations of
            the noise.
        chi2: χ² of the held-out logs, whose starts are fitted, without and with it.
        accepted: whether it is worth keeping.
    """

    fitted_model: FittedModel
    joint: str
    removes: float
    by_log: Mapping[str, tuple[float, float]]
    chi2: tuple[float, float]
    accepted: bool

    @property
    def force(self) -> LearnedForce:
        """The force."""
        return learned_forces(self.fitted_model.model)[self.joint]

    def entry(self) -> LearnedEntry:
        """What the report says of it."""
        inputs = tuple(f"{each.quantity} of {each.name}" for each in self.force.basis.inputs)
        effect = self.fitted_model.model.effects[-1].label
        return LearnedEntry(self.joint, effect, inputs, self.accepted, self.removes, dict(self.by_log), self.chi2)


def lessons(study: Study, base: FittedModel, phase: Phase) -> tuple[Lesson, ...]:
    """Learn forces joint by joint, the most promising first, until one is not accepted.

    Nothing is learned where noise alone is left, or where no log is held out, by which it could be judged.

    Args:
        study: model and logs.
        base: the best model without them.
        phase: is told what begins.
    """
    found: list[Lesson] = []
    if not study.bench.apart:
        return ()
    while len(found) < study.settings.learning.joints and not at_floor(base.held_out, study.bench.evidence):
        held = learned_forces(base.model)
        phase("Learning what nobody catalogued")
        best = _best(study, base, [joint for joint in measured_joints(study) if joint not in held])
        lesson = None if best is None else _lesson(study, base, best)
        if lesson is None:
            break
        found.append(lesson)
        if not lesson.accepted:
            break
        base = lesson.fitted_model
    return tuple(found)


def lesson_at(study: Study, base: FittedModel, joint: str, given: ResidualForce) -> Lesson | None:
    """Learn a force at one joint, or fit the size of a given one.

    Args:
        study: model and logs.
        base: the model without it.
        joint: where it acts.
        given: the effect, with what another run learned or with nothing.

    Returns:
        What was learned; None where no function of the state explains logs that it was not learned from.
    """
    if joint not in given.learned:
        best = _best(study, base, [joint])
        return None if best is None else _lesson(study, base, best)
    effect = place(given, study.compiled, joint, study.scales)
    model = base.model.with_effect(effect)
    start = model.space.vector({**base.values(), effect.parameters[0].name: 1.0})
    return _judged(study, joint, base, fit_and_score(study.bench, model, start, base.fit.delta))


def measured_joints(study: Study) -> tuple[str, ...]:
    """Joints whose position is measured."""
    channels = (samples.channel for samples in study.bench.fit.samples)
    return tuple(channel.name.removesuffix(".position") for channel in channels if channel.kind == "position")


def _best(study: Study, base: FittedModel, joints: Sequence[str]) -> Prospect | None:
    learning = study.settings.learning
    machines = [Machine(study.bench, study.compiled, study.scales, joint, learning.most) for joint in joints]
    found = [each for machine in machines if (each := prospect(machine, base, learning)) is not None]
    return max(found, key=lambda each: each.choice.share, default=None)


def _lesson(study: Study, base: FittedModel, found: Prospect) -> Lesson | None:
    model = learn_force(found, study.settings.learning)
    if model is None:
        return None
    return _judged(study, found.machine.joint, base, model)


def _judged(study: Study, joint: str, base: FittedModel, model: FittedModel) -> Lesson:
    """A lesson by the predicted errors without and with the force.

    It is accepted if logs are held out, their squared error together falls by `learning.better`, that of none rises by
    more than `learning.worse`, nor does what is left where starts are fitted, and no further window diverges. No
    held-out log has a part in learning or choosing it.
    """
    learning, windows = study.settings.learning, study.predicted
    before, after = (predicted_score(study, each.model, each.fit.z) for each in (base, model))
    both = (before.window_count > 0) & (after.window_count > 0)
    squares = {name: _of_log(windows.log == k, both, before, after) for k, name in enumerate(windows.logs)}
    sums = [float(score.window_sum[both].sum()) for score in (before, after)]
    removes = 1.0 - sums[1] / sums[0] if sums[0] > 0 else 0.0
    chi2 = (base.held_out.chi2, model.held_out.chi2)
    no_worse = all(last <= first * (1.0 + learning.worse) for first, last in (*squares.values(), chi2))
    kept = study.bench.apart and no_worse and removes >= learning.better and after.infeasible <= before.infeasible
    roots = {name: (first**0.5, last**0.5) for name, (first, last) in squares.items()}
    return Lesson(model, joint, removes, roots, chi2, accepted=bool(kept))


def _of_log(rows: np.ndarray, both: np.ndarray, before: Score, after: Score) -> tuple[float, float]:
    """Mean squared error of a log without and with the force."""
    chosen = rows & both
    count = max(float(before.window_count[chosen].sum()), 1.0)
    return float(before.window_sum[chosen].sum()) / count, float(after.window_sum[chosen].sum()) / count
