"""Which of many promising candidates are fitted where not all can be."""

from collections import Counter
from collections.abc import Sequence

from dr_lab.effects.effect import PlacedEffect


def shortlist(order: Sequence[int], placed: Sequence[PlacedEffect], most: int) -> list[int]:
    """Of candidates in the order of their promise at most so many: those first, and as many with one parameter.

    Whatever holds another effect promises at least as much; it must not take the simpler one's place. Nor must many
    kinds of one effect take that of another joint: of those with one parameter the first of each site come first.
    """
    half = order[: (most + 1) // 2]
    simple = [k for k in order if len(placed[k].parameters) == 1 and k not in half]
    taken, turn = Counter(placed[k].site for k in half if len(placed[k].parameters) == 1), dict[int, int]()
    for k in simple:
        turn[k] = taken[placed[k].site]
        taken[placed[k].site] += 1
    simple.sort(key=lambda k: turn[k])
    return list(dict.fromkeys([*half, *simple[: most // 2], *order]))[:most]
