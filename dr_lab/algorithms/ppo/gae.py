"""Generalised advantage estimation."""

import torch
from torch import Tensor


def advantages(
    reward: Tensor, value: Tensor, next_value: Tensor, terminated: Tensor, done: Tensor, gamma: float, lam: float
) -> Tensor:
    """A_t = δ_t + γλ (1 − done_t) A_{t+1} with δ_t = r_t + γ (1 − terminated_t) V(s'_t) − V(s_t).

    s'_t is the episode's own next observation. So an episode cut by the time limit goes on in its value, one that
    terminated is worth nothing after its end, and neither leaks into the episode that follows.

    Args:
        reward: r, shape (n, steps), as all that follows.
        value: V(s).
        next_value: V(s').
        terminated: whether the episode came to its end.
        done: whether it ended for any reason.
        gamma: discount γ per step.
        lam: λ; 0 trusts the value network, 1 the rewards.

    Returns:
        A, shape (n, steps).

    Source: Schulman et al. 2016, equation 16; Pardo et al. 2018 for time limits.
    """
    delta = reward + gamma * next_value * ~terminated - value
    decay = gamma * lam * (~done).to(delta.dtype)
    result = torch.empty_like(delta)
    running = torch.zeros_like(delta[:, 0])
    for t in reversed(range(delta.shape[1])):
        running = delta[:, t] + decay[:, t] * running
        result[:, t] = running
    return result
