"""Outputs that never change while the machine is driven: a dead sensor, or another topic or column."""

from collections.abc import Mapping

import numpy as np

from dr_lab.trajectory import Array, Note, Signal


def find_constant(outputs: Mapping[str, Signal], commands: Mapping[str, Signal]) -> tuple[Note, ...]:
    """Report outputs whose samples are all equal in a log during which a command changes."""
    notes = []
    for name, signal in outputs.items():
        driven = [sent for sent, command in commands.items() if np.ptp(_during(command, signal)) > 0.0]
        if driven and not np.ptp(signal.value, axis=0).any():
            message = (
                f"{name}: never changes ({len(signal)} equal samples) while {', '.join(driven)} "
                f"{'is' if len(driven) == 1 else 'are'} driven. Check its sensor and its topic or column, or leave the "
                "log out."
            )
            notes.append(Note("constant", name, message, len(signal)))
    return tuple(notes)


def _during(command: Signal, output: Signal) -> Array:
    """Values that a command, which holds until its next sample, has from an output's first sample to its last."""
    first, last = np.searchsorted(command.time, output.time[[0, -1]], side="right")
    return command.value[max(int(first) - 1, 0) : max(int(last), 1)]
