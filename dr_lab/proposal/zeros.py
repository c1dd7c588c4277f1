"""Which joints' zeros the equation of motion feels: a turret's is free, as it turns about the vertical."""

import mujoco
import numpy as np

from dr_lab.trajectory import Array

OFFSETS = (np.pi, np.pi / 2, -np.pi / 2)  # rad, of angles that count from another direction
_STATES = 4  # motions drawn at random; one would do, were it not for chance
_ROUNDING = 1e-9  # share of the forces


def felt_zeros(model: mujoco.MjModel) -> list[bool]:
    """Whether forces change if a joint counts from another direction, joint by joint; every joint has one coordinate.

    About an axis along gravity, before which nothing moves, all directions are alike: of such an angle the equation of
    motion says nothing. Actuators are left aside, as `mj_inverse` does.
    """
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    states = [rng.normal(size=(3, model.nv)) for _ in range(_STATES)]
    as_it_is = [_force(model, data, *state) for state in states]
    return [
        any(
            not np.allclose(
                _force(model, data, place + offset * unit, speed, change), force, 0.0, _ROUNDING * np.abs(force).max()
            )
            for (place, speed, change), force in zip(states, as_it_is, strict=True)
            for offset in OFFSETS
        )
        for unit in np.eye(model.nv)
    ]


def _force(model: mujoco.MjModel, data: mujoco.MjData, place: Array, speed: Array, change: Array) -> Array:
    data.qpos[:], data.qvel[:], data.qacc[:] = place, speed, change
    mujoco.mj_inverse(model, data)
    return data.qfrc_inverse.copy()
