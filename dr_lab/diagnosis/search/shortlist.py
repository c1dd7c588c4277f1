"""Which of many promising candidates are fitted where not all can be."""

from collections.abc import Sequence

from dr_lab.effects.effect import PlacedEffect


def shortlist(order: Sequence[int], placed: Sequence[PlacedEffect], most: int) -> list[int]:
    """Of candidates in the order of their promise at most so many: those first, and as many with one parameter.

    Whatever holds another effect promises at least as much; it must not take the simpler one's place.
    """
    half = order[: (most + 1) // 2]
    simple = [k for k in order if len(placed[k].parameters) == 1 and k not in half]
    return list(dict.fromkeys([*half, *simple[: most // 2], *order]))[:most]
