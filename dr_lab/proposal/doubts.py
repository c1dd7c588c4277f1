"""What the equation of motion leaves open about a reading, in words."""

from collections.abc import Iterator, Sequence

from dr_lab.errors import DataError
from dr_lab.proposal.search import Found, Readings, ambiguous
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series


def doubts_of(
    joints: Sequence[str],
    found: Found,
    candidates: Sequence[Series],
    settings: ProposalSettings,
    *,
    certain: bool,
) -> list[str]:
    """What the equation of motion leaves open, a sentence each.

    Args:
        joints: names, in the model's order.
        found: the chosen reading, and those that explain the motion as well.
        candidates: what may be positions.
        settings: thresholds.
        certain: whether it is known without the motion which series is which.

    Raises:
        DataError: the motion is not that of the robot, and it is not known otherwise.
    """
    left = float(found.outcome.left.max())
    if left > settings.fits and not certain:
        raise DataError(
            f"No reading of {', '.join(str(each.place) for each in candidates)} moves as {', '.join(joints)} do: the "
            f"best leaves {left:.0%} of a joint's forces unexplained. Are these logs of this robot? If so, "
            "name columns or topics after the joints (elbow_position), or write the measurements by hand."
        )
    return [*_unexplained(left, settings), *_turned(joints, found), *_open(joints, found, candidates)]


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
        yield f"As good in another order: {_orders(found, joints, candidates)}. Name columns after the joints."
    degrees = {
        j for other in found.plain for j, (a, b) in enumerate(zip(found.readings, other, strict=True))
        if abs(a.factor) != abs(b.factor) and a.series == b.series
    }  # fmt: skip
    if degrees:
        listed = ", ".join(joints[j] for j in sorted(degrees))
        yield f"The unit of {listed} is not seen in the motion: another would fit about as well."
    moved = [joints[j] for j, each in enumerate(found.readings) if each.offset]
    if moved:
        yield (
            f"The logs' angles of {', '.join(moved)} count from another direction than the model's, as the weight "
            "shows: offsets were added."
        )


def _different(a: Readings, b: Readings) -> bool:
    return any(x.series != y.series for x, y in zip(a, b, strict=True))


def _orders(found: Found, joints: Sequence[str], candidates: Sequence[Series]) -> str:
    other = next(each for each in found.plain if _different(found.readings, each))
    return ", ".join(f"{joint} = {candidates[r.series].place}" for joint, r in zip(joints, other, strict=True))
