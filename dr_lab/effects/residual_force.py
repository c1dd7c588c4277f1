"""A force that nobody catalogued, learned from logs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.effects.learned_force import LearnedForce, read_learned_forces
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.radial_basis import Seen
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ResidualForce(JointEffect, ForceLaw):
    """A force at a joint that was learned from what a fitted model left of logs, as a smooth function of state.

    tau = factor · F(q, v, u), F being a `LearnedForce` of positions, velocities and commands, held through each step at
    the state in its middle. Where the logs show no such state, F is 0: the force fades with the distance.

    Parameters (nominal = absent): factor [1], 0 absent, 1 as learned.
    Limits: hinge and slide joints; a force that remembers, or depends on time, is none of the state. It has no name: it
    says that something is missing and how to simulate it, not what it is.
    Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapter 2, with inducing inputs.

    Attributes:
        most: largest factor.
        learned: the forces, by joint; none before anything was learned.
    """

    most: float
    learned: Mapping[str, LearnedForce] = field(default_factory=dict)

    name: ClassVar[str] = "residual_force"
    family: ClassVar[str] = "open"
    law: ClassVar[str] = "tau = factor F(q, v, u), learned"
    fingerprint: ClassVar[str] = "what is left is a function of state and command that no effect of the catalogue has"
    lacks: ClassVar[str] = (
        "the learned force from step to step; residual_force.json beside the file holds it with its law, and "
        "dr-lab compare model=from_run, as well as training with model@env.model=from_run, run it"
    )

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints at which a force was learned."""
        return tuple(joint for joint in super().sites(model) if joint in self.learned)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The size, as a share of what was learned."""
        del model, site, scales
        return (Parameter("factor", "1", 0.0, 0.0, self.most),)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """As learned."""
        return ({parameters[0].name: 1.0},)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        return _Learned(models[0], int(models[0].joint(site).dofadr[0]), self.learned[site], values["factor"])


def residual_force(most: float, run: str | None = None) -> ResidualForce:
    """The effect with what a run has learned, or with nothing yet.

    Args:
        most: largest factor.
        run: the run folder; None for none.
    """
    return ResidualForce(most, {} if run is None else read_learned_forces(run))


def learned_forces(model: Model) -> dict[str, LearnedForce]:
    """The learned forces of a model, by joint."""
    parts = [(each.site, each.effect) for each in model.effects]
    return {site: effect.learned[site] for site, effect in parts if isinstance(effect, ResidualForce)}


@dataclass(frozen=True)
class _Learned(Law):
    """The force times the factors, of shape (n,)."""

    model: mujoco.MjModel
    dof: int
    force: LearnedForce
    factor: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        if not np.any(self.factor):
            return
        seen = Seen(moment.qpos, moment.qvel, influence.control)
        influence.force[:, self.dof] += self.factor * self.force.of(self.model, seen)
