"""The verdict of a report in two sentences."""

import math
from collections.abc import Sequence

from dr_lab.reports.calibration import calibration_told
from dr_lab.reports.faults import faults_told
from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import IN_DOUBT, MEASURABLE, SHORT_SHIFT, TOGETHER
from dr_lab.reports.ladder import scored, status, steps
from dr_lab.reports.quantity import number, percent

_NONE = "**No missing effect:** the logs support no effect beyond the plain model."
_SHORT = 4  # models that a sentence lists: as given, calibrated, and with two effects
_KNOWN = 1.1  # times; χ² of noise whose standard deviation is known within 5 %
_TOO_LOW = 0.5  # χ² that noise leaves whose standard deviation was taken for 1.4 times as large
_LITTLE = 2.0  # χ² of a gap that is as large as the noise
_TENFOLD = 9.0  # times itself that an error grows by when it grows tenfold


def verdict_markdown(report: GapReport) -> str:
    """What was found, how far the error fell, what remains; first that logs are faulty or the model worse, if so."""
    worse = _worse(report)
    calibrated = not report.verdict and not report.added
    found = (_found(report), *_notes(report, IN_DOUBT), *_notes(report, TOGETHER), *_notes(report, MEASURABLE))
    answer = (worse, *found, _share(report), _fall(report), _confirmed(report))
    told = (faults_told(report.notes), *([worse] if worse and calibrated else answer))
    left = (_remaining(report), *_notes(report, SHORT_SHIFT), _learned(report))
    return " ".join(part for part in (*told, *left) if part)


def _notes(report: GapReport, kind: str) -> list[str]:
    return [note.message for note in report.notes if note.kind == kind]


def _change(removed: float) -> str:
    """What becomes of an error of which such a share is removed."""
    if removed < -_TENFOLD:
        return "grows more than tenfold"
    return f"falls by {percent(removed)}" if removed >= 0.0 else f"grows by {percent(-removed)}"


def _learned(report: GapReport) -> str:
    """That a force was learned, which is a way to simulate what is missing, and no name for it; or in vain."""
    told = []
    for row in report.judged.learned:
        what = f"a force at `{row.joint}` as a function of {' and '.join(row.depends_on)}"
        ratios = [(b or 0.0) / a for a, b in row.predicted.values() if a]
        logs = f" (the squared predicted error of the {scored(report)} {_change(row.removes or 0.0)}"
        logs += f"; of the log that gains least it {_change(1 - max(ratios) ** 2)}" if len(ratios) > 1 else ""
        if row.accepted:
            told.append(f"**Learned, not named:** `{row.effect}`, {what}, simulates a part of that{logs}).")
        elif not report.logs.held_out:
            told.append(
                f"**Learned, not judged:** `{row.effect}`, {what}: no log is held out that could judge it{logs})."
            )
        else:
            kept = row.effect in steps(report)[-1].effects
            done = f"`{row.effect}`, {what}, is in the model as you asked, but" if kept else f"{what} was tried, and"
            before, after = (each or 0.0 for each in row.chi2)
            why = "does not predict what it was not learned from"
            if after > before and (row.removes or 0.0) > 0.0:
                why = f"leaves more of the {scored(report)} than no force does, χ² {number(before)} → {number(after)}"
            told.append(f"**Learned in vain:** {done} {why}{logs}).")
    return " ".join(told)


def _worse(report: GapReport) -> str:
    """That the last model without a learned force predicts worse than the one given.

    By more χ² than the noise is known to, in as many windows. What a learned force does is told beside it.
    """
    first, last = steps(report)[0].held_out, report.catalogued[-1].held_out
    chi2 = [math.inf if held_out.chi2 is None else held_out.chi2 for held_out in (first, last)]
    shown = [number(value) for value in chi2]
    at_floor = report.remaining.status == "at_floor"
    fewer = last.infeasible_windows < first.infeasible_windows
    if chi2[1] <= _KNOWN * chi2[0] or at_floor or fewer:
        return ""
    name = f"The model with {_listed(report.added)}" if report.added else "The calibrated model"
    return (
        f"**{name} predicts the {scored(report)} worse than the model as given: χ² {' → '.join(shown)}. "
        "Do not use it.**"
    )


def _found(report: GapReport) -> str:
    asked = report.verb == "add" and report.added
    sentences = {
        "named": _asked(report.added) if asked else _named(report.added or _with_status(report, "named")),
        "equivalent": _equivalent(report),
        "not_excited": "**Not excited:** the logs do not move the effects' parameters beyond the noise.",
        "unexplained": _unexplained(report),
        "none": " ".join(part for part in (_NONE, calibration_told(report)) if part),
    }
    done = "**Calibrated on the logs.**" if len(steps(report)) > 1 else "**Measured against the model.**"
    return sentences.get(report.verdict or "", f"**Added:** {_listed(report.added)}." if report.added else done)


