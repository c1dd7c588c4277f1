"""Windows that choose between models, and windows that choose nothing and confirm."""

import numpy as np

from dr_lab.diagnosis.windows.blocks import Indices, logs
from dr_lab.diagnosis.windows.windows import Windows

_PARTS = 3  # of which one confirms


def folds(windows: Windows) -> tuple[Windows, Windows | None]:
    """Windows that choose, and windows that confirm what was chosen.

    Every rung of a ladder is chosen on held-out windows, so that these flatter what is chosen. So

    1. of each log the last third of its windows chooses nothing;
    2. where logs hold a window or two, each third log chooses nothing;
    3. where there are fewer than three of these as well, all choose and none confirms.
    """
    groups = logs(windows.log)
    rows = [group[-(len(group) // _PARTS) :] for group in groups if len(group) >= _PARTS]
    kept = np.concatenate(rows) if rows else _last_logs(groups)
    if not len(kept):
        return windows, None
    return windows.pick(np.setdiff1d(np.arange(len(windows)), kept)), windows.pick(kept)


def _last_logs(groups: list[Indices]) -> Indices:
    """The windows of every third log."""
    return np.concatenate([np.zeros(0, np.intp), *groups[_PARTS - 1 :: _PARTS]])
