"""Which series a joint or an actuator may be, by the names of both."""

from collections.abc import Sequence

from dr_lab.proposal.survey import Series
from dr_lab.proposal.words import identity


def matches(names: Sequence[str], series: Sequence[Series]) -> list[list[int]]:
    """The series that each name may mean, as places among them; one where the names leave no choice.

    A series' own words decide first (``elbow_flex.pos`` of joint ``elbow_flex``), then its number, where as many are
    numbered as there are names: those of names with the same numbers (``j5`` and ``pos (5)``), else in the order of the
    model (``data[0]``, ``data[1]``). Names that say nothing may mean any series that is not another's.

    Args:
        names: of joints or actuators, in the model's order.
        series: candidates.
    """
    by_words = _by_words(names, series)
    taken = {k for found in by_words for k in found}
    rest = [k for k in range(len(series)) if k not in taken]
    by_number = _by_number(names, [series[k] for k in rest]) if not taken else []
    if by_number:
        return [[rest[k] for k in found] for found in by_number]
    return [found or rest for found in by_words]


def say_same(names: Sequence[str], series: Sequence[Series]) -> bool:
    """Whether the words of the names alone say which series is which."""
    return all(len(found) == 1 for found in _by_words(names, series))


def said_of(names: Sequence[str], series: Sequence[Series]) -> set[int]:
    """The series that share words with one of the names, as places among them."""
    return {k for found in _by_words(names, series) for k in found}


def _by_words(names: Sequence[str], series: Sequence[Series]) -> list[list[int]]:
    """Those series that share the most words with a name, and with no other name more."""
    exact = [[k for k, each in enumerate(series) if each.place.label == name] for name in names]
    if all(exact):
        return exact
    wanted = [identity(name) for name in names]
    shared = [[_alike(words, each) for each in series] for words in wanted]
    found = []
    for i, row in enumerate(shared):
        best = max(row, default=0.0)
        mine = [k for k, score in enumerate(row) if score == best and score > 0]
        found.append([k for k in mine if all(shared[j][k] < best for j in range(len(names)) if j != i)])
    return found


def _alike(words: frozenset[str], series: Series) -> float:
    """Share of a name's words that a series has; its numbers must agree where both have one."""
    numbers = {int(word) for word in words if word.isdigit()}
    if numbers and series.words.number is not None and series.words.number not in numbers:
        return 0.0
    plain = {word for word in words if not word.isdigit()}
    same = len(plain & series.words.identity)
    return same / len(plain | series.words.identity) + (0.1 if same and numbers else 0.0) if plain else 0.0


def _by_number(names: Sequence[str], series: Sequence[Series]) -> list[list[int]]:
    """Series by their numbers, several of one number where they are called differently."""
    numbers = sorted({each.words.number for each in series if each.words.number is not None})
    if len(numbers) != len(names) or len(names) < 2:
        return []
    own = [[int(word) for word in identity(name) if word.isdigit()] for name in names]
    if sorted(own) == [[number] for number in numbers]:
        numbers = [number for (number,) in own]
    return [[k for k, each in enumerate(series) if each.words.number == number] for number in numbers]
