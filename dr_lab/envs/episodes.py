"""Episodes of one task that run side by side, each with its own context, in NumPy."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from dr_lab.envs.context_slots import ContextSlots, first_ages
from dr_lab.envs.drivers import stepwise
from dr_lab.envs.slots import Flags, Rows, Starts, StepOutcome
from dr_lab.envs.task import Change, Fields, Task, Values, context_space, required_bounds
from dr_lab.envs.task_outputs import (
    ReadFields,
    require_controls,
    require_finite,
    require_observation,
    require_outcome,
    require_start,
)
from dr_lab.physics.contact_forces import ContactForces
from dr_lab.physics.model import Model
from dr_lab.physics.setpoints import Setpoints
from dr_lab.physics.simulator import Simulator
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array

_FORCES = "cfrc_ext"


class Episodes(ContextSlots):
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
        ConfigError: what the task gives has another shape than its contract says, or is not finite.
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
        super().__init__(context_space(model, task), source, nsim, seed, show_context=show_context)
        self.model, self.task = model, task
        self.simulator = Simulator(stepwise(model), nsim, threads, persistent=_FORCES in task.reads)
        compiled = self.simulator.compiled
        self.low, self.high = required_bounds(task, compiled)
        self.seconds = task.frame_skip * float(compiled.opt.timestep)
        self._infeasible_return, self._speed_limit = infeasible_return, speed_limit
        self._fields = ReadFields({name: self.simulator.batch.bind(name) for name in task.reads if name != _FORCES})
        self._forces = ContactForces(self.simulator.batch) if _FORCES in task.reads else None
        if self._forces is not None:
            self._fields[_FORCES] = self._forces.values
        self._qpos, self._qvel = self.simulator.batch.bind("qpos"), self.simulator.batch.bind("qvel")
        self._setpoints = Setpoints(self.simulator.batch)
        self._steps, self._returns = np.zeros(nsim, np.intp), np.zeros(nsim)
        self._failed = np.zeros(nsim, bool)  # ended as infeasible and not begun anew
        self._over = np.zeros(nsim, bool)  # ended and not begun anew
        self.infeasible = 0
        self._marker = self._marked(self._fields)
        self.observation = self._seen(self._fields, self.contexts)
        self.begin(np.arange(nsim))
        if staggered:
            self._steps[:] = first_ages(nsim, task.time_limit)

    @property
    def state(self) -> tuple[Array, Array]:
        """Copies of the positions (n, nq) and velocities (n, nv)."""
        return self._qpos.copy(), self._qvel.copy()

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        """Begin new episodes in these slots; the others are not touched.

        Args:
            rows: the slots.
            starts: what they begin with, row by row; None lets the task draw it from each slot's stream.
        """
        streams = self._renew(rows)
        self.simulator.set_contexts(self._of_machine(self.contexts[rows]), rows)
        self.simulator.reset(rows)
        if starts is not None:
            self._qpos[rows], self._qvel[rows] = starts
        else:
            for row, rng in zip(rows, streams, strict=True):
                start = self.task.start(rng, self.simulator.compiled)
                require_start(self.task, start, self.simulator.compiled)
                self._qpos[row], self._qvel[row] = start
        self._setpoints.follow(rows)
        self.simulator.forward(rows)
        if self._forces is not None:
            self._forces.rest(rows)
        self._steps[rows], self._returns[rows], self._failed[rows], self._over[rows] = 0, 0.0, False, False
        fields = ReadFields({name: field[rows] for name, field in self._fields.items()})
        self._marker[rows] = self._marked(fields)
        self.observation = self.observation.copy()
        begun = self._seen(fields, self.contexts[rows])
        require_finite(self.task, self._returns[rows], begun, self._qpos[rows], self._over[rows])
        self.observation[rows] = begun

    def step(self, action: Array) -> StepOutcome:
        """One control step of all episodes; those that have ended want a `begin` before the next.

        Args:
            action: as the task takes it, shape (n, a); what lies outside of the bounds is cut off.
        """
        action, values = np.clip(action, self.low, self.high), self._by_name(self.contexts)
        controls = self.task.controls(action, values)
        require_controls(self.task, controls, action, self.nsim, self.simulator.compiled.nu)
        self.simulator.step(controls, self.task.frame_skip)
        if self._forces is not None:
            self._forces.update()
        fields = self._fields
        observation, marker = self._seen(fields, self.contexts), self._marked(fields)
        terminated = self.task.terminated(fields, values)
        change = Change(self._marker, marker, fields, values, terminated, action, self.seconds)
        reward = np.array(self.task.reward(change))
        require_outcome(self.task, reward, terminated, self.nsim)
        failed = self._failed | self._diverged()
        if failed.any():
            self.infeasible += int((failed & ~self._failed).sum())
            observation[failed] = self.observation[failed]
            reward = np.where(failed, np.minimum(self._infeasible_return - self._returns, 0.0), reward)
            terminated = terminated | failed
        require_finite(self.task, reward, observation, self._qpos, self._over)
        self._steps += 1
        self._returns += reward
        self.observation, self._marker, self._failed = observation, marker, failed.copy()  # `begin` writes into it
        outcome = StepOutcome(observation, reward, terminated, self._steps >= self.task.time_limit, failed)
        self._over = self._over | outcome.done
        return outcome

    def state_dict(self) -> dict[str, Any]:
        """All that the episodes' future depends on."""
        return {
            **self._context_state(),
            "simulator": self.simulator.memory,
            "steps": self._steps.copy(),
            "returns": self._returns.copy(),
            "marker": self._marker.copy(),
            "observation": self.observation.copy(),
            "infeasible": self.infeasible,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where the `state_dict` of episodes of the same machine and task was taken."""
        self._load_context_state(state)
        self.simulator.set_contexts(self._of_machine(self.contexts))
        self.simulator.restore(state["simulator"])
        self._steps[:], self._returns[:] = state["steps"], state["returns"]
        self._marker, self.observation = state["marker"].copy(), state["observation"].copy()
        self._failed = self._diverged() & (self._steps > 0)
        self._over[:] = False
        self.infeasible = state["infeasible"]

    def _diverged(self) -> Flags:
        slow = np.abs(self._qvel).max(axis=1, initial=0.0) < self._speed_limit  # NaN is not
        return self.simulator.infeasible | ~slow

    def _seen(self, fields: Fields, contexts: Array) -> Array:
        observation = np.array(self.task.observe(fields, self._by_name(contexts)))
        require_observation(self.task, observation, len(contexts))
        return self._with_context(observation, contexts)

    def _marked(self, fields: Fields) -> Array:
        return np.array(self.task.marker(fields))

    def _of_machine(self, z: Array) -> Array:
        return z[:, : len(self.model.space.names)]

    def _by_name(self, z: Array) -> Values:
        return {name: z[:, i] for i, name in enumerate(self.space.names)}
