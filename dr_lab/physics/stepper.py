"""One step after the other, so that laws can act in between."""

from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.physics.law import CommandLaw, History, Influence, Law, Moment, MotionLaw
from dr_lab.trajectory import Array

# Fields of the model that laws change from step to step. MuJoCo takes the mass matrix of simple joints from dof_M0.
CHANGED = ("dof_frictionloss", "dof_armature", "dof_M0")
_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class Stepper:
    """Steps a batch whose contexts are per-simulation fields while laws act.

    What laws compute for a simulation that diverges may overflow or be no number. MuJoCo counts such simulations, and
    nobody uses them, so that numpy does not warn of it here.

    Args:
        batch: the simulations.
        compiled: their model.
        laws: the laws; those that change commands act first, and else all act in this order.
    """

    def __init__(self, batch: Batch, compiled: mujoco.MjModel, laws: Sequence[Law]) -> None:
        self._batch = batch
        self._laws = sorted(laws, key=lambda law: not isinstance(law, CommandLaw))
        self._with_encoders = [law for law in self._laws if law.reads_elsewhere]
        friction, armature, self._inertia = live = tuple(batch.expand(name) for name in CHANGED)
        self._own = tuple(values.copy() for values in live)  # without any law
        self._step = compiled.opt.timestep
        self._qpos, self._qvel, self._time = (batch.bind(name) for name in ("qpos", "qvel", "time"))
        # What laws write goes to MuJoCo without a copy.
        self._influence = Influence(batch.bind("ctrl"), batch.bind("qfrc_applied"), friction, armature)
        scalar = np.isin(compiled.jnt_type, _SCALAR)
        self._positions, self._dofs = _evenly(compiled.jnt_qposadr[scalar]), _evenly(compiled.jnt_dofadr[scalar])
        self._before = np.zeros((batch.nsim, compiled.nv))
        self._new = np.ones(batch.nsim, bool)
        # A field shows what a call computed only if it was bound before.
        self._computed = tuple(batch.bind(name) for name in ("qfrc_actuator", "qfrc_bias", "actuator_force"))
        self._forces = self._computed  # of the last step
        self._recalled: tuple[History, list[Array]] | None = None  # a history, and what laws remember of it

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Forget what came before in these simulations."""
        self._before[rows], self._new[rows] = 0.0, True
        for law in self._laws:
            law.rest(rows)

    @property
    def memory(self) -> tuple[Array, ...]:
        """What the steps before left behind: velocities, whether there were any, forces, and each law's memory."""
        own = (self._before.copy(), self._new.copy(), *(force.copy() for force in self._forces))
        return (*own, *(law.memory.copy() for law in self._laws))

    def restore(self, memory: Sequence[Array]) -> None:
        """Go on from the `memory` of a stepper with equal laws."""
        (self._before[:], self._new[:]), own = memory[:2], 2 + len(self._computed)
        self._forces = tuple(force.copy() for force in memory[2:own])
        for law, remembered in zip(self._laws, memory[own:], strict=True):
            law.remember(remembered)

    @np.errstate(over="ignore", invalid="ignore")
    def step(self, control: Array, begin: Array | float = 0.0) -> Array:
        """Advance all simulations by one step.

        Args:
            control: controls asked for, shape (nsim, nu).
            begin: s on the log's clock at which the simulations' own time is 0, shape (nsim,).

        Returns:
            Controls as MuJoCo got them.
        """
        self._act(control, begin)
        self._batch.step()
        self._forces = self._computed
        return self._influence.control

    def _act(self, control: Array, begin: Array | float) -> None:
        """Let the laws write what acts in the coming step."""
        influence, (friction, armature, inertia) = self._influence, self._own
        if self._new.any():
            self._meet(control)
        influence.control[:], influence.force[:] = control, 0.0
        influence.friction[:], influence.armature[:] = friction, armature
        moment = self._moment(begin)
        for law in self._laws:
            law.act(moment, influence)
        np.maximum(influence.friction, 0.0, out=influence.friction)
        np.subtract(influence.armature, armature, out=self._inertia)
        self._inertia += inertia

    def _meet(self, control: Array) -> None:
        """Compute the forces of simulations that no step before tells, and let their velocities have changed by 0."""
        self._influence.control[self._new] = control[self._new]
        self._batch.forward(self._new)
        for force, computed in zip(self._forces, self._computed, strict=True):
            if force is not computed:
                force[self._new] = computed[self._new]
        self._before[self._new] = self._qvel[self._new]
        self._new[:] = False

    @np.errstate(over="ignore", invalid="ignore")
    def rollout(self, controls: Array, record: Sequence[str], history: History | None, past: Array) -> dict[str, Array]:
        """Steps from the state that the simulations are in, under a series of controls.

        Args:
            controls: controls asked for, shape (nsim, s, nu); those that MuJoCo got take their place.
            record: names of the `MjData` fields to keep.
            history: what came before, of w windows; simulation i is that of window i mod w. None for nothing.
            past: controls before, as command filters leave them, shape (c or 1, w, p, nu); they reach back as far as
                the history, and laws see them in place of its own.

        Returns:
            The fields after every step, as `Batch.rollout` gives them, shape (nsim, s, …).
        """
        self.rest(np.arange(self._batch.nsim))
        self._influence.friction[:], self._influence.armature[:], self._inertia[:] = self._own
        begin: Array | float = 0.0
        if history is not None:
            begin = self._each(history.begin)
            self._remember(history, past, begin)
            for law in self._with_encoders:
                law.place_joints(self._qpos, self._qvel)
        fields = {name: self._batch.bind(name) for name in record}
        kept = {name: np.empty((len(field), controls.shape[1], *field.shape[1:])) for name, field in fields.items()}
        for k in range(controls.shape[1]):
            controls[:, k] = self.step(controls[:, k], begin)
            if k:
                self._read_encoders(kept, k - 1)  # laws have just ended the step before
            for name, field in fields.items():
                kept[name][:, k] = field
        if self._with_encoders:
            self._act(controls[:, -1].copy(), begin)
            self._read_encoders(kept, controls.shape[1] - 1)
        return kept

    def _read_encoders(self, kept: dict[str, Array], k: int) -> None:
        """Let the record of a step hold what encoders read after it."""
        for law in self._with_encoders:
            law.read_encoders(kept["qpos"][:, k], kept["qvel"][:, k])

    def _remember(self, history: History, past: Array, begin: Array) -> None:
        """Let laws remember what was measured before: it is recalled once, however many states begin there."""
        if not any(law.remembers for law in self._laws):
            return
        if self._recalled is None or self._recalled[0] is not history:
            self._recall(history, past, begin)
            self._recalled = (history, [law.memory.copy() for law in self._laws])
        for law, memory in zip(self._laws, self._recalled[1], strict=True):
            law.remember(memory.copy())

    def _recall(self, history: History, past: Array, begin: Array) -> None:
        """Let laws that remember see what was measured before, behind the others; what they do has no effect then."""
        stepwise = list[Law]()
        for law in self._laws:
            if isinstance(law, MotionLaw):
                if law.looks_far and history.far.shape[1]:
                    law.follow(self._each(history.far), history.interval)
                law.follow(self._each(history.qvel), self._step)
            else:
                stepwise.append(law)
        if any(law.remembers for law in stepwise):
            self._recall_stepwise(stepwise, history, past, begin)

    def _recall_stepwise(self, laws: Sequence[Law], history: History, past: Array, begin: Array) -> None:
        count, (friction, armature, _) = history.qpos.shape[1], self._own
        still = np.zeros_like(friction)
        for k in range(count):
            time = begin + (k - count + 0.5) * self._step
            qpos, qvel = self._each(history.qpos[:, k]), self._each(history.qvel[:, k])
            gained = qvel - self._each(history.qvel[:, max(k - 1, 0)])
            control = self._each(np.concatenate(past[:, :, past.shape[2] - count + k]))
            influence = Influence(control, np.zeros_like(friction), friction.copy(), armature.copy())
            moment = Moment(self._step, time, qpos, qvel, gained, still, still)
            for law in laws:
                law.replay_history(moment, influence)

    def _each(self, rows: Array) -> Array:
        """Rows of w windows for all simulations."""
        return np.tile(rows, (self._batch.nsim // len(rows), *[1] * (rows.ndim - 1)))

    def _moment(self, begin: Array | float) -> Moment:
        half, qpos, qvel = self._step / 2, self._qpos.copy(), self._qvel.copy()
        change = qvel - self._before
        self._before[:] = qvel
        qpos[:, self._positions] += half * (qvel + change / 4)[:, self._dofs]
        return Moment(
            step=self._step,
            time=self._time + (begin + half),
            qpos=qpos,
            qvel=qvel + change / 2,
            gained=change,
            actuation=self._forces[0],
            bias=self._forces[1],
            outputs=self._forces[2],
        )


def _evenly(places: NDArray[np.intp]) -> NDArray[np.intp] | slice:
    """Places as a slice where they follow one another, which numpy reads without a copy."""
    follow = len(places) > 0 and bool((np.diff(places) == 1).all())
    return slice(int(places[0]), int(places[-1]) + 1) if follow else places
