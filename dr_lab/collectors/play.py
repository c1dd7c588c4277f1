"""Whole episodes of a policy, or of commands, in contexts of one's choice, with all that happens in them."""

import math
from dataclasses import replace
from typing import cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Drive
from dr_lab.envs.batched_env import single
from dr_lab.envs.slots import EpisodeSlots, Flags, Starts, StepOutcome
from dr_lab.trajectory import Array

_FLAGS = ("terminated", "truncated", "infeasible", "done")


def play(episodes: EpisodeSlots, drive: Drive, z: Array, starts: Starts | None = None) -> TensorDict:
    """Play one episode in each context, from its start to its end.

    Args:
        episodes: slots that run side by side; more contexts than slots are played one load after the other.
        drive: what acts; commands (k, steps, nu) end with the last the episodes that still go on.
        z: contexts, shape (k, n), k ≥ 1.
        starts: positions (k, nq) and velocities (k, nv) with which they begin; None draws them, as the task does.

    Returns:
        Size [k, t], t being the length of the longest. ``mask`` (k, t) is true for the steps of an episode; all else is
        0 beyond its end. The other keys are those of a collector's batch, without log-probabilities, and the physical
        state before and after each step: ``qpos``, ``qvel``, ``("next", "qpos")``, ``("next", "qvel")``. State and
        reward are float64, observation, action and context float32.
    """
    width = episodes.nsim
    loads = [slice(first, first + width) for first in range(0, len(z), width)]
    given = [None if starts is None else (starts[0][load], starts[1][load]) for load in loads]
    acting = [drive[load] if isinstance(drive, np.ndarray) else drive for load in loads]
    parts = [_play_load(episodes, *each) for each in zip(acting, (z[load] for load in loads), given, strict=True)]
    longest = max(part.shape[1] for part in parts)
    return cast(TensorDict, torch.cat([_lengthened(part, longest) for part in parts]))


def undiscounted(played: TensorDict) -> Array:
    """Return of each episode that `play` gave, shape (k,); NaN where the context is infeasible."""
    returns, infeasible = outcomes(played)
    return np.where(infeasible, np.nan, returns)


def outcomes(played: TensorDict) -> tuple[Array, Flags]:
    """Return of each episode, as the environment declares it where it is infeasible, and where it is, shape (k,)."""
    reward, infeasible = (cast(Tensor, played["next", key])[..., 0].numpy() for key in ("reward", "infeasible"))
    returns = np.cumsum(reward, axis=1)[:, -1]  # in the order of time, which `sum` does not keep
    return returns, np.any(infeasible, axis=1)


def _play_load(episodes: EpisodeSlots, drive: Drive, z: Array, starts: Starts | None) -> TensorDict:
    """At most as many episodes as there are slots; the slots that are left over repeat the last."""
    count, rows = len(z), np.minimum(np.arange(episodes.nsim), len(z) - 1)
    episodes.give_contexts(z[rows])
    episodes.begin(np.arange(episodes.nsim), None if starts is None else (starts[0][rows], starts[1][rows]))
    observations, states = [single(episodes.observation)], [episodes.state]
    actions, outcomes, masks = list[Tensor](), list[StepOutcome](), list[np.ndarray]()
    going = np.ones(episodes.nsim, bool)
    recited = isinstance(drive, np.ndarray)
    acts, most = (_Recited(drive[rows]), drive.shape[1]) if recited else (drive, math.inf)
    while going[:count].any() and len(actions) < most:
        with torch.no_grad():
            actions.append(acts(observations[-1]))
        outcomes.append(episodes.step(actions[-1].numpy()))
        masks.append(going)
        observations.append(single(outcomes[-1].observation))
        states.append(episodes.state)
        going = going & ~outcomes[-1].done
    outcomes[-1] = replace(outcomes[-1], truncated=outcomes[-1].truncated | going)  # where the commands end
    mask = torch.from_numpy(np.stack(masks, 1)[:count])
    qpos, qvel = (np.stack(each, 1) for each in zip(*states, strict=True))
    course = {
        "observation": torch.stack(observations, 1),
        "qpos": torch.from_numpy(qpos),
        "qvel": torch.from_numpy(qvel),
    }
    return _laid_out(course, torch.stack(actions, 1), outcomes, mask, single(z))


class _Recited:
    """Commands (n, steps, nu), one after the other."""

    def __init__(self, commands: Array) -> None:
        self._next = iter(np.moveaxis(commands, 1, 0))

    def __call__(self, observation: Tensor) -> Tensor:
        del observation
        return torch.from_numpy(next(self._next))


def _laid_out(
    course: dict[str, Tensor], action: Tensor, outcomes: list[StepOutcome], mask: Tensor, context: Tensor
) -> TensorDict:
    """The tensordict: of each episode's course (n, t + 1, …) what is before a step and what is after it."""
    count, steps = mask.shape
    reached = torch.cat([torch.ones(count, 1, dtype=torch.bool), mask], 1)
    course = {key: _zero_beyond(values[:count], reached) for key, values in course.items()}
    flags = {key: np.stack([getattr(outcome, key) for outcome in outcomes], 1)[:count] for key in _FLAGS}
    reward = np.stack([outcome.reward for outcome in outcomes], 1)[:count]
    context = context[:, None].expand(-1, steps, -1)
    after = {key: torch.from_numpy(values)[..., None] for key, values in {"reward": reward, **flags}.items()}
    after = {key: _zero_beyond(values, mask) for key, values in after.items()}
    after |= {"context": context} | {key: values[:, 1:] for key, values in course.items()}
    now = {"action": _zero_beyond(action[:count], mask), "context": context, "mask": mask}
    now |= {key: values[:, :-1] for key, values in course.items()}
    return TensorDict({**now, "next": TensorDict(after, batch_size=mask.shape)}, batch_size=mask.shape)


def _zero_beyond(values: Tensor, mask: Tensor) -> Tensor:
    return torch.where(mask[..., None], values, torch.zeros((), dtype=values.dtype))


def _lengthened(part: TensorDict, steps: int) -> TensorDict:
    """With rows of zeros up to so many steps; the context goes on."""
    missing = steps - part.shape[1]
    if not missing:
        return part
    more = cast(TensorDict, torch.zeros_like(part[:, -1:].expand(len(part), missing)))  # pyright: ignore[reportCallIssue,reportArgumentType]
    for key in ("context", ("next", "context")):
        more[key] = part[key][:, -1:].expand(-1, missing, -1)
    return cast(TensorDict, torch.cat([part, more], 1))