def _named(effects: Sequence[str]) -> str:
    return f"**The missing {'effects are' if len(effects) > 1 else 'effect is'} named:** {_by_effect(effects)}."


def _asked(effects: Sequence[str]) -> str:
    """Of effects that the user named: that they were added, not that they were found."""
    it, other = ("them", "others were") if len(effects) > 1 else ("it", "other effect was")
    return f"**Added as asked:** {_listed(effects)}. The logs support {it}; no {other} tried."


def _unexplained(report: GapReport) -> str:
    """That nothing explains the gap, and how much of it closes all the same, or by which law that is not meant."""
    added = report.added
    if not added:
        beyond = " beyond doubt" if _notes(report, IN_DOUBT) else ""
        chi2 = report.catalogued[-1].held_out.chi2
        if chi2 is not None and chi2 < _LITTLE:
            return f"**Unexplained, though little:** a gap below the noise remains, and no effect explains it{beyond}."
        return f"**Unexplained:** a gap remains that no effect of the catalogue explains{beyond}."
    told = [law.told for law in report.judged.laws if law.refuted]
    if told:
        return f"**Unexplained:** {' '.join(told)}"
    if _notes(report, IN_DOUBT):
        return "**Unexplained:** what was added is not beyond doubt."
    one, share = len(added) == 1, report.judged.gap_closed
    closes = f"{'closes' if one else 'together close'} {percent(share)} of a typical window's gap"
    if share is not None and share <= 0:
        closes = f"{'closes' if one else 'close'} nothing of a typical window's gap"
    return f"**Unexplained:** {_listed(added)} {closes}, too little to be the cause."


def _equivalent(report: GapReport) -> str:
    """Which effects stand alone, and which ones the logs cannot tell apart; what was found first comes first."""
    added = [(rung.effects[-1], rung.rivals or ()) for rung in report.catalogued[1:]]
    alone = [effect for effect, rivals in added if not rivals]
    groups = [_listed([effect, *rivals]) for effect, rivals in added if rivals]
    told = "; ".join(groups) or _listed(_with_status(report, "equivalent")) or "the best candidates"
    equivalent = f"**Equivalent effects:** these logs cannot tell apart {told}."
    if not alone:
        return equivalent
    groups_first = bool(added[0][1])
    return f"{equivalent} **Named beside them:** {_listed(alone)}." if groups_first else f"{_named(alone)} {equivalent}"


def _fall(report: GapReport) -> str:
    """χ² of each model on the scored logs, and of the named candidate where it was not added yet."""
    errors = [f"{number(step.held_out.chi2)} ({step.name})" for step in steps(report)]
    if not report.added:
        named = [row for row in report.judged.ranking if status(row, report.verdict) == "named"]
        errors += [f"{number(row.held_out_chi2)} (+ {row.label})" for row in named]
    # Longer ladders have their own table; the sentence keeps the ends and the calibrated model, which effects improve.
    told = errors if len(errors) <= _SHORT else [*errors[:2], "…", errors[-1]]
    return f"χ² on {scored(report)}: {' → '.join(told)}; 1 is the noise floor."


def _confirmed(report: GapReport) -> str:
    """What the windows say that chose nothing."""
    found = report.judged.confirmation
    if found is None:
        return ""
    if found.predicted_worse:
        return "**The calibrated model predicts the logs better: what was added bends the fitted starts alone.**"
    if found.gain is None:
        told = "No window was left that chose nothing and could confirm what was added."
        return "" if report.verdict == "unexplained" else told
    one, gap = found.windows == 1, found.gain.gap_closed or 0.0
    where, few = f"{found.windows} window{'s' * (not one)} that chose nothing", "too few to be sure"
    closed = f"{percent(gap)} of a typical window's gap closes there"
    if gap < 0:
        closed = f"a typical window's gap is {number(1.0 - gap, 3)} times as wide there"
    share = report.judged.explained.share
    shows = share is not None and gap >= share / 2
    only = "only " if gap >= 0 else ""
    told = {
        "confirmed": f"On {where} the same is found: {closed}.",
        "undecided": f"On {where}, {few}, {'the same shows: ' if shows else only}{closed}.",
        "contradicted": f"**{where} contradict{'s' * one} that: χ² goes from {number(found.gain.chi2_before)} to "
        f"{number(found.gain.chi2_after)} there. Do not trust what was added.**",
    }
    return told[found.status]


