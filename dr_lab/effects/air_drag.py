"""The medium that a machine moves in."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.generalised_forces import fluid_forces, inverse_forces
from dr_lab.effects.own_option import note_own, noted_own
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class AirDrag(Effect, SpecPreparation, SpecEdit):
    """Air, or another medium, that slows all links, each by its size and speed.

    MuJoCo's fluid forces with the medium's density rho. A body counts as the box that has its inertia, with
    half-lengths r. Along the box's axis i, j and k being the other two, f_i = −2 rho r_j r_k |v_i| v_i and
    g_i = −½ rho r_i (r_j⁴ + r_k⁴) |w_i| w_i. A geom with ``fluidshape="ellipsoid"`` counts as an ellipsoid.

    Parameters (nominal = absent): density rho ≥ 0 [kg/m³], absent = the model's own in the file. Where the model
    declares its density, rho less the file's value is added to it.
    Limits: models in which some moving body has a size. The box stands for the link's shape, and its drag coefficient
    of 1 for the true one. So rho is the density of air only as far as these are right; an inertia that was given as a
    round number makes a wrong box.
    Source: MuJoCo 4.0, computation chapter ("Fluid forces"), option/density.

    Attributes:
        most: how far the density may lie above the model's own [kg/m³].
        sensitive: the medium counts as felt above this share of the forces of inertia and gravity.
        poses: number of states in which a force is looked for.
    """

    most: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "air_drag"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "f = -2 rho r_j r_k |v| v, per link"
    fingerprint: ClassVar[str] = "force residual against the motion that grows with the square of the links' speeds"
    confused_with: ClassVar[tuple[str, ...]] = ("quadratic_drag", "viscous_friction", "viscous_drag")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """``world``, if a denser medium changes a force."""
        denser = copy(model)
        denser.opt.density += self.most
        change = fluid_forces(denser, self.poses) - fluid_forces(model, self.poses)
        least = self.sensitive * np.abs(inverse_forces(model, self.poses)).max(initial=0.0)
        return ("world",) if np.abs(change).max(initial=0.0) > least else ()

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The density."""
        del site, scales
        own = float(model.opt.density)
        return (Parameter("density", "kg/m³", own, 0.0, own + self.most),)

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Note the file's own density."""
        note_own(spec, f"{self.name}@{site}", [spec.option.density])

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Change the density of the medium by what lies beyond the file's own; none is below 0."""
        (own,) = noted_own(spec, f"{self.name}@{site}")
        spec.option.density = max(spec.option.density + (values["density"] - float(own)), 0.0)
