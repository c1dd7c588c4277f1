"""Gymnasium's own environments, to compare with."""

import sys
from types import ModuleType

import gymnasium

# Gymnasium imports it to write videos, which nobody does here.
sys.modules.setdefault("imageio", ModuleType("imageio"))


def twin(name: str) -> gymnasium.Env:
    """The environment without wrappers, e.g. of ``Hopper-v5``."""
    return gymnasium.make(name).unwrapped
