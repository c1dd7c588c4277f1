"""What could be measured on the machine to tell effects apart that the logs cannot."""

from collections.abc import Iterator
from math import log

from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.reports.gap_entries import MEASURABLE, NoteEntry
from dr_lab.reports.quantity import in_unit

_UNITS = ("kg", "kg·m²", "m")  # of what a scale, a swing or a ruler tells
_APART = log(1.05)  # what a scale tells of a link that hangs on its cables


def measurable(ladder: Ladder) -> list[NoteEntry]:
    """Note on the model's parameter that differs most between an effect and those that the logs do not tell from it.

    With a motor of 0.85 of its torque all masses are 0.85 of what they are with a motor of its full torque, and the
    motion is the same: no log tells. A link that is weighed does.
    """
    apart, message = max(_differences(ladder), default=(0.0, ""))
    return [NoteEntry(message, MEASURABLE)] if apart >= _APART else []


def _differences(ladder: Ladder) -> Iterator[tuple[float, str]]:
    """By which factor a parameter differs between an effect and a rival of it, as a logarithm, and a sentence."""
    for step in ladder.steps:
        ours = step.fitted_model.values()
        for rival in step.rivals:
            theirs = rival.fitted_model.values()
            for row in step.fitted_model.model.declared:
                one, other = ours[row.name], theirs[row.name]
                if row.unit not in _UNITS or min(one, other) <= 0:
                    continue
                yield (
                    abs(log(one / other)),
                    f"**A measurement tells:** `{row.name}` is {in_unit(one, row.unit, 3)} with `{step.effect.label}` "
                    f"and {in_unit(other, row.unit, 3)} with `{rival.effect.label}`; the model file says "
                    f"{in_unit(row.nominal, row.unit, 3)}. Measure it, and set its bounds in the model's `parameters`.",
                )
