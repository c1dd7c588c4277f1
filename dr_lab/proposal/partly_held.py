"""Series that some logs hold and others lack, so that they are read in none."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from dr_lab.measurements.inventory import Place

_LISTED = 8  # names in a sentence


def partly_held(held: Mapping[str, Sequence[Place]], told: Collection[str] = ()) -> Iterator[str]:
    """What is said of series that only some logs hold, a sentence or two for those that the same logs lack.

    Args:
        held: by log, where it keeps its numbers.
        told: names of which something else is said already.
    """
    names = {log: {str(place) for place in places} for log, places in held.items()}
    every = dict.fromkeys(str(place) for places in held.values() for place in places)
    lacking: dict[tuple[str, ...], list[str]] = {}
    for name in every:
        without = tuple(log for log, known in names.items() if name not in known)
        if without and name not in told:
            lacking.setdefault(without, []).append(name)
    for logs, series in lacking.items():
        one, hold = len(series) == 1, "holds" if len(logs) == 1 else "hold"
        yield (
            f"{_few(series)} {'is' if one else 'are'} read in no log, as {_few(logs)} {hold} no numbers of "
            f"{'that name' if one else 'these names'}. Name {'it' if one else 'them'} alike in all logs, or leave out "
            f"the logs that lack {'it' if one else 'them'}."
        )


def _few(names: Sequence[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more
