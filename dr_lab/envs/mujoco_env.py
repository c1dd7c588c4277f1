"""The batched TorchRL environment on MuJoCo."""

import numpy as np

from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.envs.episodes import Episodes
from dr_lab.envs.task import Task
from dr_lab.physics.model import Model
from dr_lab.randomizers.context_source import ContextSource


class MujocoEnv(BatchedEnv):
    """`BatchedEnv` of `Episodes`; see there for contexts, streams and what infeasible contexts lead to.

    Args:
        model: the machine.
        task: what it is to do.
        randomizer: p(z), from which every new episode draws; None for the nominal context.
        slots: n.
        seed: of all random draws.
        show_context: whether the policy sees z.
        infeasible_return: highest return of an episode whose context is infeasible.
        speed_limit: of every joint of a simulation that has not diverged, m/s or rad/s.
        threads: C threads; None takes every core this process may use.
        staggered: whether first episodes are cut at different ages; for training alone.

    Attributes:
        episodes: the same episodes in NumPy.
    """

    episodes: Episodes

    def __init__(
        self,
        model: Model,
        task: Task,
        randomizer: ContextSource | None,
        slots: int,
        seed: int,
        *,
        show_context: bool = False,
        infeasible_return: float = 0.0,
        speed_limit: float = np.inf,
        threads: int | None = None,
        staggered: bool = False,
    ) -> None:
        super().__init__(
            Episodes(
                model,
                task,
                randomizer,
                slots,
                seed,
                show_context=show_context,
                infeasible_return=infeasible_return,
                speed_limit=speed_limit,
                threads=threads,
                staggered=staggered,
            )
        )
