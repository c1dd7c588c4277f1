"""Many simulations of one model on C threads: contexts, reset, step and replay."""

import os
from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.body_contexts import BodyContexts
from dr_lab.physics.compiled_contexts import CompiledContexts
from dr_lab.physics.contact import skip_idle_collisions
from dr_lab.physics.delays import remember_readings, remembered_controls
from dr_lab.physics.few import in_calls
from dr_lab.physics.fields import FieldContexts
from dr_lab.physics.follow import follow
from dr_lab.physics.islands import skip_single_island
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.pictures import without_pictures
from dr_lab.physics.rollout import Rollout
from dr_lab.physics.stepper import Stepper
from dr_lab.physics.timers import stop_timers
from dr_lab.trajectory import Array

# Divergence is counted and masked here; MuJoCo's own log would write a file into the user's folder.
_LOG = mujoco.MjLogConfig.get()
_LOG.logto_file = _LOG.logto_console = False
mujoco.MjLogConfig.set(_LOG)
stop_timers()


def thread_count(threads: int | None) -> int:
    """How many C threads are meant.

    Args:
        threads: a number, or None for one on every core this process may use.

    Raises:
        ConfigError: fewer than one.
    """
    if threads is None:
        return len(os.sched_getaffinity(0))
    if threads < 1:
        raise ConfigError(f"threads is {threads}; expected at least 1, or null for all cores.")
    return threads


