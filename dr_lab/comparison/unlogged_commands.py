"""Commands that changed more often than they were logged: whether they are read as lines between their samples."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce

from dr_lab.comparison.comparison import Comparison, ComparisonSettings
from dr_lab.comparison.fault_notes import BETWEEN, UNDECIDED
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.evidence.support import sizeable, supported
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.unlogged import unknown
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.effects.catalogue import candidates
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.reports.faults import UNLOGGED
from dr_lab.trajectory import Log, MeasurementSet, Note


def with_lines(comparison: Comparison, faults: Sequence[Fault], straight: Sequence[str]) -> Comparison:
    """The comparison whose commands go straight between samples where the motion asks for it, which notes say.

    Asked are commands that a fault calls decimated, or that may have followed lines for what the equation of motion
    tells, unless the measurements say what they do between their samples (`Signal.between`). The model is calibrated
    with them held and with them straight, both times with what models lack most often (`ComparisonSettings.usual`):
    without it, half a sample of delay may make up for a rotor's inertia or for friction. There are three answers:

    1. Held ones leave more of the logs that score, beyond doubt or, where a fault says so too, beyond the threshold:
       what commands did beside the line scatters what it gains. Then they are read as straight; what coarse ones
       (`FaultSettings.is_coarse`) did beside the line is unknown, and fitted in every window.
    2. Straight ones leave more beyond doubt. Then they held.
    3. Neither. They are read as held, but no shift in time by less than a sample is told (`longest_wait`).

    Args:
        comparison: model and logs.
        faults: of the logs.
        straight: actuators whose commands the motion may have followed as lines.
    """
    model, measured, settings = comparison.model, comparison.measurements, comparison.settings
    logs = (*measured.fit, *measured.held_out)
    faulty = {fault.signal for fault in faults if fault.kind == "decimated"}
    suspected = sorted(faulty.union(straight))
    names = [n for n in suspected if all(log.commands[n].between == "" for log in logs if n in log.commands)]
    if not names:
        return comparison
    fuller = _with_usual(model, measured, settings)
    held, line = (_left(fuller, _read(measured, dict.fromkeys(names, way)), settings) for way in ("hold", "line"))
    if _better(held, line, settings.evidence):
        return comparison
    seen = not faulty.isdisjoint(names) and _likelier(line, held, settings.evidence)
    if not (seen or _better(line, held, settings.evidence)):
        return _noted(comparison, UNDECIDED, {name: _undecided(name, measured, held, line) for name in names})
    sent = [(name, log.commands[name]) for log in logs for name in names if name in log.commands]
    coarse = {name for name, signal in sent if settings.faults.is_coarse(signal.wait)}
    told = {name: _told(name, measured, held, line, name in coarse) for name in names}
    found = _read(measured, {name: "unknown" if name in coarse else "line" for name in names})
    return _noted(replace(comparison, measurements=found), UNLOGGED, told)


def longest_wait(measured: MeasurementSet, faults: Sequence[Fault]) -> float:
    """Longest usual time in s between two samples of commands that may have changed between them; 0 where none did."""
    decimated = {(fault.log, fault.signal) for fault in faults if fault.kind == "decimated"}
    rare = [
        signal
        for log in (*measured.fit, *measured.held_out)
        for name, signal in log.commands.items()
        if unknown(signal) or (log.name, name) in decimated or _is_noted(log, name)
    ]
    return max((signal.wait for signal in rare), default=0.0)


def _with_usual(model: Model, measured: MeasurementSet, settings: ComparisonSettings) -> Model:
    """The model with what models lack most often, wherever it can be."""
    compiled = model.nominal()
    scales = machine_scales(compiled, measured.fit, settings.windows.smoother)
    return reduce(Model.with_effect, candidates(model, settings.usual, scales, compiled).placed, model)


def _read(measured: MeasurementSet, between: Mapping[str, str]) -> MeasurementSet:
    """The logs with what some commands do between their samples."""

    def changed(log: Log) -> Log:
        said = {name: replace(s, between=between[name]) for name, s in log.commands.items() if name in between}
        return replace(log, commands={**log.commands, **said})

    return replace(measured, fit=tuple(map(changed, measured.fit)), held_out=tuple(map(changed, measured.held_out)))


def _left(model: Model, measured: MeasurementSet, settings: ComparisonSettings) -> Score:
    """What the calibrated model leaves of the logs that score."""
    compiled, threads = model.nominal(), thread_count(settings.threads)
    lengths = settings.windows.of_machine(compiled.nv)
    windows = cut(measured.fit, measured, compiled, lengths)
    scored = cut(measured.held_out, measured, compiled, lengths) if measured.held_out else windows
    fit = Fitter(Replay(model, windows, threads), settings.solver).run(model.space.nominal)
    return score_of(*fit_states(model, fit.z, scored, settings.solver, threads))


def _better(one: Score, other: Score, evidence: EvidenceSettings) -> bool:
    """Whether one leaves less than another beyond doubt."""
    return supported(paired_gain(other, one, evidence), 0, evidence)


def _likelier(one: Score, other: Score, evidence: EvidenceSettings) -> bool:
    """Whether one leaves less than another by the evidence that counts, however it scatters."""
    return sizeable(paired_gain(other, one, evidence), 0, evidence)


def _told(name: str, measured: MeasurementSet, held: Score, line: Score, coarse: bool) -> str:
    wait, scored = _wait_and_scored(name, measured)
    beside = ", and what that misses is estimated in every window" if coarse else ""
    return (
        f"{name}: what was sent between its samples, {wait} apart where they are rarest, is not logged. "
        "It is read as going straight from one to the next, which the calibrated model with rotor inertia and dry "
        f"friction explains better than held commands (χ² {line.chi2:.3g} instead of {held.chi2:.3g} on the "
        f"{scored}){beside}. A shift in time below {wait} is not told from none. "
        f"+measurements.commands.{name}.between=hold reads it as held."
    )


def _undecided(name: str, measured: MeasurementSet, held: Score, line: Score) -> str:
    wait, scored = _wait_and_scored(name, measured)
    return (
        f"{name}: whether it held between its samples, {wait} apart where they are rarest, or went on, the {scored} do "
        "not tell: held, the calibrated model with rotor inertia and dry friction leaves χ² "
        f"{held.chi2:.3g}, and {line.chi2:.3g} with straight lines. It is read as held. A shift in time below {wait} "
        f"is not told from none, unless +measurements.commands.{name}.between=hold, or line, says what it did."
    )


def _wait_and_scored(name: str, measured: MeasurementSet) -> tuple[str, str]:
    """The longest usual time between two samples of a command, and what the logs that score are called."""
    wait = max(log.commands[name].wait for log in (*measured.fit, *measured.held_out) if name in log.commands)
    return f"{1e3 * wait:.3g} ms", "held-out logs" if measured.held_out else "logs"


def _noted(comparison: Comparison, kind: str, told: Mapping[str, str]) -> Comparison:
    """The comparison with notes on some commands in every log that has them."""

    def noted(log: Log) -> Log:
        notes = [Note(kind, name, message) for name, message in told.items() if name in log.commands]
        return replace(log, notes=(*log.notes, *notes))

    measured = comparison.measurements
    fit, held_out = (tuple(map(noted, part)) for part in (measured.fit, measured.held_out))
    return replace(comparison, measurements=replace(measured, fit=fit, held_out=held_out))


def _is_noted(log: Log, name: str) -> bool:
    """Whether it was found that a command of a log changed between its samples, or may have."""
    return any(note.kind in BETWEEN and note.signal == name for note in log.notes)
