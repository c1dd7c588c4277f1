"""Stretches of logs in which a joint is held, left out of what is proposed."""

from collections.abc import Sequence
from dataclasses import replace

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.faults.fault_words import common_stretch
from dr_lab.proposal.split import Split


def without_held(split: Split, faults: Sequence[Fault], logs: Sequence[str]) -> Split:
    """The split whose logs begin behind, and end before, what a hand or a brake does.

    A log of which nothing is left, as where joints move one after the other, stays as it is.

    Args:
        split: how the logs are used.
        faults: of the logs as they are used.
        logs: names of all logs.
    """
    held = [fault for fault in faults if fault.kind == "held"]
    found = {name: common_stretch([fault.rest for fault in held if fault.log == name]) for name in _names(held)}
    rest = {name: stretch for name, stretch in found.items() if stretch}
    if not rest:
        return split
    fit = split.fit or tuple(name for name in logs if name not in (*split.held_out, *split.left_out))
    why = {name: f"{rest[name]} of it is taken. {next(f.message for f in held if f.log == name)}" for name in rest}
    return replace(
        split,
        fit=tuple(rest.get(name, name) for name in fit),
        held_out=tuple(rest.get(name, name) for name in split.held_out),
        shortened=why,
    )


def _names(faults: Sequence[Fault]) -> list[str]:
    return list(dict.fromkeys(fault.log for fault in faults))
