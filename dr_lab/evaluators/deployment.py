"""What it takes to deploy a policy: time for an action, memory of its parameters."""

import time

import numpy as np
import torch
from torch import Tensor, nn

from dr_lab.collectors.collector import Policy


def inference_seconds(policy: Policy, observation: Tensor, calls: int) -> float:
    """Median time in s of one action for one observation (1, o), over so many calls."""
    taken = np.empty(calls)
    with torch.no_grad():
        for call in range(calls):
            began = time.perf_counter()
            policy(observation)
            taken[call] = time.perf_counter() - began
    return float(np.median(taken))


def parameter_bytes(policy: object) -> float:
    """Memory of the parameters of the module that acts, one of whose methods a policy may be; NaN where it is none."""
    module = getattr(policy, "__self__", policy)
    if not isinstance(module, nn.Module):
        return float("nan")
    return float(sum(each.numel() * each.element_size() for each in module.parameters()))
