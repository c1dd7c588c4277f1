"""What an actuator makes of its command, as a free curve."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.law_settings import LawSettings
from dr_lab.diagnosis.search.free_law import FreeLaw, curve
from dr_lab.effects.effect import PlacedEffect, Scales
from dr_lab.physics.effect_parts import CommandFilter, SpecEdit
from dr_lab.physics.model_effect import ModelEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_SERVO = ("position", "velocity")


@dataclass(frozen=True)
class FreeCommand(FreeLaw, SpecEdit, CommandFilter):
    """Any function of the command, and of servos any weight of position and speed beside it.

    u → e(u) + f(u), where e is what the effect makes of the command, and f piecewise linear with f(0) = 0. It takes the
    effect's place in a model, for behind it f could not tell commands that e makes one. So it brings the parts that an
    effect of the command has, its spec edit and its command filter. Where the actuator's force is
    g u + b₀ + b₁ q + b₂ v with b₁ or b₂, these are free, too.

    Attributes:
        checked: the effect that acts at the actuators.
        knots: of f, zero among them [unit of the command], shape (k,).
    """

    checked: PlacedEffect
    knots: Array

    @property
    def elements(self) -> tuple[str, ...]:
        """Those of the effect."""
        return self.checked.elements

    def replayed(self, spec: mujoco.MjSpec) -> "FreeCommand":
        """With the effect as it acts there."""
        checked = self.checked.replayed(spec)
        return self if checked is self.checked else replace(self, checked=checked)

    def beside(self, effect: ModelEffect) -> tuple[ModelEffect, ...]:
        """Itself, for it holds the effect."""
        del effect
        return (self,)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """The effect's edit, and what the servo takes from position and speed."""
        effect = self.checked.effect
        if isinstance(effect, SpecEdit):
            effect.edit(spec, site, self.checked.local(values))
        for place, name in enumerate(_SERVO, start=1):
            if change := values.get(f"{self.label}.{name}"):
                spec.actuator(site).biasprm[place] += change

    def filtered(self, values: Mapping[str, Array], series: Array, option: mujoco.MjOption) -> Array:
        """What the effect makes of commands, and the curve."""
        effect = self.checked.effect
        known = isinstance(effect, CommandFilter)
        made = effect.filtered(self.checked.local(values), series, option) if known else series
        heights = [values[p.name][:, 0, 0] for p in self.own[: len(self.knots) - 1]]
        middle = len(heights) // 2
        heights.insert(middle, np.zeros_like(heights[0]))
        rows = np.broadcast_to(series, (len(heights[0]), *series.shape[1:]))
        return made + curve(rows, self.knots, np.array(heights))


def free_command(
    effect: PlacedEffect, compiled: mujoco.MjModel, scales: Scales, settings: LawSettings
) -> FreeCommand | None:
    """The free law of the command of an effect's actuators; None where nothing was commanded.

    Args:
        effect: acts at actuators with one command each.
        compiled: the compiled nominal model.
        scales: give the size of the curve.
        settings: number of knots.
    """
    label, sized = f"free_command@{effect.site}", scales.most_used(effect.elements)
    largest = scales.command.get(sized, 0.0)
    if not largest > 0:
        return None
    grid = np.linspace(-largest, largest, 2 * settings.knots + 1)
    heights = [Parameter(f"{label}.at_{k}", "command", 0.0, -largest, largest) for k in range(1, len(grid))]
    own = (*heights, *_servo(label, sized, compiled))
    return FreeCommand(label, effect.site, (*effect.parameters, *own), own, effect, grid)


def _servo(label: str, actuator: str, compiled: mujoco.MjModel) -> list[Parameter]:
    """Parameters of what a servo takes from position and speed, as large as it has them; none where it has neither."""
    row = compiled.actuator(actuator).id
    if int(compiled.actuator_biastype[row]) != int(mujoco.mjtBias.mjBIAS_AFFINE):
        return []
    sizes = np.abs(compiled.actuator_biasprm[row, 1:3])
    units = ("N·m/rad or N/m", "N·m·s/rad or N·s/m")
    named = zip(_SERVO, units, sizes, strict=True)
    return [Parameter(f"{label}.{name}", unit, 0.0, -size, size) for name, unit, size in named if size > 0]
