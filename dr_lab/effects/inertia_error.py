"""A link whose mass is spread wider or narrower than the model says."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import moving_bodies, with_inertial
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.generalised_forces import inverse_forces
from dr_lab.physics.body_attributes import scale_inertia
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class InertiaError(Effect, SpecEdit):
    """A link's inertia about its centre of mass is off by a factor; its mass and centre are right.

    I → f I, the whole tensor, so that its axes and its physical consistency stay. Inertias that follow from geoms are
    written out as <inertial>.

    Parameters (nominal = absent): factor f > 0, 1 = absent.
    Limits: moving bodies with mass whose inertia a joint feels (a carriage that only slides is left out); the same as
    armature where the link turns about one fixed axis; models that let MuJoCo ignore <inertial> are refused.
    Raises: ModelError if the model's compiler has inertiafromgeom="true".
    Source: Newton–Euler equations; MuJoCo body/inertial.

    Attributes:
        low: smallest f.
        high: largest f.
        sensitive: a body's inertia counts as felt above this share of the forces of inertia and gravity.
        poses: number of states in which that is looked for.
    """

    low: float
    high: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "inertia_error"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "I -> f I about the centre of mass"
    fingerprint: ClassVar[str] = "force residual proportional to angular acceleration; swings too fast or too slow"
    confused_with: ClassVar[tuple[str, ...]] = ("armature", "payload", "centre_of_mass_offset")
    argument: ClassVar[str] = "inertia"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the moving bodies whose inertia a joint feels."""
        forces = inverse_forces(model, self.poses)
        least = self.sensitive * np.abs(forces).max(initial=0.0)
        felt = {name: np.abs(_wider(model, name, self.poses) - forces) for name in moving_bodies(model)}
        return tuple(name for name, change in felt.items() if change.max(initial=0.0) > least)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The factor."""
        del model, site, scales
        return (Parameter("factor", "1", 1.0, self.low, self.high),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Scale the inertia, in whichever form it stands."""
        factor = values["factor"]
        if factor != 1:
            scale_inertia(with_inertial(spec, site), factor)


def _wider(model: mujoco.MjModel, site: str, poses: int) -> np.ndarray:
    """Generalised forces with twice the body's inertia about its centre, shape (poses, nv)."""
    wider = copy(model)
    wider.body(site).inertia *= 2
    return inverse_forces(wider, poses)
