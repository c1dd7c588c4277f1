"""A page of several views."""

import math
from collections.abc import Sequence

import rerun.blueprint as rrb


def sheet(name: str, views: Sequence[rrb.View]) -> rrb.Grid:
    """As many columns as rows or one more: charts are nearly as high as wide, and their letters do not shrink."""
    return rrb.Grid(*views, grid_columns=_columns(len(views)), name=name)


def sheet_rows(count: int) -> int:
    """How many rows so many views have."""
    return -(-count // _columns(count))


def _columns(count: int) -> int:
    return max(1, math.ceil(math.sqrt(count)))
