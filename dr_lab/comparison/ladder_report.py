"""Report of a ladder: models with falling error, the ranking that chose each, and what is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

from dr_lab.comparison import entries, notes
from dr_lab.comparison.calibrated import Described, as_given, describe
from dr_lab.comparison.deciding import deciding_experiment
from dr_lab.comparison.finish import Run, answer, finish, save
from dr_lab.comparison.in_doubt import in_doubt
from dr_lab.comparison.inertia import inertia_entry
from dr_lab.comparison.knowledge_notes import changed_masses, richer_effects
from dr_lab.comparison.lesson import Lesson
from dr_lab.comparison.localised import failure
from dr_lab.comparison.measurable import measurable
from dr_lab.comparison.missing_force import missing_forces
from dr_lab.comparison.short_shifts import short_shifts
from dr_lab.comparison.study import Study
from dr_lab.comparison.trading import together, trading
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import Gain
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.recorders.overlay import AFTER, BEFORE
from dr_lab.reports.gap import GapReport, Judgement
from dr_lab.reports.gap_entries import CandidateEntry, ExplainedEntry, JudgedRungEntry, NoteEntry


@dataclass(frozen=True)
class Told:
    """What is told of a ladder.

    Attributes:
        verb: its name.
        lessons: what was learned beside the catalogue, in order.
        always: whether what was learned stays in the model though held-out logs do not ask for it.
    """

    verb: str
    lessons: tuple[Lesson, ...] = ()
    always: bool = False

    @property
    def models(self) -> tuple[FittedModel, ...]:
        """The models with learned forces that stay."""
        return tuple(lesson.fitted_model for lesson in self.lessons if lesson.accepted or self.always)


def report_ladder(
    told: Told, study: Study, ladder: Ladder, run: Run, experiments: ExperimentSettings | None = None
) -> GapReport:
    """Tell the answer of a verb that judges effects, then what belongs to it, and write the run.

    Args:
        told: the verb, and what was learned beside the ladder.
        study: model and logs.
        ladder: what was climbed; the first rung's ranking becomes the report's `ranking`.
        run: where the results go.
        experiments: how the next experiment is looked for; None for not at all.

    Returns:
        The report as written.
    """
    run.screen.phase("Scoring the models of the ladder")
    models = [*ladder.models, *told.models]
    described = [describe(study, fitted_model) for fitted_model in models]
    base, last = ladder.base, models[-1]
    judgement = replace(_judgement(study, ladder), learned=tuple(lesson.entry() for lesson in told.lessons))
    inertia = inertia_entry(last, described[-1].estimate)
    report = replace(_answer(told.verb, study, ladder, described, judgement), inertia=inertia)
    answer(report, run)
    run.screen.phase("Looking where the model fails and what it misses")
    # First, because what misses forces is among its windows.
    failing = failure(study, base.model, base.fit.z, base.held_out)
    judgement = replace(judgement, missing_force=missing_forces(study, models))
    if experiments is not None:
        save(replace(report, judgement=judgement, failure=failing), run)
        run.screen.phase("Looking for the next experiment")
        judgement = replace(judgement, next_experiment=deciding_experiment(study, ladder, experiments, run.folder))
    before = (base.model, base.fit.z) if last is not base else (study.model, study.model.space.nominal)
    shown = {BEFORE: before, AFTER: (last.model, last.fit.z)}
    found = replace(report, judgement=judgement, failure=failing)
    return finish(study, found, shown, run, described[-1].estimate)


def _answer(verb: str, study: Study, ladder: Ladder, described: Sequence[Described], judgement: Judgement) -> GapReport:
    rivals = [(), *(step.rivals for step in ladder.steps)]
    models = [
        replace(d.rung, rivals=tuple(c.effect.label for c in beside))
        for d, beside in zip(described, rivals, strict=False)
    ]
    models += [replace(d.rung, learned=True) for d in described[len(rivals) :]]
    report = entries.begun(verb, study, models, ladder.models[-1].held_out)
    return replace(
        report,
        notes=(
            *trading(described[-1].estimate),
            *together(ladder.models[-1]),
            *measurable(ladder),
            *short_shifts(study.bench, ladder),
            *in_doubt(ladder, study.bench.evidence),
            *notes.fit_notes([each.fitted_model for each in described]),
            *report.notes,
            *_ladder_notes(study, ladder),
        ),
        verdict=_verdict(ladder, study.bench.evidence),
        as_given=as_given(study)[1],
        judgement=judgement,
    )


def _judgement(study: Study, ladder: Ladder) -> Judgement:
    """What is known before anybody looks where the model fails."""
    first, evidence = ladder.rungs[0], study.bench.evidence
    return Judgement(
        confirmation=entries.confirmation(ladder.confirmation),
        gap_closed=ladder.closed(evidence),
        explained=_explained(ladder.gained(evidence)),
        reason=" ".join([reason_of(study, first, ladder), *(law.sentence for law in ladder.laws if law.refuted)]),
        laws=entries.laws(ladder.laws),
        ranking=_ranking(study, first, ladder),
        rungs=tuple(_rung(study, rung, ladder) for rung in ladder.rungs),
        worst_direction=entries.worst_direction(ladder.models[-1]),
        confidence=evidence.confidence,
    )


def _explained(gain: Gain) -> ExplainedEntry:
    """Share of the calibrated model's error that the added effects remove, its interval, and the gap closed by channel.

    The error is what its χ² is above noise, in a typical window; None where there is none.
    """
    share, low, high = (
        min(value / gain.error, 1.0) if gain.error > 0 else None for value in (gain.share, gain.low, gain.high)
    )
    return ExplainedEntry(share, low, high, dict(gain.channels))


def _ladder_notes(study: Study, ladder: Ladder) -> list[NoteEntry]:
    changed = [
        *notes.dropped(ladder.dropped),
        *notes.put_back(ladder.put_back),
        *notes.searched_periods(ladder),
        *notes.moved_bounds(ladder),
    ]
    last = ladder.models[-1]
    of_logs = [*notes.disagreeing_logs(study.bench, last), *notes.shared_loads(study.bench, last)]
    open_still = [*changed_masses(last), *richer_effects(ladder.rungs, ladder.refuted)]
    return [*notes.few_blocks(study.bench), *of_logs, *open_still, *notes.refused(ladder.refused), *changed]


def _verdict(ladder: Ladder, settings: EvidenceSettings) -> str:
    """The ladder's verdict where all was added with support, else that of the rung that gave none."""
    for rung, step in zip(ladder.rungs, ladder.steps, strict=False):
        if not step.proven:  # an effect that a user added without support
            return rung.verdict.kind
    return ladder.verdict(settings)


