"""A body that slides to rest: the closed form, and a slide of a model in which it is tried."""

import numpy as np

from dr_lab.envs.episodes import Episodes
from dr_lab.trajectory import Array


def sliding_distance(mass: float, friction: float, damping: float, speed: float) -> float:
    """How far a body slides with m v' = −f − d v until it rests: (m/d) (v − (f/d) ln(1 + d v/f)), in m."""
    return mass / damping * (speed - friction / damping * np.log1p(damping * speed / friction))


def slid(episodes: Episodes, start: Array, column: int, speed: float, steps: int) -> Array:
    """How far one joint of every episode has got from `start` (nq,) after so many control steps, shape (n,)."""
    qpos, qvel = (episodes.simulator.batch.bind(name) for name in ("qpos", "qvel"))
    qpos[:], qvel[:] = start, 0.0
    qvel[:, column] = speed
    hold = np.zeros((episodes.nsim, len(episodes.low)))
    for _ in range(steps):
        episodes.step(hold)
    assert (np.abs(qvel[:, column]) < 1e-3 * abs(speed)).all()
    return qpos[:, column] - start[column]
