"""Positions that are asked of a joint, counted as its angle is."""

from dataclasses import replace

from dr_lab.proposal.drives import UNITS, Command
from dr_lab.proposal.output import Output
from dr_lab.proposal.search import Found


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
        unit, why = command.series.words.unit or output.unit, f"{command.why}, read as the angle is"
        command = replace(command, sign=output.sign, unit=unit, why=why)
    offset, seen = found.readings[command.drive.dof].offset, given.constant / stiffness
    factor = UNITS["m" if command.drive.unit in ("m", "N") else "rad"].get(command.unit)
    if factor is None or not offset or abs(seen - offset) > abs(seen):  # a unit of another kind has another zero
        return command
    return replace(command, offset=offset / factor, why=f"{command.why}; offset as the angle's")


def _stiffness(command: Command) -> float:
    """Joint force per rad or m of a command that is a position; 0 of another."""
    if command.given is not None and command.given.stiffness > 0:
        return command.given.stiffness
    return command.drive.force if command.drive.servo else 0.0
