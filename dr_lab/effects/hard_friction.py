"""Dry friction of the model's own that holds better than MuJoCo's default lets it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.dry_friction import Constraint, DryFriction
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

_JOINT = mujoco.MjSpec().worldbody.add_body().add_joint()
_SOLREF, _SOLIMP = _JOINT.solref_friction.copy(), _JOINT.solimp_friction.copy()  # MuJoCo's own


@dataclass(frozen=True)
class HardFriction(JointEffect, SpecEdit):
    """Friction loss of the model's own whose constraint is harder than MuJoCo's default, as dry friction is.

    At rest the speed decays as v' = (1 − d) a₀ − d b v, a₀ being the acceleration without friction, so that the joint
    creeps at (1 − d) a₀/(d b) under load. With softness s, 1 − d and 1/(d b) lie at the share s of the way from a
    constraint as hard as the integrator allows (`DryFriction`) to MuJoCo's defaults.

    Parameters (nominal = absent): softness s > 0 [1], absent = 1, MuJoCo's default.
    Limits: hinge and slide joints with friction loss of their own and the default constraint; what an author chose
    stays, and friction that an effect adds to a joint without any is hard already.
    Source: MuJoCo 4.0, computation chapter ("Friction loss") and modeling chapter (solver parameters).

    Attributes:
        constraint: how hard the hardest one is.
        default: MuJoCo's own constraint.
        hardest: smallest s.
        start: s of the fit that starts away from absent.
    """

    constraint: DryFriction
    default: Constraint
    hardest: float
    start: float

    name: ClassVar[str] = "hard_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -frictionloss sign(v); at rest it creeps s times as fast as by MuJoCo's default"
    fingerprint: ClassVar[str] = "the model creeps at rest where the machine sticks"
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "stribeck_friction", "asymmetric_friction")
    limited: ClassVar[tuple[str, ...]] = ("softness",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the joints with friction loss of their own, whose constraint nobody chose."""
        return tuple(name for name in super().sites(model) if _left_soft(model, int(model.joint(name).dofadr[0])))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """How soft the constraint is."""
        del model, site, scales
        return (Parameter("softness", "1", 1.0, self.hardest, 1.0),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Make the joint's constraint so hard; absent it stays exactly as it is."""
        joint, share = joint_of(spec, site), values["softness"]
        if share >= 1.0:
            return
        self.constraint.hardest(spec).softened(share, self.default).put(joint)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Friction that hardly creeps."""
        del parameters
        return ({"softness": self.start},)


def _left_soft(model: mujoco.MjModel, dof: int) -> bool:
    chosen = ((model.dof_solref[dof], _SOLREF), (model.dof_solimp[dof], _SOLIMP))
    return model.dof_frictionloss[dof] > 0 and all(np.array_equal(own, default) for own, default in chosen)
