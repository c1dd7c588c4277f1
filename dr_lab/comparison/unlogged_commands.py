"""Commands that changed more often than they were logged: whether they are read as lines between their samples."""

from collections.abc import Sequence
from dataclasses import replace

from dr_lab.comparison.comparison import Comparison, ComparisonSettings
from dr_lab.comparison.fault_notes import UNLOGGED
from dr_lab.diagnosis.evidence.score import score_of
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.windows.unlogged import unknown
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.trajectory import Log, MeasurementSet, Note


def with_lines(comparison: Comparison, faults: Sequence[Fault]) -> Comparison:
    """The comparison whose commands go straight between samples where the motion asks for it, which notes say.

    Asked are commands that a fault calls decimated, unless the measurements say what they do between their samples
    (`Signal.between`). The model is calibrated with them held and with them straight; they are read as straight if that
    leaves less of the logs that score. What they did beside the line is then unknown, and fitted in every window.

    Args:
        comparison: model and logs.
        faults: of the logs.
    """
    model, measured, settings = comparison.model, comparison.measurements, comparison.settings
    suspected = {fault.signal for fault in faults if fault.kind == "decimated"}
    logs = (*measured.fit, *measured.held_out)
    names = [n for n in sorted(suspected) if all(log.commands[n].between == "" for log in logs if n in log.commands)]
    if not names:
        return comparison
    held = _left(model, measured, settings)
    straight = _left(model, _read(measured, names, "line"), settings)
    if not straight < held:
        return comparison
    told = {name: _told(name, measured, held, straight) for name in names}
    found = _read(measured, names, "unknown")
    fit, held_out = (tuple(_noted(log, told) for log in part) for part in (found.fit, found.held_out))
    return replace(comparison, measurements=replace(found, fit=fit, held_out=held_out))


def longest_wait(measured: MeasurementSet, faults: Sequence[Fault]) -> float:
    """Longest usual time in s between two samples of commands that were logged more slowly than they changed; or 0."""
    decimated = {(fault.log, fault.signal) for fault in faults if fault.kind == "decimated"}
    rare = [
        signal
        for log in (*measured.fit, *measured.held_out)
        for name, signal in log.commands.items()
        if unknown(signal) or (log.name, name) in decimated
    ]
    return max((signal.wait for signal in rare), default=0.0)


def _read(measured: MeasurementSet, names: Sequence[str], between: str) -> MeasurementSet:
    """The logs with what some commands do between their samples."""

    def changed(log: Log) -> Log:
        said = {name: replace(s, between=between) for name, s in log.commands.items() if name in names}
        return replace(log, commands={**log.commands, **said})

    return replace(measured, fit=tuple(map(changed, measured.fit)), held_out=tuple(map(changed, measured.held_out)))


def _left(model: Model, measured: MeasurementSet, settings: ComparisonSettings) -> float:
    """χ² that the calibrated model leaves of the logs that score."""
    compiled, threads = model.nominal(), thread_count(settings.threads)
    windows = cut(measured.fit, measured, compiled, settings.windows)
    scored = cut(measured.held_out, measured, compiled, settings.windows) if measured.held_out else windows
    fit = Fitter(Replay(model, windows, threads), settings.solver).run(model.space.nominal)
    return score_of(*fit_states(model, fit.z, scored, settings.solver, threads)).chi2


def _told(name: str, measured: MeasurementSet, held: float, straight: float) -> str:
    wait = max(log.commands[name].wait for log in (*measured.fit, *measured.held_out) if name in log.commands)
    scored = "held-out logs" if measured.held_out else "logs"
    return (
        f"{name}: what was sent between its samples, {1e3 * wait:.3g} ms apart where they are rarest, is not logged. "
        "It is read as going straight from one to the next, which the calibrated model explains better than held "
        f"commands (χ² {straight:.3g} instead of {held:.3g} on the {scored}), and what that misses is estimated in "
        f"every window. A shift in time below {1e3 * wait:.3g} ms is not told from none. "
        f"+measurements.commands.{name}.between=hold reads it as held."
    )


def _noted(log: Log, told: dict[str, str]) -> Log:
    notes = [Note(UNLOGGED, name, message) for name, message in told.items() if name in log.commands]
    return replace(log, notes=(*log.notes, *notes))
