"""A proposal read back as the other verbs will read it: which logs can be used, and what they tell of the model."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import yaml

from dr_lab.comparison.comparison import ComparisonSettings
from dr_lab.diagnosis.checks.firm_loops import firm_loops
from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.checks.numerical_floor import numerical_floor
from dr_lab.diagnosis.checks.open_chains import Mending, open_chain
from dr_lab.diagnosis.checks.refinement import refine
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.faults.unit_suspicion import FewWindows, suspect_misread
from dr_lab.errors import DrLabError
from dr_lab.measurements.read import read
from dr_lab.measurements.units import unit
from dr_lab.proposal.option_line import in_mjcf
from dr_lab.proposal.output import Output
from dr_lab.proposal.pages import measurements_page
from dr_lab.proposal.propose import Proposal
from dr_lab.proposal.rooms import rooms_of
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.split import Split, covering, split_logs
from dr_lab.trajectory import MeasurementSet

_MESSAGE = 300  # letters of an error that a comment shows


def usable_logs(
    proposal: Proposal, settings: ProposalSettings, checks: ComparisonSettings
) -> tuple[Split, MeasurementSet]:
    """Split the logs that the data contract lets pass.

    Args:
        proposal: how the logs are read.
        settings: how they are split.
        checks: which windows the other verbs ask for.

    Raises:
        DrLabError: none passes; the error of the first.
    """
    split, measured = _passing(proposal, settings)
    chosen = covering(
        split, (*measured.fit, *measured.held_out), proposal.logs.logs, rooms_of(measured, checks), settings
    )
    if chosen.held_out == split.held_out:
        return chosen, measured
    try:
        return chosen, _read(proposal, chosen, settings)
    except DrLabError:  # a held-out log would hold data of a fitted one
        return split, measured


def _passing(proposal: Proposal, settings: ProposalSettings) -> tuple[Split, MeasurementSet]:
    """The logs that pass, every third or so held out."""
    short = proposal.logs.short
    split = split_logs(proposal, short, settings.held_out)
    try:
        return split, _read(proposal, split, settings)
    except DrLabError as error:
        refused = _refused(proposal, split, settings)
        if len(refused) in (0, len(proposal.logs.logs) - len(short)):
            raise error from None
    split = split_logs(proposal, {**short, **refused}, settings.held_out)
    return split, _read(proposal, split, settings)


def closed(proposal: Proposal, measured: MeasurementSet, check: ModelCheckSettings) -> Proposal:
    """The proposal with the zero or direction that closes the robot's chains, or a doubt where none does."""
    found = open_chain(proposal.model.nominal(), (*measured.fit, *measured.held_out), measured.noise, check)
    if found is None:
        return proposal
    if found.mending is None:
        return replace(proposal, doubts=(*proposal.doubts, found.message))
    return replace(
        proposal,
        outputs=tuple(_read_as(output, found.mending) for output in proposal.outputs),
        notes=(*proposal.notes, found.message),
    )


def turned(proposal: Proposal, measured: MeasurementSet, checks: ComparisonSettings) -> Proposal:
    """The proposal with the other sign of a channel that counts the other way, or a doubt about the unit of one."""
    few = FewWindows(proposal.model, checks.faults.reading, checks.windows, checks.solver, checks.threads)
    found = suspect_misread(few, measured)
    if found is None:
        return proposal
    if not found.turned:
        return replace(proposal, doubts=(*proposal.doubts, found.message))
    note = (
        f"{found.channels[0]} is read with the other sign: so the model, simulated over a few windows, leaves χ² "
        f"{found.chi2_read_anew:.3g} of it and the others, else {found.chi2:.3g}."
    )
    return replace(
        proposal,
        outputs=tuple(
            replace(output, sign=-output.sign, offset=-output.offset or 0.0)
            if output.channel in found.channels
            else output
            for output in proposal.outputs
        ),
        notes=(*proposal.notes, note),
    )


def _read_as(output: Output, mending: Mending) -> Output:
    """An output with another zero and direction, where it is the one that is mended."""
    if output.channel != mending.channel:
        return output
    offset = mending.sign * output.offset + mending.offset / unit(output.unit).factor
    return replace(output, sign=mending.sign * output.sign, offset=float(f"{offset:.6g}"))


def told(proposal: Proposal, measured: MeasurementSet, checks: ComparisonSettings, faults: Sequence[Fault]) -> Proposal:
    """The proposal with what seems wrong with the logs, and with a time step that does not show.

    A URDF has no time step, so that it gets one that is fine enough; that of an MJCF stays, and what it does is told.
    """
    model, doubts = proposal.model, _by_message(faults)
    logs = measured.held_out or measured.fit
    loops = firm_loops(model, logs, measured, checks.windows, checks.model_check, checks.threads)
    if loops.share > checks.model_check.least_share:
        model, doubts = loops.model, [*doubts, f"{loops.seen} Write {loops.asked} into <equality>."]
    floor = numerical_floor(model, logs, measured, checks.windows, checks.threads)
    finer = refine(model, logs, measured, checks.windows, checks.model_check, floor, checks.threads)
    told = replace(proposal, doubts=(*proposal.doubts, *doubts))
    if not finer.message:
        return told
    times = f"{float(f'{floor.largest:.2g}'):g}"
    moved = f"The time step of {floor.step:g} s alone moves {floor.worst} by {times} noise standard deviations"
    step = finer.model.spec.option.timestep
    if not proposal.robot.urdf:
        remedy = in_mjcf(proposal, finer.model) if finer.left < floor.largest else ""
        doubt = f"{moved}, which can pass for missing physics. {remedy or 'Finer steps do not help (contacts).'}"
        return replace(told, doubts=(*told.doubts, doubt))
    note = f"Time step {step:g} s: {moved.replace('The time', 'a')}."
    spec = proposal.spec.copy()
    spec.option.timestep, spec.option.integrator = step, finer.model.spec.option.integrator
    return replace(told, spec=spec, notes=(*told.notes, note))


def _by_message(faults: Sequence[Fault]) -> list[str]:
    """What seems wrong with the logs; what is said of several in the same words, once."""
    logs: dict[str, list[str]] = {}
    for each in faults:
        logs.setdefault(f"{each.message} {each.remedy}", []).append(each.log)
    return [f"Log{'s' if len(names) > 1 else ''} {', '.join(names)}: {message}" for message, names in logs.items()]


def _refused(proposal: Proposal, split: Split, settings: ProposalSettings) -> dict[str, str]:
    """Logs that cannot be used alone, with the reason."""
    reasons = {}
    for name in (name for name in proposal.logs.logs if name not in proposal.logs.short):
        alone = Split(split.files, (name,), (), {})
        try:
            _read(proposal, alone, settings)
        except DrLabError as error:
            reasons[name] = str(error)[:_MESSAGE]
    return reasons


def _read(proposal: Proposal, split: Split, settings: ProposalSettings) -> MeasurementSet:
    entries: Mapping[str, Any] = yaml.safe_load(measurements_page(proposal, split))
    wanted = {key: value for key, value in entries.items() if key not in ("_target_", "defaults")}
    return read(**wanted, contract=settings.contract)
