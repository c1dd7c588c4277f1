"""Activations along a motion that is given, not simulated."""

import numpy as np
from mujoco.batch import Batch

from dr_lab.trajectory import Array


def follow(batch: Batch, qpos: Array, qvel: Array, controls: Array, act: Array) -> Array:
    """MuJoCo steps the batch, and before every step the motion is put back to the given one.

    Args:
        batch: n simulations, just reset, whose time and histories of delays are those of the first step.
        qpos: positions of each step, shape (w, p, nq); simulation i takes those of row i mod w.
        qvel: velocities, shape (w, p, nv).
        controls: controls, shape (n, p, nu).
        act: activations before the first step, shape (w, na).

    Returns:
        Activations after each step, shape (p, n, na).
    """
    times = batch.nsim // len(qpos)
    place, speed, kept, control = (batch.bind(name) for name in ("qpos", "qvel", "act", "ctrl"))
    kept[:] = np.tile(act, (times, 1))
    found = np.empty((qpos.shape[1], *kept.shape))
    for k in range(len(found)):
        place[:], speed[:] = np.tile(qpos[:, k], (times, 1)), np.tile(qvel[:, k], (times, 1))
        control[:] = controls[:, k]
        batch.step()
        found[k] = kept
    return found
