"""Verb `add`: put one effect into the model, refit, and show the error before and after."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from dr_lab.comparison.all_windows import on_all_windows
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run
from dr_lab.comparison.ladder_report import Told, report_ladder
from dr_lab.comparison.lesson import Lesson, lesson_at, measured_joints
from dr_lab.comparison.progress import Screen, screen
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import Effect, PlacedEffect, place
from dr_lab.effects.residual_force import ResidualForce
from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport

_SITES = ("joint", "actuator", "body", "sensor")


def add(
    comparison: Comparison,
    effects: Mapping[str, Effect],
    effect: Mapping[str, str | None],
    recorder: Look,
    run_dir: Path,
) -> GapReport:
    """Add the given effects at the given site, in order, whatever the evidence; the report says what it is worth.

    A force that is learned (`residual_force`) comes last.

    `effect` says where they sit: exactly one of ``joint``, ``actuator``, ``body``, ``sensor`` is set, or none where an
    effect has a single site; its ``run`` is for the effects' configuration. The other arguments are those of
    `dr_lab.workflows.close.close`.

    Returns:
        The report (schema dr_lab/gap/1); its ladder has one more model per effect.

    Raises:
        ConfigError: no site or several are given where one is needed.
        UnknownNameError: the effect cannot sit there.
        DataError: no force of the state explains logs that it was not learned from.
        ModelError: it cannot act there; the message says why.
    """
    with screen() as told:
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        learned = [one for one in effects.values() if isinstance(one, ResidualForce)]
        placed = [_place(study, one, effect) for one in effects.values() if one not in learned]
        joints = [_joint(study, one, effect) for one in learned]
        told.phase("Calibrating the model")
        ladder = Ladder((), calibrate(study), ())
        for one in placed:
            ladder = _extend(study, ladder, one, told.ranking([one.label]))
        lessons = [_lesson(study, ladder, *pair, told) for pair in zip(learned, joints, strict=True)]
        ladder = ladder if ladder.rungs else _judged_as_it_is(study, ladder)
        return report_ladder(Told("add", tuple(lessons), always=True), study, ladder, Run(run_dir, recorder, told))


def _extend(study: Study, ladder: Ladder, effect: PlacedEffect, done: Callable[[str], None]) -> Ladder:
    base = ladder.models[-1]
    ranking = rank(study.bench, base, [effect], done)
    ladder = ladder.topped(ranking.base)
    rung = Rung.judged(study.bench, ranking.base, ranking.candidates)
    found = ranking.candidates[0]
    last = found.fitted_model if found.final else on_all_windows(study, ranking.base, found)
    step = AddedEffect(last, (), proven=bool(rung.verdict.effects))
    return replace(ladder, rungs=(*ladder.rungs, rung), steps=(*ladder.steps, step))


def _judged_as_it_is(study: Study, ladder: Ladder) -> Ladder:
    """The ladder with one rung, on which no effect of the catalogue was asked for."""
    return replace(ladder, rungs=(Rung.judged(study.bench, ladder.base, ()),))


def _lesson(study: Study, ladder: Ladder, effect: ResidualForce, joint: str, told: Screen) -> Lesson:
    told.phase(f"Learning what nobody catalogued at {joint}")
    found = lesson_at(study, ladder.models[-1], joint, effect)
    if found is None:
        raise DataError(
            f"No force at joint {joint!r} that depends on motion and commands explains parts of the fitted logs that "
            "it was not learned from: there is nothing to add. What is missing may depend on time or on what happened "
            "before, or act at another joint; dr-lab diagnose says where the model fails."
        )
    return found


def _joint(study: Study, effect: ResidualForce, wanted: Mapping[str, str | None]) -> str:
    """The joint at which a force is learned."""
    joints, given = measured_joints(study), _given(wanted)
    site = next(iter(given.values()), joints[0] if len(joints) == 1 else "")
    if len(given) > 1 or not site:
        raise ConfigError(_one_site(effect, given, joints))
    if site not in joints:
        raise UnknownNameError("joint", site, joints, "the logs, which must measure its position")
    if any(each.label == f"{effect.name}@{site}" for each in study.model.effects):
        raise ConfigError(f"The model has a learned force at {site} already: begin with the model before it.")
    return site


def _given(wanted: Mapping[str, str | None]) -> dict[str, str]:
    return {kind: name for kind in _SITES if (name := wanted.get(kind))}


def _one_site(effect: Effect, given: Mapping[str, str], sites: Sequence[str]) -> str:
    listed = ", ".join(f"effect.{kind}={name}" for kind, name in given.items()) or "nothing"
    return (
        f"Effect {effect.name!r} needs one site; given: {listed}. Available: {', '.join(sites) or 'none'}. "
        f"Say e.g. effect.joint={sites[0] if sites else 'NAME'}."
    )


def _place(study: Study, effect: Effect, wanted: Mapping[str, str | None]) -> PlacedEffect:
    sites, given = effect.sites(study.compiled), _given(wanted)
    if len(given) > 1 or (not given and len(sites) != 1):
        raise ConfigError(_one_site(effect, given, sites))
    placed = place(effect, study.compiled, next(iter(given.values()), sites[0]), study.scales)
    study.model.with_effect(placed).nominal()  # says why the effect cannot act there, before anything is fitted
    return placed
