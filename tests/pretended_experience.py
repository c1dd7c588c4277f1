"""Experience whose episodes have one step and a known return."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from point_mass import PointCollector, best
from tensordict import TensorDict

from dr_lab.collectors.boundary import Boundary
from dr_lab.collectors.collector import Collector, Drive
from dr_lab.collectors.experience import Experience
from dr_lab.envs.slots import Starts
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array


class PretendedExperience(Experience):
    """Batches of a collector, and episodes that return what a function of z (k, n) says, NaN where it is infeasible."""

    def __init__(
        self,
        returns: Callable[[Array], Array],
        collector: Collector | None = None,
        source: ContextSource | None = None,
    ) -> None:
        self._returns, self._collector = returns, collector or PointCollector(best)
        self._listeners, self.policy, self.played, self.rollout_frames = [], best, 0, 0
        self.deployed, self.source, self._boundary = best, source, Boundary()

    def play(self, drive: Drive, z: Array, starts: Starts | None = None) -> TensorDict:
        del drive, starts
        self.played += len(z)
        self.rollout_frames += len(z)
        returns = self._returns(z)
        infeasible = torch.from_numpy(np.isnan(returns))[:, None, None]
        after = {"reward": torch.from_numpy(np.nan_to_num(returns))[:, None, None], "infeasible": infeasible}
        return TensorDict({"next": TensorDict(after, batch_size=[len(z), 1])}, batch_size=[len(z), 1])

    def executed(self, batch: TensorDict) -> TensorDict:
        return batch

    def state_dict(self) -> dict[str, Any]:
        return {"collector": self._collector.state_dict(), "played": self.played, "rollout_frames": self.rollout_frames}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        self._collector.load_state_dict(state["collector"])
        self.played, self.rollout_frames = state["played"], state["rollout_frames"]
