"""A block on a rail that begins at rest at the origin; what is seen and rewarded is a test's own."""

from typing import ClassVar

import mujoco
import numpy as np
import torch
from torch import Tensor

from dr_lab.collectors.collector import Policy
from dr_lab.envs.task import Task
from dr_lab.trajectory import Array


class BlockOnRail(Task):
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel")

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        del rng, compiled
        return np.zeros(1), np.zeros(1)


def constant(force: float) -> Policy:
    def act(observation: Tensor) -> Tensor:
        return torch.full((len(observation), 1), force)

    return act
