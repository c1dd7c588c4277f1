"""What the arm is to do, and the machine that it is to do it on: two classes of a user's own."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import torch
from tensordict import TensorDict, pad_sequence

from dr_lab.collectors.collector import Drive, Policy
from dr_lab.envs.batched_env import single
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.errors import ConfigError
from dr_lab.targets.target import Target
from dr_lab.targets.task_view import TaskView
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Reach(Task):
    """Hold a posture: r = 1 − |q − posture|² − effort · |u|². All arrays have one row a simulation."""

    posture: Sequence[float]  # rad
    spread: float  # rad, half width of the uniform start about hanging
    effort: float  # 1/(N·m)²

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """One position and one velocity of the machine; the only method for a single simulation."""
        return rng.uniform(-self.spread, self.spread, compiled.nq), np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """What the policy sees, (n, 6): angles as sine and cosine, velocities."""
        q = fields["qpos"]
        return np.concatenate([np.sin(q), np.cos(q), 0.1 * fields["qvel"]], axis=1)

    def reward(self, change: Change) -> Array:
        """One number a simulation, (n,)."""
        error = change.fields["qpos"] - self.posture
        return 1.0 - (error**2).sum(axis=1) - self.effort * (change.action**2).sum(axis=1)


class Bench(Target):
    """The machine. MuJoCo stands for it here; hardware would read its encoders and write to its drives."""

    nature = "no hardware but the arm of make_logs.py, with dry friction in its elbow"

    def __init__(self, setting: Setting, friction: float) -> None:
        self._view = TaskView(setting)  # observations, rewards and ends, from positions and velocities
        self._machine = setting.model.nominal()
        self._machine.joint("elbow").frictionloss = friction
        self._skipped = setting.task.frame_skip

    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """Whole episodes; `dr-lab evaluate` asks for one at a time, from a given start."""
        if starts is None or not callable(drive):
            raise ConfigError("The bench is driven by a policy, from given starts.")
        return pad_sequence([self._episode(drive, starts[0][i], starts[1][i]) for i in range(count)])

    def _episode(self, policy: Policy, qpos: Array, qvel: Array) -> TensorDict:
        data = mujoco.MjData(self._machine)
        data.qpos[:], data.qvel[:] = qpos, qvel
        positions, velocities, actions = [qpos], [qvel], []
        for _ in range(self._view.steps):
            seen = single(self._view.observe(positions[-1][None], velocities[-1][None]))
            with torch.no_grad():
                actions.append(np.clip(policy(seen).double().numpy()[0], self._view.low, self._view.high))
            data.ctrl[:] = actions[-1]
            mujoco.mj_step(self._machine, data, self._skipped)
            positions.append(data.qpos.copy())
            velocities.append(data.qvel.copy())
        return self._view.course(np.array(positions), np.array(velocities), np.array(actions))
