"""Positions that are asked of a joint, counted as its angle is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from dr_lab.proposal.command_units import UNITS
from dr_lab.proposal.drives import BY_NAME, Command
from dr_lab.proposal.output import Output
from dr_lab.proposal.search import Found
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import settled


def at_rest(command: Command, output: Output, settings: ProposalSettings) -> Command | None:
    """A command of a servo as its joint comes to rest at it; None where no rest shows that.

    Such rests say sign, unit and zero of the one by those of the other, whatever the servo's gains are.

    Args:
        command: as it was chosen.
        output: position of the joint that the command moves.
        settings: what counts as rest, and how close as equal.
    """
    known, said = _units(command), command.series.words.unit
    rest = settled(output.parts[0], command.series, settings) if _stiffness(command) else None
    if rest is None or output.unit not in known:
        return None
    sizes = [(unit, 1.0) for unit in sorted(known, key=lambda name: name != said)]
    for unit, scale in [*sizes, (output.unit, output.scale)]:
        if rest.passes_for(known[unit] * scale / (known[output.unit] * output.scale), settings):
            return replace(
                command,
                unit=unit,
                sign=output.sign if rest.ratio > 0 else -output.sign,
                scale=scale,
                offset=output.offset * known[output.unit] / known[unit],
                seen=True,
                why=f"{command.why}; {command.drive.joint} comes to rest at it",
                doubts=_left_open(command, unit),
            )
    return None


def _left_open(command: Command, unit: str) -> tuple[str, ...]:
    """What is unsure of a command whose sign and unit the rests show."""
    said = command.series.words.unit
    named = (f"named {said}, but {command.drive.joint} comes to rest where {unit} would put it.",)
    others = () if command.seen else tuple(doubt for doubt in command.doubts if doubt != BY_NAME)
    return (*(named if said not in ("", unit) else ()), *others)


def of_units(outputs: Sequence[Output], commands: Sequence[Command], settings: ProposalSettings) -> Iterator[str]:
    """What is unsure of servos whose position and command are read in different units, a sentence each.

    Args:
        outputs: what is measured.
        commands: of the actuators.
        settings: what counts as rest.
    """
    places = {output.channel: output for output in outputs}
    for command in commands:
        output = places.get(f"{command.drive.joint}.position")
        if output is None or not _stiffness(command) or output.unit == command.unit:
            continue
        said = all(series.words.unit for series in (command.series, output.parts[0]))
        if not said and at_rest(command, output, settings) is None:
            yield (
                f"{command.drive.name}: {output.source} is read in {output.unit}, but its command "
                f"{command.series.place} in {command.unit}. Logs of a servo mostly have one unit for both; check them."
            )


def counted(command: Command, found: Found, output: Output) -> Command:
    """A command as it is, or, where it is a position, with what it has in common with the logged angle.

    Where the motion does not tell, its sign and unit are those of the angle. Its offset is that of the angle where the
    motion agrees: a servo's force is kp (f · number + offset − q), so that the constant beside the number tells it.

    Args:
        command: as it was chosen.
        found: the reading of the joints; every joint has one degree of freedom.
        output: position of the joint that the command moves.
    """
    given, stiffness = command.given, _stiffness(command)
    if given is None or not stiffness:
        return command
    if not command.seen:
        said, why = command.series.words.unit, f"{command.why}, read as the angle is"
        unit, scale = (said, 1.0) if said else (output.unit, output.scale)
        command = replace(command, sign=output.sign, unit=unit, scale=scale, why=why)
    offset, seen = found.readings[command.drive.dof].offset, given.constant / stiffness
    factor = _units(command).get(command.unit)
    if factor is None or not offset or abs(seen - offset) > abs(seen):  # a unit of another kind has another zero
        return command
    return replace(command, offset=offset / factor, why=f"{command.why}; offset as the angle's")


def _units(command: Command) -> Mapping[str, float]:
    """Sizes of the units that a position of the joint may have."""
    return UNITS["m" if command.drive.slides else "rad"]


def _stiffness(command: Command) -> float:
    """Joint force per rad or m of a command that is a position; 0 of another."""
    if command.given is not None and command.given.stiffness > 0:
        return command.given.stiffness
    return command.drive.force if command.drive.servo else 0.0
