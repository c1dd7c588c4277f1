"""The ladder that a verb climbs, in windows that are as long as it takes.

The states at which windows begin are fitted, and take up what a slow effect does within a short window; long windows
hold fewer independent residuals, and more valleys in which a fit can end. So the shortest are asked first, and longer
ones only where these leave a gap unexplained, or an answer in doubt. What is found there is confirmed, as all else, on
windows that choose nothing (`dr_lab.diagnosis.windows.folds`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from dr_lab.comparison.calibrated import calibrated
from dr_lab.comparison.kept_climbs import KeptClimbs, Reached
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score, fitted_for_comparison
from dr_lab.diagnosis.evidence.confirmation import confirm
from dr_lab.diagnosis.evidence.noise_floor import at_coloured_floor, at_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.search.climb import Climb, climb
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.folds import folds
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import Effect
from dr_lab.errors import DataError


@dataclass(frozen=True)
class _Ascent:
    """What is the same in windows of all lengths; attributes as the arguments of `climbed`."""

    effects: Mapping[str, Effect]
    most: int
    watch: ClimbWatch
    kept: KeptClimbs


def climbed(
    study: Study, effects: Mapping[str, Effect], *, most: int, watch: ClimbWatch, kept: KeptClimbs | None = None
) -> tuple[Study, Ladder]:
    """The ladder in the shortest windows that leave no gap unexplained; where all do, in the shortest.

    1. Longer windows are believed where an effect explains the gap that shorter ones leave, not where it is gone.
    2. An answer of the shortest windows is in doubt where more than noise remains, and windows that chose nothing do
       not confirm it. It is asked again in the next longer ones, whose answer replaces it if it is in no doubt. Where
       too few windows chose nothing to know, it is not: of longer ones there are fewer still.
    3. Where the model leaves noise alone, it is also calibrated to longer windows: over short ones the fitted starts
       take up what a weak force does, such as dry friction of a pendulum that swings freely. If it leaves more than
       noise there, they are asked as in 1; where they do not explain it either, the gap is told.

    Each further length is one more chance of a false answer: of k lengths, those behind the first ask for the
    confidence 1 − (1 − confidence) / k (Bonferroni).

    Args:
        study: model and logs, with the shortest windows.
        effects: the catalogue.
        most: most effects that are added, one at several sites counted once; 0 ranks them, and adds what is named to
            look at it.
        watch: is told what begins and what was found so far.
        kept: how far an earlier run has come, and where is kept how far this one does; None keeps nothing.

    Returns:
        The study with the windows that were taken, and its ladder.
    """
    found, ladder = _first_settled(study, _Ascent(effects, most, watch, kept or KeptClimbs()))
    watch.phase("Checking what was found")
    return found, ladder.with_laws(found.bench, found.scales, found.compiled)


def as_far_as_it_predicts(study: Study, ladder: Ladder) -> Ladder:
    """The ladder without its last effects that, above the noise floor, do not predict better than those before them.

    Predicted are windows whose start is known from earlier samples alone: what an effect does for fitted starts only
    is no use to a simulator. Those of the last third of each log choose nothing here either. The first effect is left
    to `confirm`, which asks for more.

    Args:
        study: holds the windows that are predicted.
        ladder: as it was climbed.
    """
    windows, evidence = folds(study.predicted)[0], study.bench.evidence
    while len(ladder.steps) > 1 and not at_floor(ladder.models[-1].held_out, evidence):
        before, after = (score_of(*study.fits(each.model, each.fit.z, windows)) for each in ladder.models[-2:])
        if _better(before, after, evidence):
            break
        ladder = ladder.without_last()
    return ladder


def _better(before: Score, after: Score, evidence: EvidenceSettings) -> bool:
    """Whether fewer windows diverge, or as many do and the others' errors fall, of all together and typically."""
    if after.infeasible != before.infeasible:
        return after.infeasible < before.infeasible
    both = (before.window_count > 0) & (after.window_count > 0)
    falls = after.window_sum[both].sum() < before.window_sum[both].sum()
    return bool(falls) and paired_gain(before, after, evidence).total > 0


def _first_settled(study: Study, ascent: _Ascent) -> tuple[Study, Ladder]:
    lengths = study.settings.windows.lengths
    first = (study, _ladder(study, ascent, _base(study, ascent)))
    if _settled(*first):
        return first if first[1].steps else _as_long_as_noise(first, ascent)
    doubtful, confirmation = _explained(*first), first[1].confirmation
    if doubtful and confirmation is not None and not confirmation.enough:
        return first
    # Still longer windows are too few to settle a doubt.
    for length in lengths[1:2] if doubtful else lengths[1:]:
        why = "The answer is in doubt" if doubtful else f"A gap remains that nothing explains{_set_aside(first[1])}"
        ascent.watch.phase(f"{why}: windows of {length:.3g} s")
        longer = _with_windows(study, length, len(lengths), first[1] if doubtful else None)
        if longer is None or _dropped(study, longer) > study.settings.windows.most_dropped:
            break
        ladder = _ladder(longer, ascent, _base(longer, ascent, first[1].base))
        if ladder.steps and (_settled if doubtful else _explained)(longer, ladder):
            return longer, ladder
        # Noise that is correlated over long takes long windows to be told from a force.
        if not (first[1].steps or ladder.steps) and at_coloured_floor(ladder.base.held_out, study.bench.evidence):
            return longer, ladder
    return first


