"""Where the contexts of new episodes come from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

UNKEYED = -1
"""Key of a context that was drawn from a distribution or given, and so belongs to no proposal."""

Keys = NDArray[np.int64]


@dataclass(frozen=True)
class Proposals:
    """Contexts of k new episodes.

    Attributes:
        z: contexts, shape (k, n).
        keys: which proposal of the source each of them is, shape (k,); `UNKEYED` where it is none. A batch carries them
            as ``proposal``, so that a source knows the episodes of its proposals without comparing contexts.
    """

    z: Array
    keys: Keys


class ContextSource(Protocol):
    """Where the contexts of new episodes come from; every randomizer is one.

    While a batch is collected a source is only read: a collector may send copies of it to other machines.
    """

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        """A context for each of some slots.

        Args:
            rngs: random stream of each, length k.
            slots: their numbers among all slots that train, shape (k,).
        """
        ...
