"""Commands by elimination: actuators without one, and as many columns that nothing else reads."""

from collections.abc import Sequence

from dr_lab.errors import DataError
from dr_lab.proposal.by_name import matches
from dr_lab.proposal.drives import Command, Drive
from dr_lab.proposal.output import Positions
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.velocities import no_velocities

_MAY_COMMAND = ("drive", "reference", "")  # what names say, or leave open


def by_elimination(
    found: Positions, commands: Sequence[Command], logs: Survey, settings: ProposalSettings
) -> tuple[Command, ...]:
    """Commands of the model's own actuators that have none, where the logs have exactly as many columns left.

    A joint that hardly needs a force contradicts that it is driven: then nothing is proposed.

    Args:
        found: what is known of the positions.
        commands: found by the motion or by name.
        logs: what they hold, without what sensors read.
        settings: which motion needs no command.
    """
    given = {command.drive.name for command in commands}
    lacking = [drive for drive in found.drives if not drive.added and drive.name not in given]
    left = _left(found, commands, logs, settings) if lacking else []
    if len(lacking) != len(left) or any(_swings_freely(found, drive, settings) for drive in lacking):
        return ()
    return tuple(_command(drive, series) for drive, series in zip(lacking, _in_order(lacking, left), strict=True))


def _left(found: Positions, commands: Sequence[Command], logs: Survey, settings: ProposalSettings) -> list[Series]:
    """Series that change and may be commands, but that nothing reads; velocities are none."""
    positions = [part for output in found.outputs for part in output.parts]
    read = {series.place for series in (*positions, *(command.series for command in commands))}
    left = [s for s in logs.series if s.moves and s.words.kind in _MAY_COMMAND and s.place not in read]
    try:
        return no_velocities(left, positions, settings) if positions else left
    except DataError:  # they share no time with the positions
        return []


def _swings_freely(found: Positions, drive: Drive, settings: ProposalSettings) -> bool:
    return found.found is not None and float(found.found.outcome.idle[drive.dof]) <= settings.well


def _in_order(drives: Sequence[Drive], series: Sequence[Series]) -> list[Series]:
    """The series of each actuator by name, or, where the names leave that open, in the order of the logs."""
    named = matches([drive.name for drive in drives], series)
    told = {k for each in named for k in each[:1] if len(each) == 1}
    return [series[each[0]] for each in named] if len(told) == len(drives) else [*series]


def _command(drive: Drive, series: Series) -> Command:
    unit = series.words.unit or drive.unit
    doubt = (
        f"{series.place} is read as its command as no other column is left; the motion does not show it. Check sign "
        "and unit, or delete the entry."
    )
    why = f"by elimination{drive.told}"
    return Command(drive, series, None, unit, 1, 1.0, 0.0, seen=False, why=why, doubts=(doubt,))
