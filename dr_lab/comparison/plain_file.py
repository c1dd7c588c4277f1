"""What MuJoCo alone makes of an exported file: what stands in for what MJCF lacks, and how well it predicts."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import mujoco

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.score import score_of
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.quantity import number
from dr_lab.trajectory import Array

EXPORT = "export"  # kind of the notes on what a written model lacks
_COULOMB, _TORQUE = "coulomb_friction", "torque"
_LAG, _TAU = "actuator_lag", "tau"


class StandIn(Protocol):
    """What comes near to an effect that MJCF lacks."""

    @property
    def told(self) -> str:
        """A sentence for the file and the report."""
        ...

    def write(self, spec: mujoco.MjSpec) -> None:
        """Put it into the file."""
        ...


@dataclass(frozen=True)
class DryFrictionLoss:
    """The dry friction that comes nearest to an effect that MJCF lacks.

    Attributes:
        effect: its label.
        joint: name.
        loss: what it adds to the joint's friction loss, N·m or N.
    """

    effect: str
    joint: str
    loss: float

    @property
    def told(self) -> str:
        """A sentence for the file and the report."""
        return f"In place of {self.effect} model.xml adds {self.loss:.4g} to the frictionloss of {self.joint}."

    def write(self, spec: mujoco.MjSpec) -> None:
        """Add it to the joint."""
        joint = spec.joint(self.joint)
        joint.frictionloss = joint.frictionloss + self.loss


@dataclass(frozen=True)
class CommandFilter:
    """MuJoCo's filter of a command, which acts later than the lag: half a step, and about one with RK4.

    Attributes:
        effect: its label.
        actuator: name.
        tau: time constant, s.
    """

    effect: str
    actuator: str
    tau: float

    @property
    def told(self) -> str:
        """A sentence for the file and the report."""
        return (
            f'In place of {self.effect} model.xml gives {self.actuator} dyntype="filterexact" with {self.tau:.4g} s, '
            "which acts up to a time step later."
        )

    def write(self, spec: mujoco.MjSpec) -> None:
        """Let the actuator's command through it."""
        actuator = spec.actuator(self.actuator)
        actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
        actuator.dynprm[0] = self.tau


def stand_ins(model: Model, z: Array) -> list[StandIn]:
    """What stands in for the effects that MJCF lacks, at context z, where something comes near."""
    return [*_frictions(model, z), *_filters(model, z)]


def _filters(model: Model, z: Array) -> list[CommandFilter]:
    """Filters for lags of more than a time step; an actuator that already has a memory keeps that."""
    values, least = model.space.mapping(z), model.spec.option.timestep
    free = {each.name for each in model.spec.actuators if each.dyntype == mujoco.mjtDyn.mjDYN_NONE}
    lags = [each for each in model.effects if isinstance(each, PlacedEffect) and each.effect.name == _LAG]
    found = (CommandFilter(lag.label, name, lag.local(values)[_TAU]) for lag in lags for name in lag.elements)
    return [each for each in found if each.actuator in free and each.tau > least]


def _frictions(model: Model, z: Array) -> list[DryFrictionLoss]:
    """Dry friction for every effect that holds it as a special case and that MJCF lacks."""
    values, found = model.space.mapping(z), list[DryFrictionLoss]()
    for placed in model.effects:
        if not (isinstance(placed, PlacedEffect) and placed.effect.lacks and _COULOMB in placed.effect.holds):
            continue
        own, same = placed.local(values), placed.effect.holds[_COULOMB].same
        torque = sum(own[name] for name, poorer in same.items() if poorer == _TORQUE)
        found += [DryFrictionLoss(placed.label, joint, torque) for joint in placed.elements if torque > 0]
    return found


def file_note(study: Study, path: Path, found: Model, chi2: float | None) -> NoteEntry:
    """How well a file predicts that lacks something of a model, played by MuJoCo alone from fitted starts.

    Args:
        study: the logs.
        path: the file.
        found: the model; its effects on sensors, which no model file has, act beside the file.
        chi2: what the model leaves.
    """
    sensing = tuple(e for e in found.effects if isinstance(e, PlacedEffect) and e.effect.family == "sensing")
    alone = replace(found, spec=mujoco.MjSpec.from_file(str(path)), effects=sensing)
    bench = study.bench
    score = score_of(*fit_states(alone, alone.space.nominal, bench.held_out, bench.solver, bench.threads))
    message = (
        f"Played by MuJoCo alone, model.xml leaves χ² {number(score.chi2)}, the model found {number(chi2)}. "
        "model=from_run model.run=RUN has all of it, in every verb of dr-lab."
    )
    return NoteEntry(message, EXPORT)
