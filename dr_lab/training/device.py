"""The device on which policies learn."""

import torch

from dr_lab.errors import ConfigError


def require_device(name: str) -> torch.device:
    """The device of this name.

    Raises:
        ConfigError: there is none here, or it cannot hold the double precision of a normaliser's statistics.
    """
    try:
        device = torch.device(name)
        torch.zeros((), dtype=torch.float64, device=device).item()
    except (
        AssertionError,
        ImportError,
        NotImplementedError,
        RuntimeError,
        TypeError,
    ) as error:  # as each kind of device has it
        raise ConfigError(
            f"device is {name}, which torch cannot compute with here; expected one of {', '.join(_present())}: "
            "device=cpu always is."
        ) from error
    return device


def _present() -> list[str]:
    return ["cpu", *(f"cuda:{index}" for index in range(torch.cuda.device_count()))]
