"""Ground or surfaces that give way and throw back otherwise."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco

from dr_lab.effects.contact_effect import ContactEffect
from dr_lab.effects.contact_pairs import explicit_pairs, meeting, reference
from dr_lab.effects.effect import Scales
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class ContactStiffness(ContactEffect, SpecEdit):
    """A softer, harder, livelier or deader contact of a body with what it touches.

    MuJoCo lets the penetration r of a contact behave as r'' + 2 r'/T + r/(T zeta)² = 0, with time constant T and
    damping ratio zeta (``solref``); T → a T and zeta → b zeta for all contacts of the body. In the direct form
    (−stiffness, −damping): stiffness/(a b)², damping/a. Below zeta = 1 a contact throws back. At rest, a constant force
    presses in by T² zeta² (1 − d) times its acceleration, d being the impedance.

    Parameters (nominal = absent): time_constant a > 0 and damping_ratio b > 0, shares of the model's own, 1 = absent.
    Limits: bodies whose geoms may touch others, flexes left out; T is at least two time steps (MuJoCo). The exported
    file names the body's contacts as <pair>.
    Source: MuJoCo 4.0, modeling chapter ("Solver parameters", "Contact parameters"), contact/pair/solref.

    Attributes:
        low: smallest a and b (a is never below what two time steps allow).
        high: largest a and b.
    """

    low: float
    high: float

    name: ClassVar[str] = "contact_stiffness"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "r'' + 2 r'/(a T) + r/(a T b zeta)^2 = 0 in contact"
    fingerprint: ClassVar[str] = "residual begins at an impact: the body rebounds or sinks in by another amount"
    limited: ClassVar[tuple[str, ...]] = ("time_constant",)
    confused_with: ClassVar[tuple[str, ...]] = ("contact_friction",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The shares of the time constant and of the damping ratio."""
        del scales
        own = [float(reference(model, pair)[0]) for pair in meeting(model, model.body(site).id)]
        least = 2 * float(model.opt.timestep) / min((value for value in own if value > 0), default=float("inf"))
        return (
            Parameter("time_constant", "1", 1.0, min(max(self.low, least), 1.0), self.high),
            Parameter("damping_ratio", "1", 1.0, self.low, self.high),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Scale the solver reference of the body's contacts."""
        slower, deader = values["time_constant"], values["damping_ratio"]
        for pair in explicit_pairs(spec, site):
            pair.solref = _scaled(pair.solref, slower, deader)


def _scaled(solref: Any, slower: float, deader: float) -> list[float]:  # noqa: ANN401 (MuJoCo's array)
    first, second = map(float, solref)
    if first > 0:
        return [slower * first, deader * second]
    return [first / (slower * deader) ** 2, second / slower]