def _as_long_as_noise(first: tuple[Study, Ladder], ascent: _Ascent) -> tuple[Study, Ladder]:
    """The study and the ladder of a model that leaves noise alone, or those of longer windows that show a gap.

    What a force does to a position grows with the square of time, and its χ² with the fourth power, less what the
    starts take. Coloured noise stays as large as it is, but for what the starts of short windows took of it. Commands
    that changed without being logged are estimated as far as `WindowSettings.most_unlogged` allows, which longer
    windows exceed: there, nothing is asked.
    """
    study, lengths = first[0], first[0].settings.windows.lengths
    shown = first
    if study.bench.fit.unlogged is not None:
        return first
    for length in lengths[1:]:
        ascent.watch.phase(f"Only noise is left: windows of {length:.3g} s")
        longer = _with_windows(study, length, len(lengths), None)
        if longer is None or _dropped(study, longer) > study.settings.windows.most_dropped:
            break
        base = _base(longer, ascent, first[1].base)
        if not _grows(first[1].base.held_out, base.held_out, longer.bench.evidence):
            continue
        ladder = _ladder(longer, ascent, base)
        if _explained(longer, ladder):
            return longer, ladder
        shown = (longer, ladder) if shown is first else shown
    return shown


def _calibrated_from(study: Study, short: FittedModel) -> FittedModel:
    """The model calibrated to longer windows; where that leaves more than noise, also from where short ones led.

    Longer windows have more valleys in which a fit can end. The states are sought there before the parameters move.
    """
    base = calibrated(study)
    if at_floor(base.held_out, study.bench.evidence):
        return base
    _, states = study.fits(study.model, short.fit.z, study.bench.fit)
    near = fitted_for_comparison(study.bench, fit_and_score(study.bench, study.model, short.fit.z, states.delta))
    return min(base, near, key=lambda model: model.fit.order)


def _grows(short: Score, long: Score, evidence: EvidenceSettings) -> bool:
    """Whether a model leaves more than noise in longer windows, in some channel much more than in short ones."""
    pairs = ((channel.chi2, short.channels[name].chi2) for name, channel in long.channels.items())
    return not at_floor(long, evidence) and any(now > evidence.growth * max(before, 1.0) for now, before in pairs)


def _base(study: Study, ascent: _Ascent, short: FittedModel | None = None) -> FittedModel:
    """The model calibrated to the windows of a study, which are longer than those of `short` where that is given."""
    reached = ascent.kept.reached(study)
    if reached is not None:
        return reached.base
    ascent.watch.phase("Calibrating the model")
    base = calibrated(study) if short is None else _calibrated_from(study, short)
    ascent.kept.keep(study, Reached(base))
    return base


def _ladder(study: Study, ascent: _Ascent, base: FittedModel) -> Ladder:
    """The ladder in the windows of a study on its `_base`, which is climbed from as far as it was before."""
    kept = ascent.kept
    reached = kept.reached(study) or Reached(base)
    if reached.ladder is not None:
        return reached.ladder
    begun = reached.climb or Climb.begun(study.bench, base)
    ladder = climb(
        begun,
        ascent.effects,
        study.scales,
        study.compiled,
        most=ascent.most,
        watch=ascent.watch,
        keep=lambda climb: kept.keep(study, Reached(base, climb)),
    )
    ladder = _checked(study, ascent, ladder)
    kept.keep(study, Reached(base, ladder=ladder))
    return ladder


def _checked(study: Study, ascent: _Ascent, ladder: Ladder) -> Ladder:
    """A climbed ladder with what other windows say of it."""
    if not ascent.most:
        cases = SpecialCases(ascent.effects, study.scales, study.compiled)
        ladder = ladder.with_first_step().pruned(study.bench, cases)
    ladder = as_far_as_it_predicts(study, ladder)
    ladder = ladder.ended(study.bench) if study.model.inertials else ladder
    found = confirm(study.bench, study.predicted, ladder.base, ladder.models[-1], study.fits)
    confirmed = ladder.confirmed_by(found, study.bench.evidence)
    lost = study.model.inertials and len(confirmed.steps) < len(ladder.steps)
    return confirmed.ended(study.bench) if lost else confirmed


def _set_aside(ladder: Ladder) -> str:
    """That what was found on a ladder does not explain it either, as a clause; empty where nothing was."""
    return f", nor does what was found so far ({', '.join(ladder.found)})" if ladder.found else ""


def _explained(study: Study, ladder: Ladder) -> bool:
    return ladder.verdict(study.bench.evidence) != "unexplained"


def _settled(study: Study, ladder: Ladder) -> bool:
    """Whether the gap is explained, and the answer in no doubt."""
    sure = ladder.confirmation is None or ladder.confirmation.status == "confirmed"
    return _explained(study, ladder) and (sure or at_floor(ladder.models[-1].held_out, study.bench.evidence))


def _with_windows(study: Study, length: float, tries: int, doubtful: Ladder | None) -> Study | None:
    """The study with longer windows; None where the logs have no room for them.

    Where these only settle a doubt, the time step may move an output by its share of what the doubtful answer leaves
    there, rather than of the noise: a finer one would cost more, and tell no more.
    """
    settings, check = study.settings, study.settings.model_check
    confidence = 1 - (1 - settings.evidence.confidence) / tries
    share = check.least_share if doubtful is None else check.least_share * _left(doubtful)
    try:
        return study.with_settings(
            replace(
                settings,
                windows=settings.windows.of_length(length),
                evidence=replace(settings.evidence, confidence=confidence),
                model_check=replace(check, least_share=share),
            )
        )
    except DataError:
        return None


def _dropped(study: Study, longer: Study) -> float:
    """Share of the logs that have no room for longer windows."""
    before, left = ({*each.bench.fit.logs, *each.bench.held_out.logs} for each in (study, longer))
    return len(before - left) / len(before)


def _left(ladder: Ladder) -> float:
    """What the last model leaves of the channel that it explains best, in noise standard deviations; at least 1."""
    least = min((channel.chi2 for channel in ladder.models[-1].held_out.channels.values()), default=1.0)
    return max(1.0, least) ** 0.5
