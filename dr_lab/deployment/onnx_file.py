"""A policy as an ONNX file: observation in, action out, without dr_lab or PyTorch."""

import logging
import warnings
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import onnx
import onnxruntime
import torch
from torch import Tensor, nn

from dr_lab.bounds import Count, Positive, at_most, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class OnnxSettings:
    """How the file is written and checked.

    Attributes:
        episodes: played in the model; their observations tell what each input is, and check the file.
        opset: version of ONNX' operators.
        tolerance: largest difference to the policy that is accepted, in the range of a command.

    Raises:
        ConfigError: a number is out of its range.
    """

    episodes: Count
    opset: Count
    tolerance: Annotated[Positive, at_most(1.0)]

    def __post_init__(self) -> None:
        require_bounds(self, "onnx")


class Bounded(nn.Module):
    """What a policy does to a machine: a = clip(π(o), low, high), as the environment cuts actions off.

    Args:
        policy: without exploration.
        low: lowest action, shape (a,).
        high: highest action, shape (a,).
    """

    low: Tensor
    high: Tensor

    def __init__(self, policy: Policy, low: Array, high: Array) -> None:
        super().__init__()
        self._policy, owner = policy, getattr(policy, "__self__", policy)
        if isinstance(owner, nn.Module):
            self.owner = owner  # whose parameters belong to this module, so that they are written with it
        self.register_buffer("low", torch.from_numpy(low).float())
        self.register_buffer("high", torch.from_numpy(high).float())

    def forward(self, observation: Tensor) -> Tensor:
        """Actions (n, a) for observations (n, o)."""
        return torch.maximum(torch.minimum(self._policy(observation), self.high), self.low)


def onnx_of(policy: Bounded, width: int, described: str, settings: OnnxSettings) -> bytes:
    """The file: input ``observation`` (1, o) and output ``action`` (1, a), both float32.

    Args:
        policy: what is written.
        width: o.
        described: what inputs and outputs are; kept in the file under ``dr_lab``.
        settings: how it is written.

    Raises:
        ConfigError: the exporter has no such version of the operators.
    """
    for library in (
        "torch.onnx",
        "onnxscript",
    ):  # they warn of torchvision, which no policy needs, and print tracebacks
        logging.getLogger(library).setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # of torch's own use of its trees
        program = torch.onnx.export(
            policy.eval(),
            (torch.zeros(1, width),),
            input_names=["observation"],
            output_names=["action"],
            opset_version=settings.opset,
            dynamo=True,
            verbose=False,
        )
    assert program is not None
    model = program.model_proto
    written = model.opset_import[0].version
    if written != settings.opset:
        raise ConfigError(
            f"onnx.opset is {settings.opset}; PyTorch's exporter wrote version {written}, and cannot change that. "
            f"Leave it out, or give {written}."
        )
    onnx.helper.set_model_props(model, {"dr_lab": described})
    return model.SerializeToString()


def difference(file: bytes, policy: Bounded, observation: Array, settings: OnnxSettings) -> float:
    """Largest difference of the file's actions from those of the policy, in the range of a command.

    Args:
        file: as `onnx_of` gives it.
        policy: what it was made of.
        observation: for which both act, shape (n, o).
        settings: how large it may be.

    Raises:
        DrLabError: it is larger than the tolerance.
    """
    seen = observation.astype(np.float32)
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    action = np.stack([np.asarray(session.run(["action"], {"observation": row})[0])[0] for row in seen[:, None]])
    with torch.no_grad():
        expected = policy(torch.from_numpy(seen))
    found = float((abs(action - expected.numpy()) / (policy.high - policy.low).numpy()).max())
    if not found <= settings.tolerance:
        raise DrLabError(
            f"The ONNX file acts otherwise than the policy: by {found:.2g} of the range of a command, where at most "
            f"onnx.tolerance={settings.tolerance:g} is accepted. Another version of the operators may help: onnx.opset."
        )
    return found
