"""Episodes of a policy with all that happens in them, for recordings."""

from collections.abc import Mapping
from typing import Literal, cast

import mujoco
import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Policy
from dr_lab.collectors.play import play
from dr_lab.envs.environment import Environment
from dr_lab.envs.slots import EpisodeSlots, Starts
from dr_lab.recorders.episode import Episode
from dr_lab.trajectory import Array


def record(
    environment: Environment, episodes: EpisodeSlots, policy: Policy, z: Array, starts: Starts | None = None
) -> list[Episode]:
    """Play one episode in each context, from its start to its end.

    Args:
        environment: what shows them.
        episodes: its slots that run side by side.
        policy: what acts.
        z: contexts, shape (k, n), k ≥ 1.
        starts: as `collectors.play.play` takes them.

    Returns:
        The episodes, called ``episode_1``, ``episode_2`` …
    """
    played = play(episodes, policy, z, starts)
    bounds = torch.from_numpy(episodes.low), torch.from_numpy(episodes.high)
    played["action"] = cast(Tensor, played["action"]).double().clamp(*bounds)
    found = []
    for i, values in enumerate(z):
        known = zip(episodes.space.parameters, values.tolist(), strict=True)
        course, context = cast(TensorDict, played[i]), {p.name: (value, p.unit) for p, value in known}
        found.append(as_episode(course, f"episode_{i + 1}", environment.scene(values), environment.seconds, context))
    return found


def as_episode(
    course: TensorDict,
    name: str,
    geometry: mujoco.MjModel,
    seconds: float,
    context: Mapping[str, tuple[float, str]],
) -> Episode:
    """One episode out of what was played.

    Args:
        course: size [t], in the layout of `collectors.play.play`, actions within their bounds.
        name: of the episode.
        geometry: the machine in its context.
        seconds: length of a control step.
        context: value and unit by parameter; empty where it is not known.
    """
    course = cast(TensorDict, course[: int(course["mask"].sum())])
    return Episode(
        name=name,
        context=context,
        geometry=geometry,
        time=np.arange(len(course) + 1, dtype=np.float64) * seconds,
        qpos=_before_and_after(course, "qpos"),
        qvel=_before_and_after(course, "qvel"),
        observation=_before_and_after(course, "observation").astype(np.float64),
        action=cast(Tensor, course["action"]).double().numpy(),
        reward=cast(Tensor, course["next", "reward"])[:, 0].numpy(),
        ended=_ending(course),
    )


def _before_and_after(course: TensorDict, key: str) -> Array:
    """The state before the first and after every step, shape (t + 1, …)."""
    return torch.cat([cast(Tensor, course[key]), cast(Tensor, course["next", key])[-1:]]).numpy()


def _ending(course: TensorDict) -> Literal["terminated", "truncated", "infeasible"]:
    if course["next", "infeasible"][-1]:
        return "infeasible"
    return "terminated" if course["next", "terminated"][-1] else "truncated"
