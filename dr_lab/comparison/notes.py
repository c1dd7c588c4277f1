"""Notes of a report: what its reader must know of data, fits and candidates."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.comparison.fault_notes import fault_notes
from dr_lab.comparison.misread_notes import misread_notes
from dr_lab.comparison.silent_notes import silent_notes, unchecked_notes
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.checks.open_chains import open_chain
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import block_count
from dr_lab.diagnosis.fit.covariance import per_log, per_log_std
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.periods import searched
from dr_lab.diagnosis.search.put_back import PutBack
from dr_lab.diagnosis.search.wider import ran_into
from dr_lab.effects.effect import PlacedEffect
from dr_lab.effects.periodic import PERIODS
from dr_lab.reports.faults import FAULT
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.quantity import in_unit, number, shortened
from dr_lab.trajectory import MeasurementSet, Note

DISAGREEING = "disagreeing_logs"


def study_notes(study: Study) -> list[NoteEntry]:
    """Notes on the data and the model, before anything is fitted."""
    return [
        *fault_notes(study.faults, study.measurements),
        *misread_notes(study),
        *_step_note(study),
        *_chain_note(study),
        *silent_notes(study.compiled, study.measurements),
        *unchecked_notes(study.measurements, study.settings.faults),
        *_split_note(study.measurements),
        *_short_note(study),
        *_data_notes(study.measurements),
    ]


def fit_notes(models: Sequence[FittedModel]) -> list[NoteEntry]:
    """Notes on fits of a ladder's models that lack windows or did not converge, and on declared bounds that bind."""
    notes = _declared_ends(models[-1])
    for model in models:
        effects, fit = model.model.effects, model.fit
        lost = int(fit.infeasible.sum())
        name = f"The fit with {effects[-1].label}" if effects else "The calibration"
        if lost:
            told = f"{name} lacks {lost} of {len(fit.infeasible)} windows, whose simulation diverges."
            notes.append(NoteEntry(f"{told} Its parameters hold for the others alone.", "infeasible_windows"))
        if fit.iterations and not fit.converged:  # a learned force is a regression, which takes no step
            steps = f"{fit.iterations} step{'s' if fit.iterations != 1 else ''}"
            told = f"{name} did not converge in {steps}: its parameters may not be the best."
            rest = "Raise solver.iterations, or begin nearer."
            if fit.over:
                told = f"{name} ended after {steps} without a certificate that it converged."
                rest = "Its last steps gained nothing, as where a joint sticks or a limit is met: more would not help."
            notes.append(NoteEntry(f"{told} {rest}", "not_converged"))
    return notes


def _declared_ends(last: FittedModel) -> list[NoteEntry]:
    """Notes on parameters that ran into a bound that was declared; a bound at 0 is physics and cannot be widened."""
    free = {p.name for body in last.model.inertials for p in body.parameters}
    values, notes = last.values(), []
    for parameter in last.model.declared:
        low, high = ran_into(parameter, values[parameter.name])
        bound = parameter.low if low else parameter.high
        if parameter.name in free or not (low or high) or bound == 0:
            continue
        message = (
            f"{parameter.name} ends at its {'lower' if low else 'upper'} bound, "
            f"{in_unit(bound, parameter.unit)}, as the model's configuration has it: the logs ask for "
            f"{'less' if low else 'more'}. Widen the bound if that is possible; else something that "
            "the model lacks acts like it."
        )
        notes.append(NoteEntry(message, "declared_bound"))
    return notes


def few_blocks(bench: Bench) -> list[NoteEntry]:
    """Note that the windows are too few for an interval of any difference between models."""
    apart = [bench.fit.log + bench.held_out.log.max(initial=0) + 1] if bench.apart else []
    count = block_count(np.concatenate([bench.held_out.log, *apart]), bench.evidence)
    least = bench.evidence.least_compared
    if count >= least:
        return []
    message = (
        f"The windows make {count} block{'s' if count > 1 else ''} of data; from {least} on "
        "(evidence.least_compared) the scatter of gains is known. Here an effect counts that lowers the error in every "
        f"window and closes {100 * bench.evidence.least_named:g} % of the gap (evidence.least_named): do not trust it "
        "far. Record more, hold out more logs or cut shorter windows (windows.length)."
    )
    return [NoteEntry(message, "few_blocks", count=count)]


