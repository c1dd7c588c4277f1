"""Which series is which actuator's command, with which sign and in which unit, by what the motion needed."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.measurements.units import unit as unit_of
from dr_lab.proposal.by_name import matches, said_of
from dr_lab.proposal.command_units import factors, unit_by_gain
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Given, Outcome
from dr_lab.proposal.words import electric_unit
from dr_lab.trajectory import Array

BY_NAME = "sign and unit are by its name alone."  # what is unsure of a command that the motion hardly shows
_POSITIONS = ("rad", "m")  # SI units of controls that ask for a position
_VELOCITIES = ("rad/s", "m/s")  # units of controls that ask for a velocity


@dataclass(frozen=True)
class Drive:
    """An actuator that a series may command.

    Attributes:
        name: of the actuator, or of one that is to be added.
        dof: degree of freedom that it moves most.
        joint: name of that joint.
        unit: SI unit of its control; 1 where the model does not say it, as of a motor with a gear.
        force: joint force per unit of control, N·m or N.
        servo: whether its control is a position.
        added: whether the model lacks it.
        slides: whether the joint's force is one in N.
    """

    name: str
    dof: int
    joint: str
    unit: str
    force: float
    servo: bool
    added: bool
    slides: bool

    @property
    def rate(self) -> bool:
        """Whether its control is a velocity."""
        return self.unit in _VELOCITIES

    @property
    def told(self) -> str:
        """What 1 of a control without a unit does, as the end of a sentence; empty of others."""
        return f"; 1 of ctrl is {self.force:.3g} {'N' if self.slides else 'N·m'}" if self.unit == "1" else ""


@dataclass(frozen=True)
class Command:
    """A proposed command.

    Attributes:
        drive: the actuator.
        series: what holds it.
        given: what it does; None where that could not be tried.
        unit: of its numbers.
        sign: +1 or −1.
        scale: factor into the unit.
        offset: in the unit.
        seen: whether the motion shows sign and unit.
        why: what speaks for it.
        doubts: what is unsure, a sentence each.
    """

    drive: Drive
    series: Series
    given: Given | None
    unit: str
    sign: int
    scale: float
    offset: float
    seen: bool
    why: str
    doubts: tuple[str, ...]


def drives_of(model: mujoco.MjModel, force: Array) -> tuple[Drive, ...]:
    """The actuators of a model with one control, or, without any, a motor at every hinge and slide that might be there.

    Args:
        model: compiled.
        force: joint force per unit of control, shape (nu, nv).
    """
    if model.nu == 0:
        return tuple(
            Drive(name, dof, name, "N" if slides else "N·m", 1.0, servo=False, added=True, slides=slides)
            for dof, slides in ((dof, _slides(model, dof)) for dof in range(model.nv))
            if (name := _joint(model, dof))
        )
    found = []
    for k in map(int, np.flatnonzero(model.actuator_ctrlnum == 1)):
        acting = force[model.actuator_ctrladr[k]]
        dof = int(np.argmax(np.abs(acting))) if model.nv else 0
        unit, servo = _control(model, k, dof)
        name, joint, slides = model.actuator(k).name, _joint(model, dof), _slides(model, dof)
        found.append(Drive(name, dof, joint, unit, float(acting[dof]), servo, added=False, slides=slides))
    return tuple(found)


def choose_commands(
    drives: Sequence[Drive],
    series: Sequence[Series],
    usable: Collection[int],
    outcome: Outcome,
    settings: ProposalSettings,
) -> tuple[Command, ...]:
    """Give every actuator the series that explains its joint's motion best, each series to one actuator.

    Of series that explain it about as well, a measured one goes before one that is asked for.

    Args:
        drives: actuators.
        series: the drives of the trial.
        usable: those of them that may be commands, as places.
        outcome: the chosen reading of the positions, tried.
        settings: which share a command must explain.
    """
    named, said = _named(drives, series)
    offers = []
    for k, drive in enumerate(drives):
        mine = {*named[k]} & {*usable}
        allowed = [given for given in outcome.given[drive.dof] if given.series in mine and _fits(drive, given, series)]
        least = min((given.left for given in allowed), default=0.0)
        for given in allowed:
            equal = explains(given, drive, outcome, settings) and given.left <= settings.near * least + settings.close
            rank = (series[given.series].words.asked, given.stiffness > 0) if equal else (True, True)
            offers.append((not equal, *rank, given.left, k, given))
    commanding = {k for k in usable if series[k].words.kind in ("drive", "reference", "asked velocity")}
    chosen: dict[int, Given] = {}
    for *_, k, given in sorted(offers, key=lambda offer: offer[:4]):
        explained = explains(given, drives[k], outcome, settings)
        alone = len([place for place in {*named[k]} & commanding if _takes(drives[k], series[place])]) == 1
        # One of several joints gets no actuator for a series that does not speak of it: it may be another joint's.
        alone &= not drives[k].added or given.series in said or len(drives) == 1
        if k not in chosen and (explained or alone) and given.series not in {g.series for g in chosen.values()}:
            chosen[k] = given
    return tuple(_command(drives[k], series, chosen[k], outcome, settings) for k in sorted(chosen))


def commands_by_name(drives: Sequence[Drive], series: Sequence[Series]) -> tuple[Command, ...]:
    """Commands where only names tell: of actuators that there are, and of motors that are to be added.

    Where names say what some command, those that say nothing command none.
    """
    found = []
    named, said = _named(drives, series)
    for drive, places in zip(drives, named, strict=True):
        mine = [series[k] for k in places if k in said or not said]
        fitting = [each for each in mine if (each.words.kind == "drive" if drive.added else _takes(drive, each))]
        measured = [each for each in fitting if not each.words.asked] or fitting
        if len(measured) == 1:
            unit, why = measured[0].words.unit or drive.unit, f"by its name{drive.told}"
            found.append(Command(drive, measured[0], None, unit, 1, 1.0, 0.0, seen=False, why=why, doubts=()))
    return tuple(found)


def explains(given: Given, drive: Drive, outcome: Outcome, settings: ProposalSettings) -> bool:
    """Whether a series takes away most of what its joint leaves without it."""
    return given.left <= (1 - settings.explained) * float(outcome.idle[drive.dof])


def _fits(drive: Drive, given: Given, series: Sequence[Series]) -> bool:
    """A servo takes positions, a motor forces; a name that says nothing may be either."""
    words = series[given.series].words
    if not _takes(drive, series[given.series]):
        return False
    if drive.added:
        return words.kind != "drive" if given.stiffness > 0 else unit_of(words.unit or "1").name not in _POSITIONS
    return given.stiffness == 0 and not (drive.servo and words.kind == "drive")


def _takes(drive: Drive, series: Series) -> bool:
    """Whether a series may command an actuator.

    A velocity that is asked for moves velocity servos alone, and a force, as of a load cell, drives no hinge.
    """
    force = series.words.unit and unit_of(series.words.unit).name == "N"
    return (drive.rate or series.words.kind != "asked velocity") and not (force and drive.unit == "N·m")


def _named(drives: Sequence[Drive], series: Sequence[Series]) -> tuple[list[list[int]], set[int]]:
    """The series that each actuator's name may mean, and those that share words with one, as places."""
    names = [drive.joint if drive.added else drive.name for drive in drives]
    return matches(names, series), said_of(names, series)


