"""What an experiment must not leave: ranges, speeds and forces, and that nothing touches what it did not touch."""

from dataclasses import dataclass
from typing import Annotated

import mujoco
import numpy as np

from dr_lab.bounds import Natural, NotNegative, Positive, Share, at_least, below, require_bounds
from dr_lab.diagnosis.next_experiment.clearance import Clearance
from dr_lab.trajectory import Array

POSITION, SPEED, FORCE, TOUCH = "position", "speed", "force", "clearance"
KINDS = (POSITION, SPEED, FORCE, TOUCH)


@dataclass(frozen=True)
class Safety:
    """How far experiments keep from where harm may be.

    Attributes:
        margin: by how much an experiment may go beyond the logs' motion where the model declares no limit: this share
            of a joint's range to either side, of the largest speed, force and command.
        reserve: share of every limit that the simulated motion leaves free, for what the models do not know.
        give: share of a joint's range by which a machine may press on the end of it at which it rests.
        clearance: m, that parts keep from each other which the logs do not show closer; simulated motions keep twice
            of it.
        as_close: share of the logs' smallest distance of two parts, to which simulated motions may bring them.
        touching: the same, below which a motion is said to touch.
        draws: contexts drawn from each fit's uncertainty in which the motion must keep its limits as well.
        spread: standard deviations of the fit for one of the draws.
    """

    margin: NotNegative
    reserve: Annotated[float, at_least(0.0), below(0.9)]
    give: Annotated[float, at_least(0.0), below(0.1)]
    clearance: Positive
    as_close: Share
    touching: Share
    draws: Natural
    spread: NotNegative

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment.safety")


@dataclass(frozen=True)
class Shown:
    """What the machine did in its logs.

    Attributes:
        low: lowest positions, shape (nq,).
        high: highest positions, shape (nq,).
        speed: largest |velocity|, shape (nv,).
        force: largest |force| of each actuator, shape (nactuator,).
        distance: smallest distance of each pair of parts, at most the reach of its `Clearance`, m, shape (pairs,).
    """

    low: Array
    high: Array
    speed: Array
    force: Array
    distance: Array


@dataclass(frozen=True)
class Limits:
    """What no experiment may leave.

    Attributes:
        low: lowest position, −∞ where nothing bounds it, shape (nq,).
        high: highest position, shape (nq,).
        speed: largest |velocity|, shape (nv,).
        force: lowest and highest force of each actuator, shape (2, nactuator).
        certain: actuators whose force is known from the command alone, shape (nactuator,).
        distance: least distance of each pair of parts, −∞ for those that touched in the logs, m, shape (pairs,).
    """

    low: Array
    high: Array
    speed: Array
    force: Array
    certain: Array
    distance: Array

    @classmethod
    def of(cls, model: mujoco.MjModel, shown: Shown, safety: Safety) -> "Limits":
        """The model's own limits where it declares them, else what the logs showed and a margin."""
        span = safety.margin * (shown.high - shown.low)
        low, high = shown.low - span, shown.high + span
        for joint in range(model.njnt):
            where = int(model.jnt_qposadr[joint])
            if int(model.jnt_type[joint]) not in _SCALAR:
                width = 7 if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_FREE) else 4
                low[where : where + width], high[where : where + width] = -np.inf, np.inf
            elif model.jnt_limited[joint]:
                low[where], high[where] = model.jnt_range[joint]
        speed, most = (1 + safety.margin) * shown.speed, (1 + safety.margin) * shown.force
        certain = model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_NONE)
        return cls(
            low, high, speed, _forces(model, most), certain, closest(shown.distance, safety.clearance, safety.touching)
        )

    def within(self, safety: Safety, start: Array, shown: Shown) -> "Limits":
        """The limits that a simulated motion keeps: a reserve stays free, but for where the experiment starts.

        At the end of its range, or a little beyond, a machine leans on a stop that gives: as far as it may press on it.
        """
        span = np.where(np.isfinite(self.high - self.low), self.high - self.low, 0.0)
        free, room, keep = safety.reserve * span, safety.give * span, 1 - safety.reserve
        return Limits(
            low=np.minimum.reduce([self.low + free, (self.low + 2 * start) / 3, start - room]),
            high=np.maximum.reduce([self.high - free, (self.high + 2 * start) / 3, start + room]),
            speed=keep * self.speed,
            force=np.where(self.certain, 1.0, keep) * self.force,
            certain=self.certain,
            distance=closest(shown.distance, 2 * safety.clearance, safety.as_close),
        )

    def excess(self, qpos: Array, qvel: Array, force: Array, start: Array) -> dict[str, Array]:
        """How much of each limit a motion takes by kind, 1 for all of it, the largest over time.

        Args:
            qpos: positions, shape (…, s, nq).
            qvel: velocities, shape (…, s, nv).
            force: actuator forces, shape (…, s, nactuator).
            start: positions at which it starts, shape (nq,).

        Returns:
            Position, speed and force by element, shapes (…, nq), (…, nv) and (…, nactuator).
        """
        tiny = np.finfo(float).tiny
        up = (qpos.max(axis=-2) - start) / np.maximum(self.high - start, tiny)
        down = (start - qpos.min(axis=-2)) / np.maximum(start - self.low, tiny)
        speed = np.abs(qvel).max(axis=-2) / np.maximum(self.speed, tiny)
        push = force.max(axis=-2) / np.maximum(self.force[1], tiny)
        pull = force.min(axis=-2) / np.minimum(self.force[0], -tiny)
        return {POSITION: np.maximum(up, down), SPEED: speed, FORCE: np.maximum(push, pull)}

    def too_close(self, distance: Array, start: Array) -> Array:
        """The same of distances: how much of what lies between a pair's at the start and its least a motion takes.

        Args:
            distance: smallest along motions, m, shape (…, pairs).
            start: where they start, m, shape (pairs,).

        Returns:
            Shape (…, pairs); above 1 for pairs that start closer than they may come.
        """
        kept, tiny = np.isfinite(self.distance), np.finfo(float).tiny
        least = np.where(kept, self.distance, 0.0)
        share = (start - distance) / np.maximum(start - least, tiny)
        share = np.where(start < least, 1 + (least - distance) / np.maximum(least, tiny), share)
        return np.where(kept, share, 0.0)


_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def closest(shown: Array, clearance: float, near: float) -> Array:
    """Least distances: the clearance, or a share of the logs' where that is less; −∞ where the logs touched."""
    return np.where(shown > 0, np.minimum(clearance, near * shown), -np.inf)


def _forces(model: mujoco.MjModel, most: Array) -> Array:
    """Lowest and highest force of each actuator, shape (2, nactuator)."""
    found = np.stack([-most, most])
    for i in range(model.nactuator):
        joint = int(model.actuator_trnid[i, 0])
        if model.actuator_forcelimited[i]:
            found[:, i] = model.actuator_forcerange[i]
        elif int(model.actuator_trntype[i]) == int(mujoco.mjtTrn.mjTRN_JOINT) and model.jnt_actfrclimited[joint]:
            ends = model.jnt_actfrcrange[joint] / model.actuator_gear[i, 0]
            found[:, i] = ends.min(), ends.max()
    return found


def close_pairs(clearance: Clearance, qpos: Array) -> Array:
    """Smallest distance of every pair along motions, shape (…, s, nq) → (…, pairs)."""
    found = clearance.distances(qpos.reshape(-1, qpos.shape[-1]))
    return found.reshape(*qpos.shape[:-1], -1).min(axis=-2)
