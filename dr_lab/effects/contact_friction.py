"""Ground or surfaces with another grip."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.contact_effect import ContactEffect
from dr_lab.effects.contact_pairs import dimension, explicit_pairs, meeting
from dr_lab.effects.effect import Scales
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

_SLIDING = 3  # from this dimension of a contact on it resists sliding


@dataclass(frozen=True)
class ContactFriction(ContactEffect, SpecEdit):
    """A body that slides more or less easily over what it touches.

    |f_t| ≤ s mu f_n: the sliding coefficients mu of all contacts of the body times a factor; torsional and rolling
    friction stay.

    Parameters (nominal = absent): factor s > 0, 1 = absent.
    Limits: bodies whose contacts resist sliding (condim 3 or more); felt only while a contact slides or is about to;
    flexes are left out. The exported file names the body's contacts as <pair>.
    Source: Coulomb's law; MuJoCo 4.0, modeling chapter ("Contact parameters"), contact/pair/friction.

    Attributes:
        low: smallest s.
        high: largest s.
        start_factors: s of the fits that start away from absent: a contact that sticks shows nothing of its limit.
    """

    low: float
    high: float
    start_factors: tuple[float, ...]

    name: ClassVar[str] = "contact_friction"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "|f_t| <= s mu f_n"
    fingerprint: ClassVar[str] = "residual begins where a contact slips, or should have"
    confused_with: ClassVar[tuple[str, ...]] = ("contact_stiffness",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the bodies whose contacts resist sliding."""
        dimensions = {
            name: max(dimension(model, pair) for pair in meeting(model, model.body(name).id))
            for name in super().sites(model)
        }
        return tuple(name for name, most in dimensions.items() if most >= _SLIDING)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The factor."""
        del model, site, scales
        return (Parameter("factor", "1", 1.0, self.low, self.high),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Scale the sliding coefficients of the body's contacts."""
        factor = values["factor"]
        for pair in explicit_pairs(spec, site):
            pair.friction = np.asarray(pair.friction) * [factor, factor, 1.0, 1.0, 1.0]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Several factors."""
        del parameters
        return tuple({"factor": factor} for factor in self.start_factors)
