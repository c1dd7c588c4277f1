"""One step after the other, so that laws can act in between."""

from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.physics.law import History, Influence, Law, Moment
from dr_lab.trajectory import Array

# Fields of the model that laws change from step to step. MuJoCo takes the mass matrix of simple joints from dof_M0.
CHANGED = ("dof_frictionloss", "dof_armature", "dof_M0")
_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class Stepper:
    """Steps a batch whose contexts are per-simulation fields while laws act.

    Args:
        batch: the simulations.
        compiled: their model.
        laws: the laws, in the order in which they act.
    """

    def __init__(self, batch: Batch, compiled: mujoco.MjModel, laws: Sequence[Law]) -> None:
        self._batch = batch
        self._laws = laws
        self._friction, self._armature, self._inertia = (batch.expand(name).copy() for name in CHANGED)
        self._step = compiled.opt.timestep
        scalar = np.isin(compiled.jnt_type, _SCALAR)
        self._positions, self._dofs = compiled.jnt_qposadr[scalar], compiled.jnt_dofadr[scalar]
        self._before = np.full((batch.nsim, compiled.nv), np.nan)
        self._new = np.ones(batch.nsim, bool)
        # A field shows what a call computed only if it was bound before.
        self._computed = (batch.bind("qfrc_actuator"), batch.bind("qfrc_bias"))
        self._forces = self._computed  # of the last step

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Forget what came before in these simulations."""
        self._before[rows], self._new[rows] = np.nan, True
        for law in self._laws:
            law.rest(rows)

    @property
    def memory(self) -> tuple[Array, ...]:
        """What the steps before left behind: velocities, whether there were any, forces, and each law's memory."""
        actuation, bias = self._forces
        own = (self._before.copy(), self._new.copy(), actuation.copy(), bias.copy())
        return (*own, *(law.memory.copy() for law in self._laws))

    def recall(self, memory: Sequence[Array]) -> None:
        """Go on from the `memory` of a stepper with equal laws."""
        self._before[:], self._new[:], actuation, bias = memory[:4]
        self._forces = (actuation.copy(), bias.copy())
        for law, remembered in zip(self._laws, memory[4:], strict=True):
            law.remember(remembered)

    def step(self, control: Array, begin: Array | float = 0.0) -> Array:
        """Advance all simulations by one step.

        Args:
            control: controls asked for, shape (nsim, nu).
            begin: s on the log's clock at which the simulations' own time is 0, shape (nsim,).

        Returns:
            Controls as MuJoCo got them.
        """
        batch = self._batch
        if self._new.any():  # no step before tells their forces
            batch.bind("ctrl")[self._new] = control[self._new]
            batch.forward(self._new)
            for force, computed in zip(self._forces, self._computed, strict=True):
                if force is not computed:
                    force[self._new] = computed[self._new]
            self._new[:] = False
        influence = self._influence(control)
        moment = self._moment(begin)
        for law in self._laws:
            law.act(moment, influence)
        batch.bind("ctrl")[:] = influence.control
        batch.bind("qfrc_applied")[:] = influence.force
        added = influence.armature - self._armature
        changed = np.maximum(influence.friction, 0.0), influence.armature, self._inertia + added
        for name, values in zip(CHANGED, changed, strict=True):
            batch.expand(name)[:] = values
        batch.step()
        self._forces = self._computed
        return influence.control

    def rollout(self, controls: Array, record: Sequence[str], history: History | None) -> dict[str, Array]:
        """Steps from the state that the simulations are in, under a series of controls.

        Args:
            controls: controls asked for, shape (nsim, s, nu); those that MuJoCo got take their place.
            record: names of the `MjData` fields to keep.
            history: what came before, of w windows; simulation i is that of window i mod w. None for nothing.

        Returns:
            The fields after every step, as `Batch.rollout` gives them, shape (nsim, s, …).
        """
        self.rest(np.arange(self._batch.nsim))
        begin: Array | float = 0.0
        if history is not None:
            begin = self._each(history.begin)
            self._recall(history, begin)
        fields = {name: self._batch.bind(name) for name in record}
        kept: dict[str, list[Array]] = {name: [] for name in record}
        for k in range(controls.shape[1]):
            controls[:, k] = self.step(controls[:, k], begin)
            for name, values in kept.items():
                values.append(fields[name].copy())
        return {name: np.stack(values, axis=1) for name, values in kept.items()}

    def _recall(self, history: History, begin: Array) -> None:
        """Let the laws see what was measured before; what they do has no effect then."""
        count = history.qpos.shape[1]
        still = np.zeros_like(self._friction)
        for k in range(count):
            time = begin + (k - count + 0.5) * self._step
            qpos, qvel = self._each(history.qpos[:, k]), self._each(history.qvel[:, k])
            gained = qvel - self._each(history.qvel[:, max(k - 1, 0)])
            influence = self._influence(self._each(history.controls[:, k]))
            moment = Moment(self._step, time, qpos, qvel, gained, still, still)
            for law in self._laws:
                law.recall(moment, influence)

    def _each(self, rows: Array) -> Array:
        """Rows of w windows for all simulations."""
        return np.tile(rows, (self._batch.nsim // len(rows), *[1] * (rows.ndim - 1)))

    def _influence(self, control: Array) -> Influence:
        """What acts without any law."""
        return Influence(control.copy(), np.zeros_like(self._friction), self._friction.copy(), self._armature.copy())

    def _moment(self, begin: Array | float) -> Moment:
        batch, half = self._batch, self._step / 2
        qpos, qvel = batch.bind("qpos").copy(), batch.bind("qvel").copy()
        change = np.nan_to_num(qvel - self._before)
        self._before = qvel.copy()
        qpos[:, self._positions] += half * (qvel + change / 4)[:, self._dofs]
        return Moment(
            step=self._step,
            time=np.ravel(batch.bind("time")) + begin + half,
            qpos=qpos,
            qvel=qvel + change / 2,
            gained=change,
            actuation=self._forces[0],
            bias=self._forces[1],
        )