def disagreeing_logs(bench: Bench, last: FittedModel) -> list[NoteEntry]:
    """Notes on parameters of which two logs ask for values that differ beyond their noise and by `growth`.

    Their noise is what the model leaves. Nothing is told of a model that leaves noise alone, of bodies that are free as
    a whole, whose numbers trade, of values at a bound, and of what may have either sign, whose zero is arbitrary.
    """
    space, told = last.model.space, []
    if last.model.inertials or at_floor(last.held_out, bench.evidence):
        return []
    values, std = (found(space, last.fit, bench.fit) for found in (per_log, per_log_std))
    left = last.held_out.colour * last.fit.cost / bench.samples
    for k, parameter in enumerate(space.parameters):
        least, most = int(values[:, k].argmin()), int(values[:, k].argmax())
        low, high = float(values[least, k]), float(values[most, k])
        noise = left * (std[least, k] ** 2 + std[most, k] ** 2)
        inside = parameter.low >= 0 and not any(any(parameter.touches(value)) for value in (low, high))
        if inside and high > bench.evidence.growth * low and (high - low) ** 2 > bench.evidence.threshold * noise:
            asked = [
                f"{bench.fit.logs[row]} asks for {in_unit(value, parameter.unit)}"
                for row, value in ((least, low), (most, high))
            ]
            message = (
                f"The logs do not agree on {parameter.name}: {' and '.join(asked)}. Was it one machine, set up alike? "
                "If so, what is missing acts more in one of them."
            )
            told.append(NoteEntry(message, DISAGREEING))
    return told


def shared_loads(bench: Bench, last: FittedModel) -> list[NoteEntry]:
    """Notes on loads that no log tells from the links that carry them."""
    model = last.model
    if not model.inertials or not bench.fit.loaded.all():
        return []
    told = (
        "acts in all logs, and the inertia of its link is free: the motion shows their sum alone, which only the weak "
        "prior of the links shares out. Record some logs without the load, and name the others in measurements.loaded: "
        "then it is told by what differs."
    )
    free = {body.body for body in model.inertials}
    loads = [effect for effect in model.effects if effect.attached and effect.site in free]
    return [NoteEntry(f"{effect.label} {told}", "shared_load") for effect in loads]


def refused(reasons: Mapping[str, str]) -> list[NoteEntry]:
    """Notes on effects that were not tried, one for each reason.

    Args:
        reasons: why, by ``effect@site``.
    """
    return [
        NoteEntry(f"Not tried: {', '.join(k for k in reasons if reasons[k] == why)}. {why}", "not_tried")
        for why in dict.fromkeys(reasons.values())
    ]


def searched_periods(ladder: Ladder) -> list[NoteEntry]:
    """Notes on numbers of periods that were searched, of the effects that were fitted anywhere on a ladder."""
    found = {c.effect.label: c for rung in reversed(ladder.rungs) for c in rung.ranking if c.fitted}
    return [
        NoteEntry(_periods(c), "searched_periods", effect=label) for label, c in found.items() if searched(c.effect)
    ]


def _periods(candidate: Candidate) -> str:
    effect, values = candidate.effect, candidate.fitted_model.values()
    name = f"{effect.label}.{PERIODS}"
    periods = next(p for p in effect.parameters if p.name == name)
    proposed = " and ".join(f"{start[name]:.4g}" for start in effect.starts if name in start)
    return (
        f"{effect.label}: of {periods.low:.3g} to {periods.high:.3g} periods ({periods.unit}) the spectrum of the "
        f"residuals over the position proposed {proposed or 'none'}; the fit ended at {values[name]:.4g}. "
        f"To give the number instead: effects.{effect.effect.name}.{PERIODS}=…"
    )


def moved_bounds(ladder: Ladder) -> list[NoteEntry]:
    """Notes on bounds that fits ran into: those that were moved, and at which bounds the added effects end."""
    found = {c.effect.label: c for rung in reversed(ladder.rungs) for c in rung.ranking if c.fitted}
    last = ladder.models[-1].values()
    moved = [NoteEntry(told, "moved_bound", effect=label) for label, c in found.items() for told in _moved(c, last)]
    ends = [NoteEntry(told, "at_bound") for step in ladder.steps for told in _ends_at_bounds(step.effect, last)]
    return [*moved, *ends]


