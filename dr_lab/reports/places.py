"""Where the figures of a report stand: paths of keys joined by dots."""

from collections.abc import Mapping

ANY = "*"


def places(report: object, path: str) -> dict[str, object]:
    """What lies at a path.

    Args:
        report: as JSON holds it.
        path: keys joined by dots, which a key may hold itself, as ``arm.mass`` does; numbers for entries of lists, from
            the end negative ones; ``*`` for every key or entry. Empty, it leads to the report.

    Returns:
        By full path; nothing where it leads nowhere.
    """
    if not path:
        return {"": report}
    return {
        f"{key}.{place}".removesuffix("."): end
        for key, child in _children(report, path).items()
        if (rest := _below(key, path)) is not None
        for place, end in places(child, rest).items()
    }


def beside(report: object, path: str) -> list[str]:
    """The paths that go on where one ends that leads to no figure; none where nothing goes on.

    Args:
        report: in which the path leads nowhere.
        path: as for `places`.
    """
    parts = path.split(".")
    begun = (".".join(parts[:depth]) for depth in range(len(parts), -1, -1))
    known = next(each for each in begun if places(report, each))
    return list(places(report, f"{known}.{ANY}".removeprefix(".")))


def _children(value: object, path: str) -> Mapping[str, object]:
    """Keys of a mapping or numbers of a list, negative ones where the path begins with one."""
    if isinstance(value, list):
        first = -len(value) if path.startswith("-") else 0
        return {str(at): value[at] for at in range(first, first + len(value))}
    return value if isinstance(value, Mapping) else {}


def _below(key: str, path: str) -> str | None:
    """How a path goes on below a key; None where it leads elsewhere."""
    first, _, rest = path.partition(".")
    if first == ANY:
        return rest
    return path[len(key) + 1 :] if f"{path}.".startswith(f"{key}.") else None
