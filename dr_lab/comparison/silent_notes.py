"""Notes on what the model has and the measurements do not name."""

from collections.abc import Sequence

import mujoco

from dr_lab.diagnosis.windows.commands import silent_actuators
from dr_lab.diagnosis.windows.start import untold_joints
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import MeasurementSet

NO_COMMAND, NO_OUTPUT = "no_command", "no_output"


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


def silent_markdown(notes: Sequence[NoteEntry]) -> str:
    """Those of some notes, a line each; empty where there is none."""
    return "\n".join(f"- {note.message}" for note in notes if note.kind in (NO_COMMAND, NO_OUTPUT))
