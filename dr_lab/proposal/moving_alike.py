"""Series that nothing reads, but that move as a joint's position does: another sensor, or the other side of a gear."""

from collections.abc import Iterator, Sequence

import numpy as np

from dr_lab.channel_names import POSITION, joint_of, quantity
from dr_lab.errors import DataError
from dr_lab.measurements.inventory import Place
from dr_lab.proposal.command_units import UNITS
from dr_lab.proposal.drives import Command
from dr_lab.proposal.grid import Grid, grid_of, path_of
from dr_lab.proposal.output import Output
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series, Survey
from dr_lab.trajectory import Array

_COPY = 1e-5  # share by which a copy may differ, as by digits that were not written


def moving_alike(
    outputs: Sequence[Output], commands: Sequence[Command], logs: Survey, settings: ProposalSettings
) -> Iterator[str]:
    """What is said of them, a sentence or two each; copies of what is read, in its unit or another, are not told.

    Args:
        outputs: what is read.
        commands: likewise.
        logs: what they hold.
        settings: how well two series correlate that move alike.
    """
    read = {part.place for output in outputs for part in output.parts} | {each.series.place for each in commands}
    left = [each for each in logs.series if _may_be_position(each) and each.place not in read]
    smoothed = _Smoothed(settings)
    for output in outputs:
        series, *more = output.parts
        if quantity(output.channel) != POSITION or more:
            continue
        for other in left:
            ratio = _ratio(series, other, smoothed, settings)
            if ratio is not None:
                yield _said(output, other, ratio)


def _may_be_position(series: Series) -> bool:
    return series.moves and not series.words.asked and series.words.kind in ("position", "")


class _Smoothed:
    """Smoothed numbers of series about their mean, each once for all pairs that share its times."""

    def __init__(self, settings: ProposalSettings) -> None:
        self._settings = settings
        self._found: dict[tuple[Place, bytes, bytes], Array] = {}

    def __call__(self, series: Series, grid: Grid) -> Array:
        """Those of a series on a grid."""
        key = (series.place, grid.log.tobytes(), grid.time.tobytes())
        if key not in self._found:
            value = path_of(series, grid, self._settings.cutoff).value
            self._found[key] = value - value.mean()
        return self._found[key]


def _ratio(series: Series, other: Series, smoothed: _Smoothed, settings: ProposalSettings) -> float | None:
    """How far another series moves for each unit of a series; None where it moves otherwise, or is a copy."""
    try:
        grid = grid_of([series, other], settings)
    except DataError:  # they share no time
        return None
    x, y = smoothed(series, grid), smoothed(other, grid)
    norms = float(np.sqrt((x @ x) * (y @ y)))
    if norms == 0.0 or abs(float(x @ y)) < settings.alike * norms:
        return None
    ratio = float(np.sqrt((y @ y) / (x @ x)) * np.sign(x @ y))
    exact = float(np.abs(y - ratio * x).max()) < _COPY * float(np.abs(y).max())
    sizes = [a / b for known in (UNITS["rad"], UNITS["m"]) for a in known.values() for b in known.values()]
    return None if exact and any(abs(ratio / size - 1) < _COPY for size in sizes) else ratio


def _said(output: Output, other: Series, ratio: float) -> str:
    joint, scale = joint_of(output.channel), output.sign * output.scale / ratio
    far = f"{abs(ratio):.3g} times as far" + (", the other way" if ratio < 0 else "")
    return (
        f"{other.place} and {output.source} move alike ({other.place} {far}), and only {output.source} is read, as "
        f"{output.channel}. If {other.place} is what {joint} of the model stands for, such as the motor's side of a "
        f"gear, read it in place of {output.source}, with scale: {abs(scale):.3g}{', sign: -1' if scale < 0 else ''}."
    )
