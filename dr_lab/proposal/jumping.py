"""Series that hold and jump, as commands do and no joint."""

import numpy as np

from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array


def jumps(series: Series, settings: ProposalSettings) -> bool:
    """Whether a series holds its value nearly always, and else jumps far, in every log in which it changes.

    An angle that wraps jumps as far, but does not hold; one that is counted coarsely holds, but goes on in small steps.
    """
    moved = [signal.value for signal in series.signals if np.ptp(signal.value) > 0]
    return bool(moved) and all(_jumps(value, settings) for value in moved)


def _jumps(value: Array, settings: ProposalSettings) -> bool:
    steps = np.abs(np.diff(value))
    seldom = np.count_nonzero(steps) <= settings.jump_samples * len(steps)
    return bool(seldom and np.median(steps[steps > 0]) >= settings.jump * np.ptp(value))