def reason_of(study: Study, rung: Rung, ladder: Ladder) -> str:
    """The verdict's reason; of effects that cannot be separated, also what the other parameters make up for.

    An effect that the rung names, but the ladder does not keep, is told with what became of it.
    """
    found = {c.effect.label: c.fitted_model for c in rung.ranking}
    labels = rung.verdict.effects
    told = [entries.trade(labels[0], found[labels[0]], rival, found[rival], study.bench) for rival in labels[1:]]
    later = [f"It was put back to {b.poorer}; see the notes." for b in ladder.put_back if labels[:1] == (b.richer,)]
    lost = ["It was dropped again; see the notes."] if set(labels[:1]) & set(ladder.dropped) else []
    same = ["Nothing but the effect named before was tried here, at other sites."] if _elsewhere(rung, ladder) else []
    return " ".join([rung.verdict.reason, *same, *told, *(later or lost)])


def _elsewhere(rung: Rung, ladder: Ladder) -> bool:
    """Whether a rung asked only where else the effect of the one before it sits."""
    return rung.alike and rung is not ladder.rungs[0]


def _ranking(study: Study, rung: Rung, ladder: Ladder) -> tuple[CandidateEntry, ...]:
    """The candidates of a rung, as the ladder judged them in the end: what it put back is named no longer."""
    settled = reduce(lambda verdict, back: verdict.put_back(back.richer, back.poorer), ladder.put_back, rung.verdict)
    return entries.ranking(study, rung.ranking, settled)


def _rung(study: Study, rung: Rung, ladder: Ladder) -> JudgedRungEntry:
    return JudgedRungEntry(
        effects=tuple(effect.label for effect in rung.base.model.effects),
        verdict=rung.verdict.kind,
        chosen=tuple(rung.verdict.effects),
        on_trial=tuple(rung.verdict.trial),
        absorbed_by_parameters=tuple(rung.verdict.absorbed),
        reason=reason_of(study, rung, ladder),
        ranking=_ranking(study, rung, ladder),
    )