def _remaining(report: GapReport) -> str:
    remaining = report.remaining
    times = f"{number(remaining.chi2**0.5, 2)} times" if remaining.chi2 is not None else "far above"
    if remaining.status == "at_floor" and remaining.coloured:
        return f"What remains, {times} the sensors' white noise, is too rough and too even for a force: coloured noise."
    if remaining.status == "at_floor" and remaining.chi2 is not None and remaining.chi2 < _TOO_LOW:
        times = number(remaining.chi2**0.5, 2)
        return (
            f"What remains is {times} times the noise that was estimated: **the noise is less, and what is smaller "
            "than it was taken to be is not seen.** Give `noise_std` in `measurements.outputs`, or record faster."
        )
    if remaining.status == "at_floor":
        return "What remains is noise."
    told = f"What remains (χ² {number(remaining.chi2)}) is above the noise floor"
    lost = report.catalogued[-1].held_out.infeasible_windows
    if lost:
        told = f"The simulation diverges in {lost} of the windows that score. {told}"
    more = _unasked(report)
    if more:
        return f"{told}: {times} the sensors' noise. {more}"
    told = f"{told} and not explained"
    if not report.judged.ranking:
        return f"{told}."
    told = f"{told} beyond doubt" if _notes(report, IN_DOUBT) else told
    but = "but a shift in time" if _notes(report, SHORT_SHIFT) else "in the catalogue"
    return f"{told} by anything {but}: {times} the sensors' noise."


def _unasked(report: GapReport) -> str:
    """Why the catalogue may explain more of what remains; empty where all of it was tried beside the last model."""
    if not report.added:
        return ""
    if report.verb in ("diagnose", "add"):
        return "No other effect was tried beside what was added: `dr-lab close` does that."
    beside = [rung.chosen for rung in report.judged.rungs[-1:] if {*rung.effects} == {*report.catalogued[-1].effects}]
    if not any(beside):
        return ""
    one = "" if len(beside[0]) == 1 else "One of "
    return f"{one}{_listed(beside[0])} explains more of it, but `most` left no room: raise it."


def _share(report: GapReport) -> str:
    """How much of what the calibrated model misses the added effects explain, and the prediction that gains most."""
    explained = report.judged.explained
    little = report.verdict == "unexplained" and not any(law.refuted for law in report.judged.laws)
    if not report.added or little or explained.share is None or explained.share <= 0:
        return ""
    low, high = explained.low, explained.high
    interval = f" ({percent(low)} … {percent(high)})" if low is not None and high is not None else ""
    alone = "The first explains" if report.catalogued[-1].rivals else "It explains"
    subject = "Together they explain" if len(report.added) > 1 else alone
    told = f"{subject} {percent(explained.share)}{interval} of what the calibrated model misses{_few_windows(report)}."
    return f"{told}{_predicted(report)}"


def _few_windows(report: GapReport) -> str:
    """That the share is that of a typical window, where all squares together fall by less than its interval says."""
    low, (first, last) = report.judged.explained.low, (report.ladder[0].held_out, report.catalogued[-1].held_out)
    if low is None or first.chi2 is None or last.chi2 is None or first.chi2 <= 1.0:
        return ""
    falls = min((first.chi2 - last.chi2) / (first.chi2 - 1.0), 1.0)
    if falls >= low:
        return ""
    together = f"fall by {percent(falls)}" if falls > 0.0 else "do not fall"
    return f" in a typical window; the squares of all windows together, most of them in few, {together}"


def _predicted(report: GapReport) -> str:
    """The error of the predicted channel that the added effects gain most for, without and with them."""
    first, last = report.ladder[0], report.catalogued[-1]
    before, after = (rung.held_out.rmse_predicted for rung in (first, last))
    gains = {name: error / left for name, error in before.items() if error and (left := after.get(name))}
    if not gains:
        return ""
    name = max(gains, key=lambda each: gains[each])
    unit = report.noise[name].unit if name in report.noise else ""
    them = "them" if len(report.added) > 1 else "it"
    unit = "" if unit in ("", "1") else f" {unit}"
    errors = f"{number(before[name], 3)}{unit} RMS without {them} and {number(after[name], 3)} with {them}"
    return f" `{name}` is predicted within {errors}."


def _with_status(report: GapReport, status: str) -> list[str]:
    return [row.label for row in report.judged.ranking if row.status == status]


def _by_effect(labels: Sequence[str]) -> str:
    """Labels as they are, but one effect at more than two sites once, with its sites."""
    sites = dict[str, list[str]]()
    for label in labels:
        name, _, site = label.partition("@")
        sites.setdefault(name, []).append(site)
    return ", ".join(
        f"`{name}` at {_listed(found[:-1])} and `{found[-1]}`"
        if len(found) > 2
        else _listed([f"{name}@{s}" for s in found])
        for name, found in sites.items()
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)
