"""A tendon that is nothing but what an effect writes into it."""

from typing import Any

import mujoco
import numpy as np


def add_bare_tendon(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsTendon)
    """Add a tendon without any force; the model's default class for tendons does not apply to it."""
    tendon = spec.add_tendon(name=name)
    tendon.limited = tendon.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
    tendon.frictionloss, tendon.armature, tendon.springyield = 0.0, 0.0, 0.0
    tendon.stiffness, tendon.damping, tendon.springlength = np.zeros(3), np.zeros(3), np.zeros(2)
    return tendon
