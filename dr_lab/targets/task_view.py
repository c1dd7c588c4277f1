"""What a task makes of the motion of a machine that it does not simulate."""

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.envs.batched_env import single
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values, required_bounds
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array


class TaskView:
    """Observations, rewards and ends of a task, from positions and velocities alone, at the nominal context.

    Args:
        setting: machine and task as this side knows them.

    Attributes:
        low: lowest action, shape (a,).
        high: highest action, shape (a,).
        seconds: length of a control step.
        steps: control steps of an episode that is not ended before.

    Raises:
        ConfigError: the task reads more than positions and velocities.
    """

    def __init__(self, setting: Setting) -> None:
        task, compiled = setting.task, setting.model.nominal()
        if set(task.reads) - {"qpos", "qvel"}:
            raise ConfigError(
                f"Task {type(task).__name__} reads {', '.join(task.reads)}; a target like this knows positions and "
                "velocities alone. Take a task that reads no more, or target=model."
            )
        self._setting, self._task = setting, task
        self.low, self.high = required_bounds(task, compiled)
        self.seconds, self.steps = task.frame_skip * float(compiled.opt.timestep), task.time_limit

    def observe(self, qpos: Array, qvel: Array) -> Array:
        """What the policy sees of n states, shape (n, o); `qpos` (n, nq), `qvel` (n, nv)."""
        seen = self._task.observe(_fields(qpos, qvel), self._values(len(qpos)))
        if not self._setting.show_context:
            return seen
        space = self._setting.space
        return np.concatenate([seen, np.tile(space.to_unit(space.nominal), (len(qpos), 1))], axis=1)

    def commands(self, action: Array) -> Array:
        """Commands of the actuators (n, nu) where a policy does `action` (n, a), which is cut off at its bounds."""
        return self._task.controls(np.clip(action, self.low, self.high), self._values(len(action)))

    def course(self, qpos: Array, qvel: Array, action: Array) -> TensorDict:
        """One episode up to where the task ends it, size [≤ t], in the layout of `collectors.play.play`.

        Args:
            qpos: positions before the first and after every control step, shape (t + 1, nq).
            qvel: velocities, shape (t + 1, nv).
            action: within its bounds, shape (t, a).
        """
        before, after, values = _fields(qpos[:-1], qvel[:-1]), _fields(qpos[1:], qvel[1:]), self._values(len(action))
        terminated = self._task.terminated(after, values)
        marker = self._task.marker
        change = Change(marker(before), marker(after), after, values, terminated, action, self.seconds)
        reward, ended = self._task.reward(change), np.flatnonzero(terminated)
        steps = int(ended[0]) + 1 if len(ended) else len(action)
        observation, states = single(self.observe(qpos, qvel)), {"qpos": qpos, "qvel": qvel}
        truncated = (np.arange(len(action)) == steps - 1) & ~terminated
        flags = {"terminated": terminated, "truncated": truncated, "done": terminated | truncated}
        columns = {"reward": reward, **flags, "infeasible": np.zeros(len(action), bool)}
        then = {key: torch.from_numpy(value[:, None]) for key, value in columns.items()}
        then |= {"observation": observation[1:]} | {k: torch.from_numpy(v[1:]) for k, v in states.items()}
        now = {"observation": observation[:-1]} | {k: torch.from_numpy(v[:-1]) for k, v in states.items()}
        now |= {"action": torch.from_numpy(action), "mask": torch.ones(len(action), dtype=torch.bool)}
        size = [len(action)]
        course = TensorDict({**now, "next": TensorDict(then, batch_size=size)}, batch_size=size)
        found = course[:steps]
        assert isinstance(found, TensorDict)
        return found

    def _values(self, count: int) -> Values:
        return {p.name: np.full(count, p.nominal) for p in self._setting.space.parameters}


def _fields(qpos: Array, qvel: Array) -> Fields:
    return {"qpos": qpos, "qvel": qvel}