def _command(
    drive: Drive, series: Sequence[Series], given: Given, outcome: Outcome, settings: ProposalSettings
) -> Command:
    idle, mine, servo = float(outcome.idle[drive.dof]), series[given.series], given.stiffness > 0
    base = drive.unit if not servo else ("m" if drive.unit == "N" else "rad")
    gain = given.gain / (given.stiffness if servo else drive.force)
    said = mine.words.unit or electric_unit(mine.place.path, base)
    unit, scale, doubts = unit_by_gain(gain, base, said, settings, stated=servo or not drive.added)
    explained = 1 - given.left / max(idle, np.finfo(float).tiny)
    late = f", {1e3 * given.lag:.0f} ms late" if given.lag else ""
    beside = gain / (scale * factors(base, said).get(unit, 1.0))  # what unit and scale leave of it
    why = f"explains {max(explained, 0.0):.0%} of what {drive.joint} needs{late}; gain {beside:.2g}{drive.told}"
    if explained < settings.explained:
        doubts = _unexplained(drive, mine, given, max(explained, 0.0))
        unit, why = mine.words.unit or base, f"by its name{drive.told}"
        return Command(drive, mine, given, unit, 1, 1.0, 0.0, seen=False, why=why, doubts=doubts)
    sign = 1 if gain > 0 else -1
    return Command(drive, mine, given, unit, sign, scale, 0.0, seen=True, why=why, doubts=tuple(doubts))


def _unexplained(drive: Drive, series: Series, given: Given, explained: float) -> tuple[str, ...]:
    """What is unsure about a command that explains little of its joint's motion."""
    little = f"{series.place} explains {explained:.0%} of what {drive.joint} needs."
    if given.stiffness == 0:
        return (little, BY_NAME)
    return (
        little,
        BY_NAME,
        f"the servo's gains, kp {given.stiffness:.3g} and kv {given.damping:.3g}, are a guess, as the motion hardly "
        f"shows them. Write its own into the model, or free actuator.{drive.name}.kp and .kv as parameters.",
    )


def integrates(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Which actuators act by the integral of their control, as an ``intvelocity`` does, shape (actuators,)."""
    return model.actuator_dyntype == int(mujoco.mjtDyn.mjDYN_INTEGRATOR)


def _control(model: mujoco.MjModel, k: int, dof: int) -> tuple[str, bool]:
    """SI unit of an actuator's control, 1 where that may be any, and whether it is a position."""
    slide = _slides(model, dof)
    if int(model.actuator_gaintype[k]) == int(mujoco.mjtGain.mjGAIN_DCMOTOR):
        return "V", False
    gain, (_, stiffness, damping) = model.actuator_gainprm[k, 0], model.actuator_biasprm[k, :3]
    servo = stiffness < 0 and math.isclose(gain, -stiffness)
    if servo and not integrates(model)[k]:
        return ("m" if slide else "rad"), True
    if servo or (stiffness == 0 and damping < 0 and math.isclose(gain, -damping)):
        return ("m/s" if slide else "rad/s"), False
    if int(model.actuator_biastype[k]) == int(mujoco.mjtBias.mjBIAS_NONE) and gain == 1.0 and not _geared(model, k):
        return ("N" if slide else "N·m"), False
    return "1", False


def _geared(model: mujoco.MjModel, k: int) -> bool:
    """Whether an actuator's gear makes another force of it, or another torque where it has no force."""
    force, torque = np.split(model.actuator_gear[k], 2)
    return not math.isclose(float(np.linalg.norm(force if force.any() else torque)), 1.0)


def _slides(model: mujoco.MjModel, dof: int) -> bool:
    """Whether a degree of freedom is a way: a slide's, or one of the first three of a free body."""
    joint = int(model.dof_jntid[dof])
    free = int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_FREE) and dof - int(model.jnt_dofadr[joint]) < 3
    return free or int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def _joint(model: mujoco.MjModel, dof: int) -> str:
    return model.joint(int(model.dof_jntid[dof])).name
