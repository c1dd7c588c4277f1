"""Notes on what no logs, or these logs badly, tell apart: effects that act together as another, values that trade."""

from collections.abc import Iterator, Mapping

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextEstimate
from dr_lab.reports.gap_entries import TOGETHER, TRADE, NoteEntry
from dr_lab.reports.quantity import number, uncertain

_FAR = 0.2  # standard deviation of the sum, in that of the better known of both
_MOST = 3  # pairs that are told


def trading(found: ContextEstimate) -> list[NoteEntry]:
    """Notes on pairs of an effect's parameter and another one of the same unit that trade, most telling first.

    Of x ± y the variance is σ_x² + σ_y² ± 2 cov(x, y).
    """
    pairs = sorted(_pairs(found))[:_MOST]
    return [NoteEntry(message, TRADE) for _, message in pairs]


def together(last: FittedModel) -> list[NoteEntry]:
    """Notes on effects of a model as which others act together, exactly, so that no log tells them apart."""
    placed = [effect for effect in last.model.effects if isinstance(effect, PlacedEffect)]
    told = [(effect, _parts(effect, last.values())) for effect in placed]
    return [
        NoteEntry(f"No log tells `{effect.label}` from {' and '.join(parts)} together.", TOGETHER)
        for effect, parts in told
        if parts
    ]


def _parts(effect: PlacedEffect, values: Mapping[str, float]) -> list[str]:
    own = {p.name.removeprefix(f"{effect.label}."): values[p.name] for p in effect.parameters}
    unit = effect.parameters[0].unit
    return [
        f"`{name}@{effect.site}` ({number(value, 3)} {unit})" for name, value in effect.effect.together(own).items()
    ]


def _pairs(found: ContextEstimate) -> Iterator[tuple[float, str]]:
    """How well the sum or difference is known beside either value, and a sentence."""
    std, rows = found.std, found.space.parameters
    for a, first in enumerate(rows):
        for b, second in enumerate(rows[:a]):
            least = min(std[a], std[b])
            if first.unit != second.unit or least <= 0 or "@" not in f"{first.name}{second.name}":
                continue
            sign = -np.sign(found.covariance[a, b]) or 1.0
            known = np.sqrt(max(std[a] ** 2 + std[b] ** 2 + 2 * sign * found.covariance[a, b], 0.0))
            if known >= _FAR * least:
                continue
            value = uncertain(float(found.mean[b] + sign * found.mean[a]), float(known), first.unit)
            what = "sum" if sign > 0 else "difference"
            message = (
                f"{second.name} and {first.name} trade: the logs know their {what}, {value}, far better than either. "
                "Use both or neither."
            )
            yield float(known / least), message
