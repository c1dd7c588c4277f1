"""The device on which policies learn."""

import torch

from dr_lab.errors import ConfigError

# What torch raises for a device that is not there, each kind in its own way.
_ABSENT = (AssertionError, ImportError, NotImplementedError, RuntimeError, TypeError)


def require_device(name: str) -> torch.device:
    """The device of this name.

    Raises:
        ConfigError: there is none here, or it cannot hold the double precision of a normaliser's statistics.
    """
    try:
        device = torch.device(name)
        torch.zeros((), dtype=torch.float64, device=device).item()
    except _ABSENT as error:
        raise ConfigError(
            f"device is {name}, with which torch cannot compute here; available are {', '.join(_present())}: give one "
            "of them, such as device=cpu."
        ) from error
    return device


def _present() -> list[str]:
    return ["cpu", *(f"cuda:{index}" for index in range(torch.cuda.device_count()))]
