"""The boundary between the CPU, on which policies act, and the device on which they learn."""

import copy
from collections.abc import Iterator, Sequence
from itertools import chain
from types import MethodType
from typing import cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor, nn

from dr_lab.collectors.collector import Drive, Policy


class Boundary:
    """Policies learn on the CPU, too: they act as they are, and batches are where they belong."""

    def acting(self, policies: Sequence[Policy]) -> Sequence[Policy]:
        """What acts for some policies from here on, as they are then."""
        return policies

    def playing(self, drive: Drive) -> Drive:
        """What plays for a policy, or for commands, at once."""
        return drive

    def renew(self) -> None:
        """Let what acts be what the policies are now."""

    def across(self, batch: TensorDict) -> TensorDict:
        """A batch where the policies learn."""
        return batch


class DeviceBoundary(Boundary):
    """Policies learn on a device: copies on the CPU act for them, and batches are moved when they are whole.

    The copies draw by the random numbers of the policies themselves, so that the states of these say everything.

    Args:
        device: on which the policies learn.
    """

    def __init__(self, device: torch.device) -> None:
        self._device = device
        self._pairs: dict[int, tuple[Tensor, Tensor]] = {}  # a tensor of what acts, and the one that it follows

    def acting(self, policies: Sequence[Policy]) -> Sequence[Policy]:
        """Copies on the CPU, which `renew` renews."""
        copies = self._copies(policies)
        for copied, policy in zip(copies, policies, strict=True):
            for mine, theirs in zip(_tensors(copied), _tensors(policy), strict=True):
                self._pairs[id(theirs)] = mine, theirs
        return copies

    def playing(self, drive: Drive) -> Drive:
        """A copy on the CPU of a policy that is on a device."""
        if isinstance(drive, np.ndarray) or all(each.device.type == "cpu" for each in _tensors(drive)):
            return drive
        return self._copies([drive])[0]

    @torch.no_grad()
    def renew(self) -> None:
        """Let the copies be what the policies are now."""
        for mine, theirs in self._pairs.values():
            mine.copy_(theirs)

    def across(self, batch: TensorDict) -> TensorDict:
        """The batch on the device."""
        return cast(TensorDict, batch.to(self._device))

    def _copies(self, policies: Sequence[Policy]) -> Sequence[Policy]:
        return on_cpu(policies, {id(each): each for policy in policies for each in _generators(policy)})


def boundary_to(device: torch.device) -> Boundary:
    """What lies between the CPU and a device."""
    return Boundary() if device.type == "cpu" else DeviceBoundary(device)


def on_cpu(policies: Sequence[Policy], kept: dict[int, torch.Generator] | None = None) -> Sequence[Policy]:
    """Copies of policies on the CPU; what some of them share, their copies share.

    Args:
        policies: torch modules, or methods of some.
        kept: random numbers that the copies draw by themselves, by their identity; all else is copied.
    """
    copies = copy.deepcopy(tuple(policies), dict(kept or {}))
    for module in chain.from_iterable(map(_modules, copies)):
        module.to("cpu")
    return copies


def _modules(policy: Policy) -> Iterator[nn.Module]:
    """A policy's module; none of a policy that is made of something else."""
    found = policy.__self__ if isinstance(policy, MethodType) else policy
    return iter([found] if isinstance(found, nn.Module) else [])


def _tensors(policy: Policy) -> Iterator[Tensor]:
    return chain.from_iterable(chain(each.parameters(), each.buffers()) for each in _modules(policy))


def _generators(policy: Policy) -> Iterator[torch.Generator]:
    for module in chain.from_iterable(each.modules() for each in _modules(policy)):
        own = getattr(module, "generator", None)
        if isinstance(own, torch.Generator):
            yield own
