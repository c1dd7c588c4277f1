"""Notes on what logs cannot tell: what the model has and they do not name, and what they are too short for."""

from collections.abc import Sequence

import mujoco

from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.windows.commands import silent_actuators
from dr_lab.diagnosis.windows.start import untold_joints
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.quantity import shortened
from dr_lab.trajectory import Log, MeasurementSet

NO_COMMAND, NO_OUTPUT, UNCHECKED = "no_command", "no_output", "unchecked"


def silent_notes(compiled: mujoco.MjModel, measured: MeasurementSet) -> list[NoteEntry]:
    """Notes on actuators without a command, and on joints of which nothing is measured."""
    logs = (*measured.fit, *measured.held_out)
    sent, shown = (", ".join(signals) or "none" for signals in (logs[0].commands, logs[0].outputs))
    notes = []
    if actuators := silent_actuators(compiled, logs):
        message = (
            f"No command is measured for {', '.join(actuators)}: simulated with the control 0. Measured commands: "
            f"{sent}. If it was driven, name its channel in measurements.commands."
        )
        notes.append(NoteEntry(message, NO_COMMAND))
    if joints := untold_joints(compiled, tuple(logs[0].outputs)):
        message = (
            f"No position or velocity is measured of joint {', '.join(joints)}: what it does is guessed from the other "
            f"channels. Measured: {shown}. If a log holds it, name its channel in measurements.outputs."
        )
        notes.append(NoteEntry(message, NO_OUTPUT))
    return notes


def unchecked_notes(measured: MeasurementSet, settings: FaultSettings) -> list[NoteEntry]:
    """Note on logs that are too short to tell whether their commands are right."""
    least = settings.least_span
    short = [log.name for log in (*measured.fit, *measured.held_out) if log.commands and _span(log) < least]
    if not short:
        return []
    message = (
        f"Too short to check whether commands have the right sign, unit and clock (less than {least:.2g} s): "
        f"{shortened(short)}. What is wrong there would pass for physics."
    )
    return [NoteEntry(message, UNCHECKED, count=len(short))]


def _span(log: Log) -> float:
    """The time in s that all outputs of a log share."""
    outputs = log.outputs.values()
    return min(each.time[-1] for each in outputs) - max(each.time[0] for each in outputs)


def silent_markdown(notes: Sequence[NoteEntry]) -> str:
    """Those of some notes, a line each; empty where there is none."""
    return "\n".join(f"- {note.message}" for note in notes if note.kind in (NO_COMMAND, NO_OUTPUT, UNCHECKED))
