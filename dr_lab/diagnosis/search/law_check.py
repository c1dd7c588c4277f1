"""Whether the law of a named effect is the machine's: does a free law of the same argument explain what it leaves?"""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.evidence.support import cleared, supported
from dr_lab.diagnosis.search.free_command import free_command
from dr_lab.diagnosis.search.free_inertia import free_inertia
from dr_lab.diagnosis.search.free_law import FreeLaw
from dr_lab.diagnosis.search.free_position import free_position
from dr_lab.diagnosis.search.freed import freed_score
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect, Scales
from dr_lab.reports.quantity import number, percent

_FREE = {
    "command": "a free curve of the command",
    "position": "a free curve of the position",
    "inertia": "another mass, centre or inertia of the body, or of those that it carries,",
}


@dataclass(frozen=True)
class LawCheck:
    """What a free law of an effect's argument explains beside the effect.

    Attributes:
        effect: the effect's label.
        argument: what its law is a function of.
        free: parameters of the free law.
        gain: of the model with the free law over the one without it, on the logs that score.
        refuted: whether the effect's law is not the machine's.
    """

    effect: str
    argument: str
    free: int
    gain: Gain
    refuted: bool

    @property
    def sentence(self) -> str:
        """What a refuted law means, in words."""
        return (
            f"{self.effect} is the nearest of the catalogue, but its law is not the machine's: {_FREE[self.argument]} "
            f"explains {percent(self.gain.gap)} of what it leaves (evidence Δχ² {number(self.gain.total)})."
        )


def check_laws(
    bench: Bench, steps: Sequence[AddedEffect], scales: Scales, compiled: mujoco.MjModel
) -> tuple[LawCheck, ...]:
    """Check the laws of the effects that were added, each in the last model.

    A free law of the argument (`Effect.argument`) acts beside the effect at its place, and a linear step of both and of
    the model's parameters on the fit windows tells what it leaves of those that score (`freed.freed_score`). It refutes
    the effect's law if its gain there is supported, its own parameters paid for, and it closes so much of the gap that
    the effect leaves as is asked of a cause (`LawSettings.least_closed`). How large its correction is beside the effect
    is not asked: a load on the wrong body explains 99 % of the motion, and is on the wrong body all the same.

    Where others cannot be told from the effect, the free law has to explain so much of what each of them leaves, too:
    then the machine has the law of none. If one of them is the truth, it leaves nothing of that size.

    Not checked are: a model that leaves noise alone; effects that others cannot be told from and beside which more was
    added since, for the others' models lack that; effects at a bound, which may leave what a wider bound would explain;
    laws without an argument of which there is a free law. Friction is among these: dry friction that creeps or bends is
    dry friction by another law, and what a free curve of the speed explains beside it (up to 95 % of what is left on
    our own plants) is no other effect.

    Source: Hart, Nonparametric Smoothing and Lack-of-Fit Tests (1997), chapter 1 (nested smooth alternatives).

    Args:
        bench: data and settings.
        steps: the added effects, in order.
        scales: size of the free laws.
        compiled: the compiled nominal model.
    """
    if not steps or at_floor(steps[-1].fitted_model.held_out, bench.evidence):
        return ()
    last, found = steps[-1].fitted_model, []
    for step in steps:
        rivals = step.rivals
        compared = not rivals or step is steps[-1]
        bounded = _at_a_bound(last, step.effect) or any(_at_a_bound(r.fitted_model, r.effect) for r in rivals)
        if not compared or bounded:
            continue
        free = _free(bench, step.effect, scales, compiled)
        if free is not None:
            found.append(_check(bench, [last, *(r.fitted_model for r in rivals)], step.effect, free))
    return tuple(found)


def _free(bench: Bench, effect: PlacedEffect, scales: Scales, compiled: mujoco.MjModel) -> FreeLaw | None:
    settings = bench.evidence.law
    if effect.effect.argument == "command":
        return free_command(effect, compiled, scales, settings)
    if effect.effect.argument == "position":
        return free_position(effect.site, compiled, scales, settings)
    return free_inertia(effect.site, compiled) if effect.effect.argument == "inertia" else None


def _at_a_bound(fitted_model: FittedModel, effect: PlacedEffect) -> bool:
    values = fitted_model.values()
    return any(any(p.ends(values[p.name])) for p in effect.parameters)


def _check(bench: Bench, models: Sequence[FittedModel], effect: PlacedEffect, free: FreeLaw) -> LawCheck:
    """The check of an effect in the first of some models, the others being those of its rivals."""
    freed = freed_score(bench, models[0], effect, free)
    gains = [paired_gain(model.held_out, freed, bench.evidence) for model in models]
    refuted = [_refutes(bench, model, freed, gain, len(free.own)) for model, gain in zip(models, gains, strict=True)]
    return LawCheck(effect.label, effect.effect.argument, len(free.own), gains[0], all(refuted))


def _refutes(bench: Bench, fitted_model: FittedModel, freed: Score, gain: Gain, own: int) -> bool:
    """Whether a free law of so many parameters closes as much of what a model leaves as is asked of a cause."""
    evidence = bench.evidence
    closes = gain.gap >= evidence.law.least_closed or cleared(fitted_model.held_out, freed, gain, evidence)
    return closes and supported(gain, own, evidence)
