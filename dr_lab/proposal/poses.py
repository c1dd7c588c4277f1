"""Places of a machine, drawn at random, at which it is asked what a joint or a sensor feels."""

from collections.abc import Iterator

import mujoco
import numpy as np

COUNT = 50  # a joint or an axis that none of so many moves is moved by none


def poses(model: mujoco.MjModel) -> Iterator[mujoco.MjData]:
    """As many places as `COUNT`, a rad or a metre or so about the model's own; one data for all of them."""
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    for _ in range(COUNT):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        mujoco.mj_forward(model, data)
        yield data
