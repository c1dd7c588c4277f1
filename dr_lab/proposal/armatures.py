"""Armatures that are free where a command acts more or less strongly than the model's inertia lets it.

Of a rotor that a motor drives and dampers brake, inertia, damping and the motor's gain are known only up to one factor:
I q'' + b q' = g u is (I/g) q'' + (b/g) q' = u. The gain stays as documented; dampings are free, so that the inertia
must be, too.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.measurements.units import unit
from dr_lab.proposal.drives import Command
from dr_lab.proposal.output import Positions
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.trajectory import Array

_DIGITS = 2  # of bounds


@dataclass(frozen=True)
class Armature:
    """An armature that makes the ratio of force to inertia free.

    Attributes:
        joint: name.
        body: that it moves.
        low, high: kg·m² or kg.
        slides: whether it is in kg.
        note: why it is free, a sentence.
    """

    joint: str
    body: str
    low: float
    high: float
    slides: bool
    note: str

    @property
    def entry(self) -> dict[str, str | float]:
        """As a model's yaml declares it."""
        target = f"joint.{self.joint}.armature"
        return {"target": target, "unit": "kg" if self.slides else "kg·m²", "low": self.low, "high": self.high}


def armatures(
    model: mujoco.MjModel,
    bodies: Collection[str],
    found: Positions,
    commands: Sequence[Command],
    settings: ProposalSettings,
) -> Iterator[Armature]:
    """The armatures that stand in for masses that are not seen, where commands act with a gain that is not 1.

    Args:
        model: compiled, with the actuators that were added.
        bodies: whose inertia stays as documented, as hardly a force follows from it.
        found: the motion.
        commands: of the actuators.
        settings: how far a gain must be off, and how wide bounds are.
    """
    inertia, largest = _inertia(model), _largest(found)
    for command in commands:
        dof, given = command.drive.dof, command.given
        body = model.body(int(model.dof_bodyid[dof])).name
        if given is None or given.stiffness > 0 or command.drive.servo or not command.seen:
            continue
        size = command.drive.force * command.sign * command.scale * unit(command.unit).factor
        gain, std = given.gain / size, given.gain_std / abs(size)
        if body not in bodies or gain <= 0 or abs(gain - 1) < max(settings.gain_off, settings.certain * std):
            continue
        documented = float(model.dof_armature[dof])
        beside = float(inertia[dof]) - documented
        seen = (float(inertia[dof]) + given.rotor) / gain
        low, high = seen / settings.spread - beside, max(seen * settings.spread, largest[dof] / gain) - beside
        if high > documented:
            low, high = (float(f"{value:.{_DIGITS}g}") for value in (max(low, 0.0), high))
            low, high = min(low, documented), max(high, documented)
            yield Armature(command.drive.joint, body, low, high, command.drive.slides, _note(command, gain, std))


def _note(command: Command, gain: float, std: float) -> str:
    joint = command.drive.joint
    return (
        f"{joint}.armature is free: {command.drive.name} moves {joint} {gain:.2g} ± {std:.1g} times as strongly as the "
        "model would. Of its inertia, its damping and the command's force one stays as documented, as a motion shows "
        "them only up to one factor: the force."
    )


def _largest(found: Positions) -> Array:
    """Inertias that would take all that the joints need at their usual accelerations, shape (nv,)."""
    assert found.trial is not None
    assert found.found is not None
    motion = found.trial.motion(found.found.readings)
    need, speeding = found.found.outcome.need, found.trial.grid.weak.project(motion.qacc)
    size = np.sqrt((speeding**2).mean(0))
    return np.sqrt((need**2).mean(0)) / np.where(size > 0, size, np.inf)


def _inertia(model: mujoco.MjModel) -> Array:
    """Of each degree of freedom alone at the reference, shape (nv,)."""
    data, whole = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, whole)
    return np.diag(whole).copy()
