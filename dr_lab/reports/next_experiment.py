"""What a report says of the next experiment: what it is for, how it is played, what it keeps."""

from collections.abc import Mapping

from dr_lab.channel_names import joint_of
from dr_lab.reports.gap_entries import ExperimentEntry
from dr_lab.reports.quantity import in_unit, number, percent

_WORTH = 0.9  # of a standard deviation; an experiment that leaves more of it tells nothing
_NAMED = 3  # parameters that are told


def next_experiment_text(proposal: ExperimentEntry | None) -> str:
    """The section's text; empty where nothing is to be decided."""
    if proposal is None:
        return ""
    if proposal.reason:
        return _refused(proposal)
    aim = _separates(proposal) if proposal.separates else _sharpens(proposal)
    return f"{aim}\n\n{_played(proposal)}" if proposal.hold else aim


def _refused(proposal: ExperimentEntry) -> str:
    aim = f"separates {_pair(proposal)}" if proposal.separates else "tells more about the parameters"
    return (
        f"No experiment that {aim} may be played: the gentlest that was tried would leave {proposal.reason}. Widen "
        "`next_experiment.safety.margin` if the machine allows more than the logs show, or try other "
        "`next_experiment.durations`."
    )


def _pair(proposal: ExperimentEntry) -> str:
    return " from ".join(f"`{effect}`" for effect in proposal.separates[:2])


def _separates(proposal: ExperimentEntry) -> str:
    pair, apart = _pair(proposal), f"{number(proposal.sigma, 2)} σ"
    if proposal.sigma is not None and proposal.sigma < proposal.needed:
        return (
            f"No command that was tried separates {pair}: `{proposal.command_file}` comes farthest, with {apart}. "
            "To these sensors they may be the same; then a further channel would tell them apart, or a mass that is "
            "weighed, or a force that is measured. Or the motion is too small: where the model declares no limit, "
            "hardly more is allowed than the logs show. If the machine may do more, look again with a larger "
            "`next_experiment.safety.margin`, such as 2."
        )
    return f"Play `{proposal.command_file}`: it separates {pair} by {apart}."


def _sharpens(proposal: ExperimentEntry) -> str:
    rows = [row for row in proposal.sharpens if row.std and row.std_after is not None]
    told = [row for row in rows if (row.std_after or 0.0) < _WORTH * (row.std or 0.0)][:_NAMED]
    if not told:
        names = ", ".join(f"`{row.parameter}`" for row in rows[:_NAMED])
        return (
            f"No command that was tried would tell {names} better than the logs do: `{proposal.command_file}` comes "
            "farthest."
        )
    listed = "; ".join(
        f"`{row.parameter}` from ± {number(row.std, 2)} to ± {in_unit(row.std_after, row.unit, 2)}" for row in told
    )
    return f"Play `{proposal.command_file}`: with the logs it would sharpen {listed}."


def _played(proposal: ExperimentEntry) -> str:
    """How it is played, and what it keeps."""
    start = ", ".join(f"{joint_of(joint)} {number(at, 3)}" for joint, at in proposal.start.items())
    pose = f"Bring the machine to rest at {start} (rad or m)" if start else "Bring the machine to rest"
    rests = "" if proposal.rests else " It does not stay there by itself, so start without delay."
    return (
        f"{pose}, held by {_quantities(proposal.hold, proposal.units)}.{rests} "
        f"Send each row of the file at its `time_s`, {number(proposal.rate, 3)} a second for "
        f"{number(proposal.duration, 3)} s, and hold it until the next; columns are named after the actuators. "
        "Their numbers are the model's controls: what `measurements.commands` makes of a log's numbers by its unit, "
        "sign, scale and offset. It begins softly and ends with the commands that it began with. Simulated on the "
        f"fitted models, and on others within their uncertainty, it takes {percent(proposal.taken)} of what joint "
        "ranges, speeds, forces and the distances of parts allow, reserve apart. Watch it: simulation is no guard."
    )


def _quantities(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {in_unit(value, units.get(name, ''), 3)}" for name, value in values.items())
