"""Where the rows of a table stand in its file, for messages."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

_LISTED = 3  # rows that a message names


@dataclass(frozen=True)
class RowNumbers:
    """The place of each row.

    Attributes:
        word: ``line`` of a text file, whose first line names the columns and whose empty lines are not counted, or
            ``row`` of another file.
        numbers: of each row, from 1 on, shape (n,).
    """

    word: str
    numbers: NDArray[np.intp]

    @classmethod
    def of(cls, count: int, *, text: bool) -> Self:
        """Those of a whole table of so many rows, of a text file or another."""
        return cls("line", np.arange(2, count + 2)) if text else cls("row", np.arange(1, count + 1))

    def kept(self, keep: NDArray[np.bool_]) -> Self:
        """Those of some of the rows, shape (n,)."""
        return type(self)(self.word, self.numbers[keep])

    def __str__(self) -> str:
        """As messages name them, the first of many; e.g. ``lines 52, 54, 56 and 17 more``."""
        count = len(self.numbers)
        first = ", ".join(map(str, self.numbers[:_LISTED].tolist()))
        more = f" and {count - _LISTED} more" if count > _LISTED else ""
        return f"{self.word}{'s' * (count != 1)} {first}{more}"
