"""Episodes of one task that run side by side, each with its own context, in NumPy."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dr_lab.envs.drivers import stepwise
from dr_lab.envs.slots import Flags, Rows, Starts, StepOutcome
from dr_lab.envs.task import Change, Fields, Task, Values, context_space, required_bounds
from dr_lab.errors import ModelError
from dr_lab.physics.contact_forces import ContactForces
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.randomizers.context_source import UNKEYED, ContextSource, Proposals
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_FORCES = "cfrc_ext"
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


class Episodes:
    """n episodes on one `Simulator`; each slot draws its contexts and starts from a random stream of its own.

    Fulfils `EpisodeSlots`.

    An infeasible context (it does not compile, or the simulation diverges) ends the episode. Its return is then at most
    `infeasible_return`: the last reward R − Σr takes off what was earned beyond it, and is 0 where less was earned, so
    that divergence never pays. A simulation counts as diverged from the control step on that leaves it faster than
    `speed_limit`: MuJoCo itself notices steps later, when rewards and observations have grown by orders of magnitude.

    Args:
        model: the machine, whose parameters and those of the task make up the context z.
        task: what it is to do.
        source: where contexts are drawn from; None keeps every episode at the nominal context.
        nsim: n.
        seed: of all random draws.
        show_context: whether the policy sees z behind the task's observation, as (z − low) / (high − low).
        infeasible_return: R, the highest return of an episode whose context is infeasible.
        speed_limit: of every joint of a simulation that has not diverged, m/s or rad/s.
        threads: C threads; None takes every core this process may use.
        staggered: whether first episodes are cut at different ages, see `first_ages`; for training alone.

    Attributes:
        space: the context.
        observation: what the policy sees now, shape (n, o).
        contexts: z of the running episodes, shape (n, parameters).
        proposals: which proposal of the source each of these is, shape (n,).
        infeasible: number of episodes that ended because their context was infeasible.

    Raises:
        ModelError: an effect of the model does something to commands that cannot be done step by step, or an actuator
            has no range to act in.
    """

    def __init__(
        self,
        model: Model,
        task: Task,
        source: ContextSource | None,
        nsim: int,
        seed: int,
        *,
        show_context: bool,
        infeasible_return: float,
        speed_limit: float,
        threads: int | None = None,
        staggered: bool = False,
    ) -> None:
        self.model, self.task, self.source = model, task, source
        self.space = context_space(model, task)
        self.simulator = Simulator(stepwise(model), nsim, threads, persistent=_FORCES in task.reads)
        compiled = self.simulator.compiled
        self.low, self.high = required_bounds(task, compiled)
        self.seconds = task.frame_skip * float(compiled.opt.timestep)
        self._show_context, self._infeasible_return, self._speed_limit = show_context, infeasible_return, speed_limit
        self._fields = {name: self.simulator.batch.bind(name) for name in task.reads if name != _FORCES}
        self._forces = ContactForces(self.simulator.batch) if _FORCES in task.reads else None
        if self._forces is not None:
            self._fields[_FORCES] = self._forces.values
        self._qpos, self._qvel = self.simulator.batch.bind("qpos"), self.simulator.batch.bind("qvel")
        self._streams = [stream(seed, "episode", slot) for slot in range(nsim)]
        self._slots = np.arange(nsim)  # among all that train, some of which others may play
        self._given: Array | None = None
        self._steps, self._returns = np.zeros(nsim, np.intp), np.zeros(nsim)
        self._failed = np.zeros(nsim, bool)  # ended as infeasible and not begun anew
        self.infeasible = 0
        self.contexts = np.tile(self.space.nominal, (nsim, 1))
        self.proposals = np.full(nsim, UNKEYED, np.int64)
        self._marker = task.marker(self._fields)
        self.observation = self._seen(self._fields, self.contexts)
        self.begin(np.arange(nsim))
        if staggered:
            self._steps[:] = first_ages(nsim, task.time_limit)

    @property
    def nsim(self) -> int:
        """Number of episodes that run side by side."""
        return len(self._steps)

    @property
    def state(self) -> tuple[Array, Array]:
        """Copies of the positions (n, nq) and velocities (n, nv)."""
        return self._qpos.copy(), self._qvel.copy()

    def give_contexts(self, z: Array | None) -> None:
        """Let slot i begin every further episode with context z[i], shape (n, parameters); None draws again."""
        if z is not None and z.shape != self.contexts.shape:
            raise ModelError(f"Contexts have shape {z.shape}; expected one for each episode, {self.contexts.shape}.")
        self._given = None if z is None else np.array(z, dtype=float)

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        """Begin new episodes in these slots; the others are not touched.

        Args:
            rows: the slots.
            starts: what they begin with, row by row; None lets the task draw it from each slot's stream.
        """
        streams = [self._streams[row] for row in rows]
        drawn = self._draw(streams, rows)
        self.contexts, self.proposals = self.contexts.copy(), self.proposals.copy()  # what was handed out stays
        self.contexts[rows], self.proposals[rows] = drawn.z, drawn.keys
        self.simulator.set_contexts(self._of_machine(self.contexts[rows]), rows)
        self.simulator.reset(rows)
        if starts is not None:
            self._qpos[rows], self._qvel[rows] = starts
        else:
            for row, rng in zip(rows, streams, strict=True):
                self._qpos[row], self._qvel[row] = self.task.start(rng, self.simulator.compiled)
        self.simulator.forward(rows)
        if self._forces is not None:
            self._forces.rest(rows)
        self._steps[rows], self._returns[rows], self._failed[rows] = 0, 0.0, False
        fields = {name: field[rows] for name, field in self._fields.items()}
        self._marker[rows] = self.task.marker(fields)
        self.observation = self.observation.copy()
        self.observation[rows] = self._seen(fields, self.contexts[rows])

    def step(self, action: Array) -> StepOutcome:
        """One control step of all episodes; those that have ended want a `begin` before the next.

        Args:
            action: in the actuators' unit, shape (n, nu); what lies outside of the bounds is cut off.
        """
        action = np.clip(action, self.low, self.high)
        self.simulator.step(action, self.task.frame_skip)
        if self._forces is not None:
            self._forces.update()
        fields, values = self._fields, self._by_name(self.contexts)
        observation, marker = self._seen(fields, self.contexts), self.task.marker(fields)
        terminated = self.task.terminated(fields, values)
        reward = self.task.reward(Change(self._marker, marker, fields, values, terminated, action, self.seconds))
        failed = self._failed | self._diverged()
        if failed.any():
            self.infeasible += int((failed & ~self._failed).sum())
            observation[failed] = self.observation[failed]
            reward = np.where(failed, np.minimum(self._infeasible_return - self._returns, 0.0), reward)
            terminated = terminated | failed
        self._steps += 1
        self._returns += reward
        self.observation, self._marker, self._failed = observation, marker, failed.copy()  # `begin` writes into it
        return StepOutcome(observation, reward, terminated, self._steps >= self.task.time_limit, failed)

    def state_dict(self) -> dict[str, Any]:
        """All that the episodes' future depends on."""
        return {
            "simulator": self.simulator.memory,
            "contexts": self.contexts,
            "proposals": self.proposals,
            "slots": self._slots,
            "given": self._given,
            "steps": self._steps.copy(),
            "returns": self._returns.copy(),
            "marker": self._marker.copy(),
            "observation": self.observation.copy(),
            "infeasible": self.infeasible,
            "streams": [rng.bit_generator.state for rng in self._streams],
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where the `state_dict` of episodes of the same machine and task was taken."""
        self.contexts, self._given = state["contexts"], state["given"]
        self.proposals, self._slots = state["proposals"], state["slots"]
        self.simulator.set_contexts(self._of_machine(self.contexts))
        self.simulator.restore(state["simulator"])
        self._steps[:], self._returns[:] = state["steps"], state["returns"]
        self._marker, self.observation = state["marker"].copy(), state["observation"].copy()
        self._failed = self._diverged() & (self._steps > 0)
        self.infeasible = state["infeasible"]
        for rng, remembered in zip(self._streams, state["streams"], strict=True):
            rng.bit_generator.state = remembered

    def _draw(self, streams: Sequence[np.random.Generator], rows: Rows) -> Proposals:
        if self._given is None and self.source is not None:
            return self.source.propose(streams, self._slots[rows])
        z = np.tile(self.space.nominal, (len(rows), 1)) if self._given is None else self._given[rows]
        return Proposals(z, np.full(len(rows), UNKEYED, np.int64))

    def _diverged(self) -> Flags:
        slow = np.abs(self._qvel).max(axis=1, initial=0.0) < self._speed_limit  # NaN is not
        return self.simulator.infeasible | ~slow

    def _seen(self, fields: Fields, contexts: Array) -> Array:
        seen = self.task.observe(fields, self._by_name(contexts))
        return np.concatenate([seen, self.space.to_unit(contexts)], axis=1) if self._show_context else seen

    def _of_machine(self, z: Array) -> Array:
        return z[:, : len(self.model.space.names)]

    def _by_name(self, z: Array) -> Values:
        return {name: z[:, i] for i, name in enumerate(self.space.names)}


def first_ages(slots: int, time_limit: int) -> Rows:
    """Control steps that the time limit counts for each slot before its first episode begins, shape (slots,).

    Slots that begin together would stay in step wherever every episode lasts to the time limit: each batch would hold
    one phase of the episode, and all contexts would change at once. Slot i starts at the age ⌊T·frac(i·φ)⌋, T being the
    time limit and φ the golden ratio's fraction 0.618, so that ages are even over any neighbouring slots.
    """
    return (time_limit * ((np.arange(slots) * _GOLDEN) % 1.0)).astype(np.intp)
