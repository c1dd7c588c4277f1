"""Numbers in the title of a plot against time."""

import numpy as np

from dr_lab.reports.quantity import number
from dr_lab.trajectory import Array


def first_last(value: Array) -> str:
    """As ``: 1 → 2``, or of one known value as ``: 1``; nothing where none is."""
    known = value[np.isfinite(value)]
    ends = known[[0, -1]] if len(known) > 1 else known
    return f": {' → '.join(number(each, 3) for each in ends.tolist())}" if len(known) else ""
