"""Verb `add`: put one effect into the model, refit, and show the error before and after."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run
from dr_lab.comparison.ladder_report import report_ladder
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.search.ladder import Ladder, Rung
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.verdict import decide
from dr_lab.effects.effect import Effect, PlacedEffect, place
from dr_lab.errors import ConfigError
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport


def add(
    comparison: Comparison,
    effects: Mapping[str, Effect],
    effect: Mapping[str, str | None],
    recorder: Look,
    run_dir: Path,
) -> GapReport:
    """Add the given effects at the given site, in order, whatever the evidence; the report says what it is worth.

    `effect` says where they sit: exactly one of ``joint``, ``actuator``, ``body``, ``sensor`` is set, or none where an
    effect has a single site. The other arguments are those of `dr_lab.workflows.close.close`.

    Returns:
        The report (schema dr_lab/gap/1); its ladder has one more model per effect.

    Raises:
        ConfigError: no site or several are given where one is needed.
        UnknownNameError: the effect cannot sit there.
        ModelError: it cannot act there; the message says why.
    """
    with screen() as told:
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        placed = [_place(study, one, effect) for one in effects.values()]
        told.phase("Calibrating the model")
        ladder = Ladder((), calibrate(study), ())
        for one in placed:
            ladder = _extend(study, ladder, one, told.ranking(1))
        return report_ladder("add", study, ladder, Run(run_dir, recorder, told))


def _extend(study: Study, ladder: Ladder, effect: PlacedEffect, done: Callable[[str], None]) -> Ladder:
    base = ladder.models[-1]
    ranking = rank(study.bench, base, [effect], done)
    ladder = ladder.topped(ranking.base)
    rung = Rung(
        ranking.base,
        ranking.candidates,
        decide(ranking.base, ranking.candidates, study.bench.evidence, study.bench.scored),
    )
    step = AddedEffect(ranking.candidates[0].fitted_model, (), proven=bool(rung.verdict.effects))
    return replace(ladder, rungs=(*ladder.rungs, rung), steps=(*ladder.steps, step))


def _place(study: Study, effect: Effect, wanted: Mapping[str, str | None]) -> PlacedEffect:
    sites, given = effect.sites(study.compiled), {kind: name for kind, name in wanted.items() if name}
    if len(given) > 1 or (not given and len(sites) != 1):
        listed = ", ".join(f"effect.{kind}={name}" for kind, name in given.items()) or "nothing"
        raise ConfigError(
            f"Effect {effect.name!r} needs one site; given: {listed}. Available: {', '.join(sites) or 'none'}. "
            f"Say e.g. effect.joint={sites[0] if sites else 'NAME'}."
        )
    placed = place(effect, study.compiled, next(iter(given.values()), sites[0]), study.scales)
    study.model.with_effect(placed).nominal()  # says why the effect cannot act there, before anything is fitted
    return placed
