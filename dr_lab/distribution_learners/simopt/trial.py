"""What the real machine did, and what a simulation does of the same."""

from dataclasses import dataclass
from typing import Self, cast

import numpy as np
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Drive, Policy
from dr_lab.collectors.experience import Experience
from dr_lab.envs.slots import Starts
from dr_lab.targets.target import Target
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Trial:
    """Episodes of a target, and by what they can be played again.

    Attributes:
        real: size [k, T], as `Target.play` gives it.
        drive: the policy that acted, so that a simulation reacts by itself; of recorded logs the commands of each
            episode, shape (k, T, nu), so that it does as it is told.
    """

    real: TensorDict
    drive: Drive

    @classmethod
    def of_policy(cls, target: Target, policy: Policy, starts: Starts) -> Self:
        """Play a policy on a target from given starts."""
        return cls(target.play(policy, starts, len(starts[0])), policy)

    @classmethod
    def of_logs(cls, target: Target, count: int) -> Self:
        """Take recorded episodes, so many, with their own starts."""
        real = target.play(None, None, count)
        return cls(real, cast(Tensor, real["action"]).double().numpy())

    def simulated(self, experience: Experience, z: Array) -> TensorDict:
        """The same in the model, in each context z (m, n) from each start; size [m, k, t]."""
        count, drive = len(self.real), self.drive
        starts = tuple(np.tile(cast(Tensor, self.real[key])[:, 0].numpy(), (len(z), 1)) for key in ("qpos", "qvel"))
        if isinstance(drive, np.ndarray):
            drive = np.tile(drive, (len(z), 1, 1))
        played = experience.play(drive, z.repeat(count, axis=0), cast(Starts, starts))
        return cast(TensorDict, played.reshape(len(z), count, -1))
