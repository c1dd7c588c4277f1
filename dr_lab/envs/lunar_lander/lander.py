"""Lunar landers with engines of their own strength; what worker processes import, hence without torch and MuJoCo."""

import warnings
from collections.abc import Sequence
from types import FunctionType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dr_lab.envs.slots import Flags, Rows
from dr_lab.trajectory import Array

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # SWIG's, which crashes Python where warnings are errors
    from gymnasium.envs.box2d import lunar_lander as original

SECONDS = 1.0 / original.FPS
"""Length of a control step, s."""

_WIDTH = 8  # of an observation
_JOINTS = 5  # x, z, angle, and one for each leg


class Lander(original.LunarLander):
    """gymnasium's continuous LunarLander-v3, whose engines have the powers that its episode begins with.

    gymnasium's `step` reads both powers from names of its module, which all landers share. Each lander therefore runs
    the very code of that `step` beside a copy of these names, in which its own powers stand.
    """

    def __init__(self) -> None:
        super().__init__(continuous=True)
        self._names = dict(vars(original))
        self._step = FunctionType(original.LunarLander.step.__code__, self._names)

    def begin(self, seed: int, powers: Array) -> Array:
        """Begin an episode; everything random in it, the engines' dispersion included, follows from the seed.

        Args:
            seed: of the episode.
            powers: of main and side engines, shape (2,).

        Returns:
            The observation, shape (8,).
        """
        self._names["MAIN_ENGINE_POWER"], self._names["SIDE_ENGINE_POWER"] = powers.tolist()
        return self.reset(seed=seed)[0].astype(float)

    def step(self, action: Array) -> tuple[NDArray[np.float32], float, bool, Literal[False], dict[str, Any]]:
        """As gymnasium's, with this lander's powers."""
        return self._step(self, action)

    @property
    def state(self) -> tuple[list[float], list[float]]:
        """Positions of the joints of ``conf/env/lunar_lander.xml`` and their velocities, m, rad, m/s, rad/s."""
        assert self.lander is not None
        hull, legs = self.lander, self.legs
        x, z = hull.position.x - original.VIEWPORT_W / original.SCALE / 2, hull.position.y - self.helipad_y
        position = [x, z, hull.angle, *(leg.angle - hull.angle for leg in legs)]
        turning = [leg.angularVelocity - hull.angularVelocity for leg in legs]
        return position, [hull.linearVelocity.x, hull.linearVelocity.y, hull.angularVelocity, *turning]


class Landers:
    """Some landers side by side, in this process.

    Args:
        count: number of landers.
    """

    def __init__(self, count: int) -> None:
        self._landers = [Lander() for _ in range(count)]

    def begin(self, rows: Rows, seeds: Sequence[int], powers: Array) -> Array:
        """Begin episodes of k landers with seeds (k,) and powers (k, 2); gives the observations (k, 8)."""
        begun = [self._landers[row].begin(seed, own) for row, seed, own in zip(rows, seeds, powers, strict=True)]
        return np.array(begun, dtype=float).reshape(-1, _WIDTH)

    def step(self, rows: Rows, action: Array) -> tuple[Array, Array, Flags]:
        """Observations (k, 8), rewards (k,) and terminations (k,) of a control step of k landers; `action` (k, 2)."""
        observation, reward, terminated = np.empty((len(rows), _WIDTH)), np.empty(len(rows)), np.empty(len(rows), bool)
        for k, (row, own) in enumerate(zip(rows, action, strict=True)):
            observation[k], reward[k], terminated[k], _, _ = self._landers[row].step(own)
        return observation, reward, terminated

    def replay(self, seeds: Sequence[int], powers: Array, actions: Sequence[Array]) -> Array:
        """Begin all episodes anew and play the actions (t, 2) of each; gives the observations (n, 8) that follow.

        A Box2D world cannot be copied or stored: it is the same again once the same has happened in it.
        """
        observation = self.begin(np.arange(len(self._landers)), seeds, powers)
        for row, course in enumerate(actions):
            for action in course:
                observation[row] = self._landers[row].step(action)[0]
        return observation

    def state(self) -> tuple[Array, Array]:
        """Positions and velocities, shape (n, 5) each."""
        position, velocity = zip(*(lander.state for lander in self._landers), strict=True)
        return np.array(position).reshape(-1, _JOINTS), np.array(velocity).reshape(-1, _JOINTS)
