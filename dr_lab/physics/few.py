"""Work on a few simulations of a batch, without waking threads for it."""

from collections.abc import Iterable

import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

# Waking the batch's other threads takes about 0.1 ms; what MuJoCo does for one of Hopper's simulations, 7 µs.
_FEW = 8


def in_calls(batch: Batch, ids: NDArray[np.intp]) -> Iterable[NDArray[np.intp]]:
    """Simulations as they are best handed to a batch: a few one by one, which this thread does itself, else all.

    Args:
        batch: runs on one thread or several.
        ids: the simulations.

    Returns:
        The same simulations in their order, those of each call together; results do not depend on it.
    """
    alone = batch.nthread > 1 and len(ids) <= _FEW
    return np.split(ids, len(ids)) if alone and len(ids) else [ids]
