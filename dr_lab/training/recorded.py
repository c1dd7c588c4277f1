"""Episodes of a policy with all that happens in them, for recordings."""

from typing import Literal

import mujoco
import numpy as np

from dr_lab.collectors.collector import Policy
from dr_lab.envs.episodes import Episodes
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.recorders.episode import Episode
from dr_lab.training.rollouts import Step, begin, play
from dr_lab.trajectory import Array


def record(episodes: Episodes, policy: Policy, z: Array) -> list[Episode]:
    """Play one episode in each context, from its start to its end.

    Args:
        episodes: as many slots as contexts, or more.
        policy: what acts.
        z: contexts, shape (k, n), k ≥ 1.

    Returns:
        The episodes, called ``episode_1``, ``episode_2`` …
    """
    begin(episodes, z)
    states, steps = [episodes.state], list[Step]()
    for step in play(episodes, policy, len(z)):
        states.append(episodes.state)
        steps.append(step)
    position, velocity = (np.stack(each, axis=1) for each in zip(*states, strict=True))
    action = np.clip(np.stack([step.action for step in steps], axis=1), episodes.low, episodes.high)
    reward = np.stack([step.outcome.reward for step in steps], axis=1)
    lengths = np.sum([step.going for step in steps], axis=0)
    parameters = episodes.model.space.parameters
    return [
        Episode(
            name=f"episode_{slot + 1}",
            context={p.name: (float(value), p.unit) for p, value in zip(parameters, z[slot], strict=True)},
            geometry=_geometry(episodes.model, z[slot]),
            time=np.arange(length + 1) * episodes.seconds,
            qpos=position[slot, : length + 1],
            qvel=velocity[slot, : length + 1],
            action=action[slot, :length].astype(np.float64),
            reward=reward[slot, :length],
            ended=_ending(steps[length - 1], slot),
        )
        for slot, length in enumerate(lengths[: len(z)])
    ]


def _geometry(model: Model, z: Array) -> mujoco.MjModel:
    """The machine in a context; the nominal one where the context does not compile, so that nothing moves in it."""
    try:
        return model.compile(z)
    except ModelError:
        return model.nominal()


def _ending(last: Step, slot: int) -> Literal["terminated", "truncated", "infeasible"]:
    if last.outcome.infeasible[slot]:
        return "infeasible"
    return "terminated" if last.outcome.terminated[slot] else "truncated"
