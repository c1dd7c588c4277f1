"""The verb `init`: what a user has, a robot's description and logs, to a model and measurements for the other verbs."""

import shlex
from collections.abc import Sequence
from dataclasses import replace

from dr_lab.comparison.comparison import ComparisonSettings
from dr_lab.diagnosis.faults.data_faults import suspect_faults
from dr_lab.diagnosis.faults.drive_fit import forces_of
from dr_lab.errors import DrLabError
from dr_lab.files import write_text
from dr_lab.proposal.checked import closed, told, turned, usable_logs
from dr_lab.proposal.folder import Folder
from dr_lab.proposal.held import without_held
from dr_lab.proposal.pages import measurements_page, model_page, model_xml
from dr_lab.proposal.propose import Proposal, propose
from dr_lab.proposal.robot import read_robot
from dr_lab.proposal.rooms import doubt_of_room
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.split import Split, split_logs
from dr_lab.proposal.survey import survey
from dr_lab.reports.typed import typed

_SHOWN = 8  # series that are not read


def init(
    robot: str, logs: Sequence[str], folder: Folder, proposal: ProposalSettings, checks: ComparisonSettings
) -> Proposal:
    """Propose a model and measurements, and write them.

    Args:
        robot: an MJCF or URDF file, a folder with one, or a name of the package robot_descriptions.
        logs: files, globs, or folders with logs of one kind.
        folder: where the files go.
        proposal: thresholds.
        checks: settings of the comparing verbs, by which they will look at model and logs.

    Returns:
        What was written.

    Raises:
        ConfigError: the files are there already.
        DataError: there are no logs, they cannot be read, or do not fit the robot.
        ModelError: the robot cannot be read.
    """
    described = read_robot(robot, folder.name)
    files = folder.files(described.name)
    found = propose(described, survey(logs, proposal), proposal)
    found, split = _checked(found, proposal, checks)
    write_text(files.xml, model_xml(found))
    write_text(files.measurements, measurements_page(found, split))
    write_text(files.model, model_page(found))
    _tell(found, split, folder)
    return found


def _checked(found: Proposal, settings: ProposalSettings, checks: ComparisonSettings) -> tuple[Proposal, Split]:
    """The proposal with what the other verbs would say first, and how its logs are used."""
    try:
        split, measured = usable_logs(found, settings, checks)
        mended = closed(found, measured, checks.model_check)
        if mended.outputs != found.outputs:
            split, measured = usable_logs(mended, settings, checks)
        found, mended = mended, turned(mended, measured, checks)
        if mended.outputs != found.outputs:
            split, measured = usable_logs(mended, settings, checks)
        room = doubt_of_room(measured, checks)
        found = replace(mended, doubts=(*mended.doubts, *([room] if room else [])))
    except DrLabError as error:
        refused = f"The other verbs refuse these logs as they are read here: {error}"
        return replace(found, doubts=(*found.doubts, refused)), split_logs(found, found.logs.short, settings.held_out)
    try:
        faults = suspect_faults(forces_of(found.model, measured, checks.faults), measured)
        split = without_held(split, faults, found.logs.logs)
        return told(found, measured, checks, [fault for fault in faults if not fault.rest]), split
    except DrLabError as error:
        return replace(found, doubts=(*found.doubts, str(error))), split


def _tell(found: Proposal, split: Split, folder: Folder) -> None:
    """What was found, what is unsure, and what to type next."""
    name = found.robot.name
    rows = [(o.channel, o.source, o.unit, o.sign, o.why) for o in found.outputs]
    rows += [(c.drive.name, str(c.series.place), c.unit, c.sign, c.why) for c in found.commands]
    widths = [max(len(str(row[k])) for row in rows) for k in range(3)]
    free = len(found.model.declared)
    count = f"{split.said(len(found.logs.logs))}, {free} free parameter{'s' * (free != 1)}"
    print(f"{name}: {count}\n")
    for channel, place, unit, sign, why in rows:
        turned = "−" if sign < 0 else " "
        print(f"  {channel:<{widths[0]}}  {turned}{place:<{widths[1]}}  {unit:<{widths[2]}}  {why}")
    parts = {"Done": found.notes, "Unsure": found.doubts, "Left out": _reasons(split), "Not read": _few(found.unread)}
    for title, sentences in parts.items():
        if sentences:
            print("\n".join([f"\n{title}:", *(f"  - {sentence}" for sentence in sentences)]))
    files = folder.files(name, free=False)
    print(f"\nWritten: {', '.join(map(str, files))}")
    print(f"Where a guess is wrong, correct it under outputs, commands or contract of {files.measurements},")
    print("whose last lines say what these may hold.")
    chosen = f"{typed('model', name)} {typed('measurements', name)}"
    print(f"Next: dr-lab close --config-dir {shlex.quote(str(folder.path))} {chosen}")


def _few(names: Sequence[str]) -> list[str]:
    """The first names on one line, and how many more there are; nothing of none."""
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return [", ".join(names[:_SHOWN]) + more] if names else []


def _reasons(split: Split) -> list[str]:
    return [f"{name}: {why}" for name, why in {**split.left_out, **split.shortened}.items()]
