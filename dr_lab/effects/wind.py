"""A medium that moves past the machine."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.generalised_forces import fluid_forces
from dr_lab.effects.own_option import note_own, noted_own
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_AXES = ("x", "y", "z")
_LEVEL = _AXES[:2]


@dataclass(frozen=True)
class Wind(Effect, SpecPreparation, SpecEdit):
    """A steady, level wind: every link moves through the medium with its velocity less the wind's.

    v → v − (x, y, 0) in MuJoCo's fluid forces, in the axes of the world.

    Parameters (nominal = absent): x, y [m/s], absent = the model's own wind in the file; each only where it changes a
    generalised force of the model to first order. Where the model declares its wind, x and y less the file's values are
    added to it.
    Limits: models whose medium has a density or a viscosity; without either there is nothing that blows.
    Source: MuJoCo 4.0, option/wind and computation chapter ("Fluid forces").

    Attributes:
        strongest: how far either speed may lie from the model's own [m/s].
        start: speed of the fits that start away from absent, share of `strongest`.
        sensitive: a direction counts as felt above this share of the force of an equal wind in the worst direction.
        poses: number of states in which that is looked for.
    """

    strongest: float
    start: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "wind"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "v -> v - (x, y, 0) in the medium's drag"
    fingerprint: ClassVar[str] = (
        "force residual at rest too, larger against one direction of motion; turns with the links"
    )
    confused_with: ClassVar[tuple[str, ...]] = ("constant_offset", "base_tilt", "air_drag")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """``world``, where a wind is felt."""
        return ("world",) if self._felt(model) else ()

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The speeds that are felt."""
        del site, scales
        felt = self._felt(model)
        return tuple(
            Parameter(axis, "m/s", float(own), float(own) - self.strongest, float(own) + self.strongest)
            for axis, own in zip(_AXES, model.opt.wind, strict=True)
            if axis in felt
        )

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A wind either way along each axis: its drag grows with its square, of which little shows in still air."""
        away = self.start * self.strongest
        return tuple({p.name: p.nominal + sign * away} for p in parameters for sign in (1.0, -1.0))

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Note the file's own wind."""
        note_own(spec, f"{self.name}@{site}", list(spec.option.wind))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Change the wind by what lies beyond the file's own."""
        own = dict(zip(_AXES, noted_own(spec, f"{self.name}@{site}"), strict=True))
        spec.option.wind += np.array([values.get(axis, speed) - speed for axis, speed in own.items()])

    def _felt(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Level axes along which a wind changes a generalised force in some state."""
        if not (model.opt.density > 0 or model.opt.viscosity > 0):
            return ()
        change = {
            axis: _blown(model, self.strongest * direction, self.poses)
            for axis, direction in zip(_AXES, np.eye(3), strict=True)
        }
        least = self.sensitive * max(change.values())
        return tuple(axis for axis in _LEVEL if change[axis] > least)


def _blown(model: mujoco.MjModel, wind: Array, poses: int) -> float:
    """Largest difference of a generalised force between a wind and its opposite."""
    forces = []
    for sign in (1.0, -1.0):
        windy = copy(model)
        windy.opt.wind[:] += sign * wind
        forces.append(fluid_forces(windy, poses))
    return float(np.abs(forces[0] - forces[1]).max(initial=0.0))
