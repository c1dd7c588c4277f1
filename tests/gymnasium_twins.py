"""Gymnasium's own environments, to compare with."""

import sys
from types import ModuleType
from typing import Any

import gymnasium

# Gymnasium imports it to write videos, which nobody does here.
sys.modules.setdefault("imageio", ModuleType("imageio"))


def twin(id: str, **options: Any) -> gymnasium.Env:  # noqa: ANN401 (gymnasium's)
    """The environment without wrappers, e.g. of ``Hopper-v5``."""
    return gymnasium.make(id, **options).unwrapped
