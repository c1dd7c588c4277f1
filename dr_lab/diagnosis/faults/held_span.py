"""The beginning or the end of a log at which a joint rests where it would move: somebody or something holds it."""

from dataclasses import dataclass

import numpy as np

from dr_lab.diagnosis.faults.drive_fit import FRICTION, DriveFit
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.smoothed_motion import Mask

_APART = 2  # test functions that reach into one of the span
_NEXT = 1.5  # times the usual step between two of them, where none is left out


@dataclass(frozen=True)
class HeldSpan:
    """Test functions in which a joint is held.

    Attributes:
        rows: their places, from the first or to the last one.
        force: what would move the joint by the model, N·m or N.
        friction: dry friction of its motion elsewhere, the model's included.
    """

    rows: slice
    force: float
    friction: float


def held_spans(fit: DriveFit, known: float, settings: FaultSettings) -> list[HeldSpan]:
    """The spans at a log's ends in which the joint rests against a force that friction cannot hold.

    What rests needs no inertia, and what it needs beside the actuators' force the joint itself must hold. Gravity,
    inertia and friction of the model are fitted, within what a nominal model may be wrong, to the motion elsewhere.
    A joint is held where `settings.breakaway` times that friction, and `settings.held_margin` standard deviations of
    what the motion leaves, are less than what is needed, by the fit and by the model itself: a fitted constant may ask
    for a force where nothing acts.

    Args:
        fit: of the joint, without a drive.
        known: dry friction that the model has there, N·m or N; what the motion needs is beside it.
        settings: thresholds.
    """
    still = np.abs(fit.speed) <= settings.resting
    spans = [span for span in (_leading(still), _trailing(still)) if span is not None and _at_an_end(fit, span)]
    return [found for span in spans if (found := _held(fit, known, still, span, settings)) is not None]


def _at_an_end(fit: DriveFit, span: slice) -> bool:
    """Whether a span reaches to an end of the log without a gap."""
    hop = float(np.median(np.diff(fit.time)))
    first, last = float(fit.index[span.start, 0]), float(len(fit.force) - 1 - fit.index[span.stop - 1, -1])
    ends = min(first, last) * fit.step <= _NEXT * hop
    return ends and bool((np.diff(fit.time[span]) <= _NEXT * hop).all())


def _held(fit: DriveFit, known: float, still: Mask, span: slice, settings: FaultSettings) -> HeldSpan | None:
    moving = ~still
    moving[max(span.start - _APART, 0) : span.stop + _APART] = False
    if fit.time[span][-1] - fit.time[span][0] < settings.shortest_held or moving.sum() < settings.fewest:
        return None
    found = fit.gain(0.0, 0.0, moving)
    needed, unexplained = (abs(float(np.median(values[span]))) for values in (fit.need, found.rest))
    friction = known + found.friction * float(np.abs(fit.others[moving, FRICTION]).max())
    left = np.sqrt(found.left / moving.sum())
    if min(needed, unexplained) <= settings.breakaway * friction + settings.held_margin * left:
        return None
    return HeldSpan(span, needed, friction)


def _leading(still: Mask) -> slice | None:
    """The run of test functions at rest from the first on; None where the first one moves, or all rest."""
    count = int(np.argmin(still))
    return slice(0, count) if count else None


def _trailing(still: Mask) -> slice | None:
    found = _leading(still[::-1])
    return None if found is None else slice(len(still) - found.stop, len(still))