def _moved(candidate: Candidate, last: Mapping[str, float]) -> list[str]:
    """What became of a candidate's bounds, with its values in the last model where that has it."""
    now, values = {p.name: p for p in candidate.effect.parameters}, {**candidate.fitted_model.values(), **last}
    return [
        f"{name} ran into its bounds ({number(low)} to {in_unit(high, now[name].unit)}), which are no physics. "
        f"They were moved to {number(now[name].low)} and {in_unit(now[name].high, now[name].unit)}; the fit "
        f"ended at {in_unit(values[name], now[name].unit)}."
        for name, low, high in candidate.effect.looked
    ]


def _ends_at_bounds(effect: PlacedEffect, values: Mapping[str, float]) -> list[str]:
    return [
        f"{p.name} ends at its bound, {in_unit(values[p.name], p.unit)}: physics, the length of the windows "
        "(windows.kept, windows.margin) or evidence.widenings allows no more. What it stands for may be larger, or "
        "something else."
        for p in effect.parameters
        if any(ran_into(p, values[p.name]))
    ]


def dropped(labels: Sequence[str]) -> list[NoteEntry]:
    """Notes on effects that were added and not kept."""
    told = (
        "was added, and dropped again: beside the effects that stay, the logs do not ask for it beyond doubt, it makes "
        "up for the time step's error, or the model predicts no better with it."
    )
    return [NoteEntry(f"{label} {told}", "dropped") for label in labels]


def put_back(found: Sequence[PutBack]) -> list[NoteEntry]:
    """Notes on effects in whose place a special case of them stands."""
    return [NoteEntry(_put_back(one), "put_back") for one in found]


def _put_back(one: PutBack) -> str:
    values = ", ".join(f"{name} {value:.2g} ± {std:.2g}" for name, (value, std) in one.further.items())
    held = "are compatible with nothing" if one.compatible else "explain no more of the logs that score, beyond doubt"
    held = "close a small part of the little that it leaves beyond the noise" if one.little else held
    held = "change little beside what the time step does; a finer one in the MJCF would tell" if one.hidden else held
    held = "ended next to zero, where it is that" if one.at_limit else held
    return f"{one.richer} was put back to {one.poorer}: its further parameters {held} ({values})."


def _step_note(study: Study) -> list[NoteEntry]:
    message = study.refinement.message
    return [NoteEntry(message, "time_step", signal=study.floor.worst)] if message else []


def _chain_note(study: Study) -> list[NoteEntry]:
    measured, check = study.measurements, study.comparison.settings.model_check
    found = open_chain(study.compiled, (*measured.fit, *measured.held_out), measured.noise, check)
    return [] if found is None else [NoteEntry(found.message, "open_chain")]


def _split_note(measured: MeasurementSet) -> list[NoteEntry]:
    if measured.held_out:
        return []
    message = "No log is held out: all scores are on the fit logs, which flatter what is fitted to them."
    return [NoteEntry(message, "no_held_out")]


def _short_note(study: Study) -> list[NoteEntry]:
    """Note on logs in which no window has room, which neither fit nor score."""
    measured, settings = study.measurements, study.settings.windows
    used = {*study.bench.fit.logs, *study.bench.held_out.logs}
    short = [log.name for log in (*measured.fit, *measured.held_out) if log.name not in used]
    if not short:
        return []
    named = shortened(short)
    message = (
        f"{named} took no part: a window of {settings.length + settings.run_in + 2 * settings.margin:.3g} s without a "
        f"gap, behind {settings.past:g} s of commands, has no room there. Shorten windows.length, or give longer logs."
    )
    return [NoteEntry(message, "no_window", count=len(short))]


def _data_notes(measured: MeasurementSet) -> list[NoteEntry]:
    """What the data contract found, log by log; what it says of every log in the same words, once."""
    logs = (*measured.fit, *measured.held_out)
    every = [(log, note) for log in logs for note in log.notes if note.kind != FAULT]
    times = Counter(note for _, note in every)
    common = [note for note in times if len(logs) > 1 and all(note in log.notes for log in logs)]
    return [
        *(NoteEntry(_of_each(note), note.kind, signal=note.signal, count=note.count * times[note]) for note in common),
        *(
            NoteEntry(note.message, note.kind, log.name, note.signal, count=note.count)
            for log, note in every
            if note not in common
        ),
    ]


def _of_each(note: Note) -> str:
    """A note's message; where it counts samples, that these are those of one log."""
    return f"{note.message} The same in each of the logs." if note.count else note.message
