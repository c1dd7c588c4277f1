"""Experiments tried on a fitted model: what its sensors would show, and how much of the machine's limits they take."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.experiment import Played, farthest, play
from dr_lab.diagnosis.next_experiment.limits import FORCE, POSITION, SPEED, TOUCH, close_pairs
from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Signal

STABLE = "a stable simulation"  # what a diverging experiment leaves
_FORCE = "force of actuator "


@dataclass(frozen=True)
class Trial:
    """Experiments as a fitted model plays them.

    Attributes:
        outputs: what the channels show at the fitted context, without noise, shape (w, m, raw size) by channel.
        excess: the largest share that a motion takes of any limit, in any context, ∞ where it diverges, shape (w,).
        worst: which limit that is, in words, w of them.
    """

    outputs: Mapping[str, Array]
    excess: Array
    worst: Sequence[str]


def watched(model: Model) -> Model:
    """The model with a sensor of each actuator's force behind its own sensors."""
    spec = model.spec.copy()
    for actuator in model.spec.actuators:
        spec.add_sensor(
            name=_FORCE + actuator.name,
            type=mujoco.mjtSensor.mjSENS_ACTUATORFRC,
            objtype=mujoco.mjtObj.mjOBJ_ACTUATOR,
            objname=actuator.name,
        )
    return replace(model, spec=spec)


def forces(model: Model, sensordata: Array) -> Array:
    """Forces of the actuators that a `watched` model had before any effect, shape (…, nsensordata) → (…, n)."""
    compiled = model.nominal()
    columns = [int(compiled.sensor(_FORCE + actuator.name).adr[0]) for actuator in model.spec.actuators]
    return sensordata[..., columns]


def tried(
    contender: Contender,
    z: Array,
    experiments: Sequence[Mapping[str, Signal]],
    machine: ExperimentMachine,
    looks: float,
) -> Trial:
    """Play experiments on a watched model in some contexts, the fitted one first.

    Args:
        contender: the model, which is `watched`.
        z: contexts, shape (c, n).
        experiments: commands by actuator.
        machine: what is kept.
        looks: s between two looks at the distances of parts.
    """
    duration = float(next(iter(experiments[0].values())).time[-1])
    channels = list(machine.noise)
    played = play(
        contender.model,
        z,
        machine.start,
        experiments,
        duration + farthest(contender.model, z, channels),
        machine.threads,
    )
    first = replace(played, z=z[:1], tape=_first(played), infeasible=played.infeasible[:1])
    shown = first.read(channels, machine.sample_times(duration))
    excess, worst = _excess(contender.model, played, machine, looks)
    return Trial({name: rows[0] for name, rows in shown.items()}, excess, worst)


def _first(played: Played) -> Tape:
    """The motion in the first context alone."""
    tape = played.tape
    parts = {name: getattr(tape, name)[:1] for name in ("qpos", "qvel", "sensordata", "start", "controls")}
    return replace(tape, **parts)


def _excess(model: Model, played: Played, machine: ExperimentMachine, looks: float) -> tuple[Array, list[str]]:
    """Largest share of a limit, and its name, by experiment."""
    tape, compiled = played.tape, model.nominal()
    taken = machine.kept.excess(tape.qpos, tape.qvel, forces(model, tape.sensordata), machine.start)
    if machine.clearance.pairs:
        every = max(1, round(looks / tape.step))
        begun = machine.clearance.distances(machine.start[None])[0]
        taken[TOUCH] = machine.kept.too_close(close_pairs(machine.clearance, tape.qpos[:, :, ::every]), begun)
    names = {
        POSITION: [f"the range of {_joint(compiled, q)}" for q in range(compiled.nq)],
        SPEED: [f"the speed of {compiled.joint(int(j)).name}" for j in compiled.dof_jntid],
        FORCE: [f"the force of {actuator.name}" for actuator in model.spec.actuators],
        TOUCH: [f"the distance of {a} from {b}" for a, b in machine.clearance.pairs],
    }
    shares = np.concatenate([taken[kind] for kind in taken], axis=2)
    every_name = [name for kind in taken for name in names[kind]]
    shares = np.where(played.infeasible[..., None] | ~np.isfinite(shares), np.inf, shares).max(axis=0)
    which = shares.argmax(axis=1)
    worst = [every_name[k] if np.isfinite(row[k]) else STABLE for k, row in zip(which, shares, strict=True)]
    return shares.max(axis=1), worst


def _joint(compiled: mujoco.MjModel, address: int) -> str:
    """Name of the joint that holds an entry of qpos."""
    return compiled.joint(int(np.flatnonzero(compiled.jnt_qposadr <= address)[-1])).name