class Simulator:
    """`nsim` simulations of one model, each with its own context z.

    Contexts enter as per-simulation fields where every parameter is one, else as recompiled models, but for the inertia
    of bodies that are free as a whole; all start from the nominal model, so nothing accumulates. Where effects act
    through laws, steps are taken one by one. A context that does not compile, or would not, or a simulation that
    diverges, is marked infeasible and never stops the others.

    Args:
        model: the model with its effects.
        nsim: number of simulations.
        threads: C threads; None takes every core this process may use.
        persistent: whether each simulation keeps its own `MjData`, which `ContactForces` asks for.
        nominal: the model compiled at its nominal context where that is known, the caller's own copy.

    Raises:
        ConfigError: there are fewer threads than one.
    """

    def __init__(
        self,
        model: Model,
        nsim: int,
        threads: int | None = None,
        *,
        persistent: bool = False,
        nominal: mujoco.MjModel | None = None,
    ) -> None:
        self.model = model
        self.compiled = _lean(nominal or model.nominal())
        self.batch = Batch(self.compiled, nsim, thread_count(threads), persistent)
        self._fields = FieldContexts(model, self.compiled) if FieldContexts.possible(model, self.compiled) else None
        bodies = BodyContexts(model.space, model.inertials, self.compiled) if model.bodies_apart else None
        self._models: list[mujoco.MjModel] = [self.compiled] * nsim
        self._uncompiled = np.zeros(nsim, bool)
        contexts = np.tile(model.space.nominal, (nsim, 1))
        self._lawful = bool(model.laws(contexts, self._models))
        self._contexts, self._written = contexts, CompiledContexts(self.batch, self.compiled, bodies)
        self._stepper: Stepper | None = None
        self._given: Array | None = None  # contexts of all simulations, where they were given at once
        # Only models whose fields are copied need the same pictures.
        alike = self._lawful or bodies is not None
        self._source = model if alike else replace(model, spec=without_pictures(model.spec))
        self.batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._default = self.batch.state.copy()
        self._ctrl = self.batch.bind("ctrl")

    @property
    def nsim(self) -> int:
        """Number of simulations."""
        return self.batch.nsim

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Simulations that diverged since their last reset or whose context does not compile, shape (nsim,)."""
        return self._uncompiled | (self.batch.warning[:, :, 1] > 0).any(axis=1)

    def set_contexts(self, z: Array, ids: NDArray[np.intp] | None = None) -> None:
        """Give simulations their contexts; z shape (len(ids), n), all simulations when `ids` is None."""
        if ids is None and self._given is not None and np.array_equal(z, self._given):
            return
        self._given = z.copy() if ids is None else None
        rows = np.arange(self.nsim) if ids is None else ids
        if self._fields is not None:
            self._uncompiled[rows] = self._fields.write(self.batch, z, rows)
            return
        bodies = self._written.bodies
        unique, which = np.unique(z if bodies is None else bodies.rest(z), axis=0, return_inverse=True)
        compiled = [self._compile(row) for row in unique]
        for row, k in zip(rows, which.ravel(), strict=True):
            self._models[row] = compiled[k] or self.compiled
            self._uncompiled[row] = compiled[k] is None
        if not self._lawful and bodies is None:
            self.batch.set_models(self._models)
            return
        self._written.write([self._models[row] for row in rows], rows, z)
        if not self._lawful:
            return
        self._contexts[rows] = z
        before = self._stepper
        self._stepper = Stepper(self.batch, self.compiled, self.model.laws(self._contexts, self._models))
        if before is not None:
            self._stepper.restore(before.memory)

    def reset(self, ids: NDArray[np.intp] | None = None) -> None:
        """Put simulations into the model's initial state and clear their divergence counters."""
        rows = np.arange(self.nsim) if ids is None else ids
        self.batch.state[rows] = self._default[rows]
        self.batch.warning[rows] = 0
        if self._stepper is not None:
            self._stepper.rest(rows)

    def step(self, controls: Array, nstep: int = 1) -> None:
        """Advance every simulation by `nstep` steps under held controls, shape (nsim, nu)."""
        if self._stepper is not None:
            for _ in range(nstep):
                self._stepper.step(controls)
            return
        self._ctrl[:] = controls
        self.batch.step(nstep=nstep)

    def forward(self, ids: NDArray[np.intp]) -> None:
        """Compute what follows from the states of these simulations."""
        for each in in_calls(self.batch, ids):
            self.batch.forward(each)

    @property
    def memory(self) -> tuple[Array, ...]:
        """All that the simulations' future depends on besides their contexts, for `restore`."""
        laws = () if self._stepper is None else self._stepper.memory
        return (self.batch.state.copy(), self.batch.warning.copy(), *laws)

    def restore(self, memory: Sequence[Array]) -> None:
        """Go on from the `memory` of a simulator of the same model that had the same contexts."""
        self.batch.state[:], self.batch.warning[:] = memory[:2]
        if self._stepper is not None:
            self._stepper.restore(memory[2:])

    def replay(
        self,
        z: Array,
        qpos: Array,
        qvel: Array,
        controls: Array,
        past: Array,
        history: History | None = None,
        act: Array | None = None,
    ) -> Rollout:
        """Simulate every (context, window) pair from its start under the windows' controls, in one call.

        Simulation i of the rollout is context · w + window.

        Args:
            z: contexts, shape (c, n), or (c, w, n) where windows differ in the effects that are attached.
            qpos: start positions, shape (c, w, nq), with c · w = nsim.
            qvel: start velocities, shape (c, w, nv).
            controls: control of each step, shape (w, s, nu), or (c, w, s, nu).
            past: controls of the steps before the start, oldest first, shape (w, p, nu); those of a longer history.
            history: what was measured before the start, for laws that remember; None for nothing at time 0.
            act: activations at the start, shape (c, w, na); None for those of the model's initial state.
        """
        contexts = self._begin(z, qpos, qvel, act)
        z = z if z.ndim == 2 else z[:, 0]  # nobody attaches a command filter
        past = past if history is None else max(past, history.controls, key=lambda known: known.shape[1])
        before, (nstep, ncontrol) = past.shape[1], controls.shape[-2:]
        earlier = np.broadcast_to(past, (*controls.shape[:-3], *past.shape))
        known = self.commanded(z, np.concatenate([earlier, controls], axis=-2))
        every = np.tile(known, (contexts // len(known), 1, 1, 1)).reshape(self.nsim, before + nstep, ncontrol)
        applied = np.ascontiguousarray(every[:, before:])
        self._remember(known[:, :, :before], contexts)
        remember_readings(self.batch, self.compiled, history, every, before)
        start = self.batch.state.copy()
        record = ("qpos", "qvel", "sensordata") if self.compiled.nsensordata else ("qpos", "qvel")
        if self._stepper is None:
            out = self.batch.rollout(nstep, applied if ncontrol else None, record=record)
        else:
            out = self._stepper.rollout(applied, record, history, known[:, :, :before])
        first = lambda start, rest: np.concatenate([start.reshape(self.nsim, 1, -1), rest], axis=1)  # noqa: E731
        sensors = out.get("sensordata", np.empty((self.nsim, nstep, 0)))
        return Rollout(first(qpos, out["qpos"]), first(qvel, out["qvel"]), sensors, start, applied, self.infeasible)

    def _begin(self, z: Array, qpos: Array, qvel: Array, act: Array | None) -> int:
        """Put every (context, window) pair at its start and give the number of contexts; arguments as `replay`."""
        contexts, windows = qpos.shape[:2]
        if contexts * windows != self.nsim:
            raise ModelError(
                f"Replay of {contexts}×{windows} needs as many simulations; this simulator has {self.nsim}."
            )
        self.set_contexts(np.repeat(z, windows, axis=0) if z.ndim == 2 else z.reshape(self.nsim, -1))
        self.reset()
        self.batch.bind("qpos")[:] = qpos.reshape(self.nsim, -1)
        self.batch.bind("qvel")[:] = qvel.reshape(self.nsim, -1)
        if act is not None:
            self.batch.bind("act")[:] = act.reshape(self.nsim, -1)
        return contexts

    def _remember(self, past: Array, contexts: int) -> None:
        """Fill the memories of delayed actuators from past controls, shape (c or 1, w, p, nu)."""
        if self.compiled.nhistory:
            rows = [remembered_controls(self.compiled, each) for each in past]
            self.batch.bind("history")[:] = np.tile(np.concatenate(rows), (contexts // len(past), 1))

    def follow(self, z: Array, history: History, act: Array) -> Array:
        """Activations along a motion that is given, not simulated: MuJoCo steps them, and the motion is put back.

        Args:
            z: contexts, shape (c, n).
            history: motion and controls of p steps before w starts, with c · w = nsim; delayed actuators have had the
                first control before.
            act: activations before the first of these steps, shape (w, na).

        Returns:
            Activations after each step, shape (p, c, w, na).
        """
        (windows, steps), contexts = history.qpos.shape[:2], len(z)
        self.set_contexts(np.repeat(z, windows, axis=0))
        self.reset()
        known, step = self.commanded(z, history.controls), self.compiled.opt.timestep
        controls = np.tile(known, (contexts // len(known), 1, 1, 1)).reshape(self.nsim, steps, -1)
        self.batch.bind("time")[:] = -steps * step
        if self.compiled.nhistory:
            self.batch.bind("history")[:] = remembered_controls(self.compiled, controls[:, :1], -steps * step)
        found = follow(self.batch, history.qpos, history.qvel, controls, act)
        return found.reshape(steps, contexts, windows, -1)

    def commanded(self, z: Array, controls: Array) -> Array:
        """Controls as the effects' command filters leave them.

        Args:
            z: contexts, shape (c, n).
            controls: control of each step, shape (w, s, nu), or (c, w, s, nu).

        Returns:
            Shape (c, w, s, nu), or (1, w, s, nu) where no context changes them.
        """
        every = controls if controls.ndim == 4 else controls[None]
        for actuator in range(self.compiled.nactuator if self.model.effects else 0):
            if self.compiled.actuator_ctrlnum[actuator] == 1:
                column = self.compiled.actuator_ctrladr[actuator]
                series = every[..., column]
                changed = self.model.command(z, self.compiled.actuator(actuator).name, series)
                if changed is not series:
                    every = np.repeat(every, len(changed) // len(every), axis=0)
                    every[..., column] = changed
        return every

    def _compile(self, z: Array) -> mujoco.MjModel | None:
        try:
            return _lean(self._source.compile(z))
        except ModelError:
            return None


def _lean(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model without passes that can find nothing."""
    return skip_single_island(skip_idle_collisions(model))
