"""Series that are the derivative of a position."""

from collections.abc import Sequence

import numpy as np

from dr_lab.proposal.grid import grid_of, path_of
from dr_lab.proposal.lengths import is_bare
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array


def may_be_rate(series: Series) -> bool:
    """Whether a series' name leaves open that it is a velocity: it says neither a position nor a unit."""
    return not series.words.unit and (series.words.kind == "" or is_bare(series))


def no_velocities(series: Sequence[Series], positions: Sequence[Series], settings: ProposalSettings) -> list[Series]:
    """The series that are not the derivative of a position.

    Args:
        series: what may be velocities.
        positions: what they may be derivatives of; the series themselves may be among them.
        settings: how well a velocity correlates with its position's derivative.
    """
    if not series or not any(position is not each for position in positions for each in series):
        return [*series]
    grid = grid_of([*positions, *series], settings)
    slopes = _centred([path_of(each, grid, settings.cutoff).slope for each in positions])
    values = _centred([path_of(each, grid, settings.cutoff).value for each in series])
    norms = np.outer(np.linalg.norm(slopes, axis=1), np.linalg.norm(values, axis=1))
    alike = np.abs(slopes @ values.T) / np.where(norms == 0, np.inf, norms)
    return [each for k, each in enumerate(series) if alike[:, k].max() < settings.derivative]


def _centred(rows: Sequence[Array]) -> Array:
    stacked = np.stack(rows)
    return stacked - stacked.mean(1, keepdims=True)
