"""Many networks of one architecture in one module, so that a layer of all is one batched matrix product."""

from collections.abc import Sequence
from itertools import chain

import torch
from torch import nn


def restack(together: nn.Module, members: Sequence[nn.Module]) -> None:
    """Let one module hold copies of the parameters and buffers of N, along a first dimension.

    Vectors (k,) become (N, 1, k), so that they broadcast over the rows of each network; all else (…) becomes (N, …).

    Args:
        together: as each of the members, whose tensors are put in the place of its own.
        members: N modules of one architecture.
    """
    values = [dict(chain(one.named_parameters(), one.named_buffers())) for one in members]
    for name, tensor in chain(together.named_parameters(), together.named_buffers()):
        rows = torch.stack([each[name].detach() for each in values])
        tensor.data = rows.unsqueeze(1) if values[0][name].dim() == 1 else rows
