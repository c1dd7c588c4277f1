"""What the equation of motion leaves open about a reading, in words."""

from collections.abc import Iterator, Sequence

from dr_lab.errors import DataError
from dr_lab.proposal.search import Found, Readings, ambiguous
from dr_lab.proposal.searched import Searched
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series, Survey

_LISTED = 20  # series that a message names


def doubts_of(
    joints: Sequence[str], found: Found, candidates: Sequence[Series], settings: ProposalSettings
) -> tuple[str, ...]:
    """What the equation of motion leaves open, a sentence each.

    Args:
        joints: names, in the model's order.
        found: the chosen reading, and those that explain the motion as well.
        candidates: what may be positions.
        settings: thresholds.
    """
    left = float(found.outcome.left.max())
    return (*_unexplained(left, settings), *_turned(joints, found), *_open(joints, found, candidates))


def require_fit(
    joints: Sequence[str],
    searched: Searched,
    candidates: Sequence[Series],
    logs: Survey,
    settings: ProposalSettings,
) -> None:
    """Refuse logs that do not move as the robot does, where only the motion can tell which series is which.

    Args:
        joints: names, in the model's order.
        searched: the best reading, and what was tried.
        candidates: what may be positions.
        logs: everything that they hold.
        settings: thresholds.

    Raises:
        DataError: the motion is not that of the robot.
    """
    left = searched.found.outcome.left.tolist()
    if max(left) <= settings.fits:
        return
    moved = [f"{share:.0%} of {joint}'s" for joint, share in zip(joints, left, strict=True) if share > settings.fits]
    commands = [each for each in (*searched.asked, *searched.vain) if each not in candidates]
    tried = f" with {_listed(commands)} as command" if commands else " without a command"
    rest = [each for each in logs.series if each.moves and each not in (*candidates, *commands)]
    unread = (f" Not read: {_listed(rest)}." if rest else "") + "".join(f" {said}" for said in logs.spoilt)
    drive = next((drive.name for drive in searched.drives), joints[0])
    raise DataError(
        f"No reading of {_listed(candidates)} moves as {', '.join(joints)} do{tried}: the best leaves "
        f"{' and '.join(moved)} forces unexplained.{unread} Are these logs of this robot? If so, name columns or "
        f"topics after the joints ({joints[0]}_position) and commands after the actuators ({drive}_command), or write "
        "the measurements by hand."
    )


def _listed(series: Sequence[Series]) -> str:
    """Where some series are, the first of very many."""
    return ", ".join(str(each.place) for each in series[:_LISTED]) + " …" * (len(series) > _LISTED)


def _unexplained(left: float, settings: ProposalSettings) -> Iterator[str]:
    if left > settings.fits:
        yield (
            f"As read here the equation of motion leaves {left:.0%} of a joint's forces unexplained: the logs may "
            "be of another robot, the masses far off, or a force missing that the model knows nothing of."
        )
    elif left > settings.well:
        yield (
            f"The best reading leaves {left:.0%} of a joint's forces unexplained: an angle may be read wrongly "
            "(absolute where the model's is relative, another zero), or a mass be far off."
        )


def _turned(joints: Sequence[str], found: Found) -> Iterator[str]:
    """Signs that may be turned together, where any is turned."""
    turned = any(each.factor < 0 for each in found.readings) or any(
        given[0].gain < 0 for given in found.outcome.given if given
    )
    sets = ambiguous(found)
    if sets and turned:
        listed = "; ".join(" and ".join(joints[j] for j in each) for each in sets)
        yield f"As good with the signs of {listed} turned, each with those of its commands: check one joint's."


def _open(joints: Sequence[str], found: Found, candidates: Sequence[Series]) -> Iterator[str]:
    """Orders and units that the motion does not decide, and angles that were moved."""
    if any(_different(found.readings, other) for other in found.plain):
        yield f"Not certain which is which: {_orders(found, joints, candidates)} Name columns after the joints."
    sizes = {
        (j, f"{abs(b.factor / a.factor):.3g}")
        for other in found.plain for j, (a, b) in enumerate(zip(found.readings, other, strict=True))
        if abs(a.factor) != abs(b.factor) and a.series == b.series
    }  # fmt: skip
    for j in sorted({j for j, _ in sizes}):
        listed = " or ".join(sorted((size for of, size in sizes if of == j), key=float))
        yield f"The unit of {joints[j]} is not seen in the motion: {listed} times it would fit about as well."
    moved = [j for j, each in enumerate(found.readings) if each.offset]
    for shows, some in (
        ("weight shows", [joints[j] for j in moved if j not in found.turning]),
        ("gyroscope shows", [joints[j] for j in moved if j in found.turning]),
    ):
        if some:
            yield (
                f"The logs' angles of {', '.join(some)} count from another direction than the model's, as the {shows}: "
                "offsets were added."
            )


def _different(a: Readings, b: Readings) -> bool:
    return any(x.series != y.series for x, y in zip(a, b, strict=True))


def _orders(found: Found, joints: Sequence[str], candidates: Sequence[Series]) -> str:
    """Another order, and what it and the chosen one leave of the forces."""
    pairs = zip(found.plain, found.plain_left, strict=True)
    other, left = next(pair for pair in pairs if _different(found.readings, pair[0]))
    named = ", ".join(f"{joint} = {candidates[r.series].place}" for joint, r in zip(joints, other, strict=True))
    here = found.outcome.total
    return (
        f"{named} leaves {100 * left:.2g} % of the forces unexplained, this order {100 * here:.2g} %; a model's own "
        "errors may leave as much."
    )
